// What is pinned of the motion to come: buttons that pin, the list of what is, and everything by the keyboard too.
export function render(part) {
  const {model} = part
  const send = (what, more = {}) => model.send_msg({do: what, ...more})
  // of the page, not of this drawing: a panel drawn anew is as open as it was
  const folds = window.motionloomFolds ??= new Map()
  const fold = (text, atFirst, body, small) => {
    const open = folds.get(text) ?? atFirst
    const count = h("span", {class: "count", hidden: true})
    const head = h("button", {class: `head ${small ? "small" : ""}`, type: "button", "aria-expanded": String(open)}, icon("down"), text, count)
    body.hidden = !open
    head.addEventListener("click", () => {
      body.hidden = !body.hidden
      head.setAttribute("aria-expanded", String(!body.hidden))
      folds.set(text, !body.hidden)
      if (!body.hidden) inSight(body)
    })
    return {head, count, open: () => { if (body.hidden) head.click() }}
  }
  const tools = h("div", {class: "tools", role: "group", "aria-label": "Pin"})
  const list = h("ul", {class: "list", "aria-label": "Pinned"})
  const fault = h("div", {role: "alert"})
  const loop = h("input", {type: "checkbox", id: "loop", onchange: () => { model.loop = loop.checked }})
  const clear = h("button", {class: "link", type: "button", onclick: () => send("clear")}, "Clear")
  const numbers = byNumbers(model, send)
  const typed = fold("With the keyboard", false, numbers, true)
  const told = h("span", {class: "vh", role: "status"})
  const body = h("div", {class: "body"}, tools, list, h("div", {class: "row"}, h("label", {for: "loop", class: "check"}, loop, "Loop: end as it began"), clear), fault, typed.head, numbers, told)
  const whole = fold("Constraints", window.innerHeight >= 860, body)
  mount(part, [h("section", {class: "fold", "aria-label": "Constraints"}, whole.head, body)])
  model.on("items", () => { if (model.items.length) whole.open(); inSight(list) })
  watch(model, ["items", "tool", "loop", "ready", "error"], () => {
    const count = model.items.length + Number(model.loop)
    const act = (what, text, title) => h("button", {class: "btn", type: "button", "data-key": what, disabled: !model.ready, title, onclick: () => send(what)}, icon(what), text)
    const draw = (tool, text, title) => h("button", {
      class: `btn ${model.tool === tool ? "on" : ""}`, type: "button", "data-key": tool, disabled: !model.ready, "aria-pressed": String(model.tool === tool), title,
      onclick: () => { model.tool = model.tool === tool ? "none" : tool },
    }, icon(tool), text)
    redraw(tools,
      act("pose", "Pin this pose", "The pose of the picked take at the playhead, at that same time of the motion to come"),
      act("frames", "Keep frames", "Keep these frames: the picked take from its start up to the playhead; the motion goes on from there"),
      draw("path", "Draw a path", "Draw on the floor of the stage where the body is to go (Esc leaves)"),
      draw("joint", "Pin a joint", "Drag a joint of the figure to where it is to be at the playhead (Esc leaves)"))
    redraw(list, ...model.items.map(([key, text]) => h("li", {"data-key": `${key} ${text}`}, h("span", {}, text),
      h("button", {class: "mark", type: "button", "aria-label": `Remove ${text}`, title: "Remove", onclick: () => { send("remove", {key}); (list.querySelector("button") ?? whole.head).focus() }}, icon("cross")))))
    list.hidden = model.items.length === 0
    loop.checked = model.loop
    clear.hidden = count === 0
    whole.count.hidden = count === 0
    whole.count.textContent = String(count)
    told.textContent = count ? `${count} pinned: ${[...model.items.map(([, text]) => text), ...(model.loop ? ["loop"] : [])].join("; ")}` : "Nothing pinned"
    redraw(fault, model.error && h("p", {class: "fault"}, model.error))
  })
}
/** As much of it as there is room for, once it is drawn. */
function inSight(node) {
  requestAnimationFrame(() => node.scrollIntoView({block: "nearest"}))
}
/** A path and a joint's place, typed. */
function byNumbers(model, send) {
  const line = (input, label, button, act) => {
    input.addEventListener("keydown", (event) => { if (event.key === "Enter" && !event.ctrlKey && !event.metaKey) { event.preventDefault(); act() } })
    return [h("label", {for: input.id}, label), h("div", {class: "typed"}, input, h("button", {class: "btn", type: "button", onclick: act}, button))]
  }
  const path = h("input", {class: "field", id: "path-points", autocomplete: "off", spellcheck: "false", placeholder: "0,0 0,1 1,2"})
  const joint = h("select", {class: "field", id: "pin-joint"}, ...model.joints.map((name) => h("option", {value: name}, name.replaceAll("_", " "))))
  joint.value = "left_wrist"
  const place = h("input", {class: "field", id: "pin-place", autocomplete: "off", spellcheck: "false", placeholder: "0.3, 1.2, 0.4"})
  return h("div", {class: "numbers"},
    ...line(path, "Path: points x,z in metres", "Set", () => send("path_text", {text: path.value})),
    h("label", {for: "pin-joint"}, "Joint"), joint,
    ...line(place, "Its place x, y, z at the playhead, metres", "Pin", () => send("joint_text", {joint: joint.value, text: place.value})))
}
