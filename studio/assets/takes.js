// The gallery: takes by draw, newest first; pick, star, keep, compare, again, delete.
export function render(part) {
  const {model} = part
  let shown = "all"
  const head = h("div", {class: "head"})
  const list = h("div", {class: "list"})
  const foot = h("div", {class: "foot", role: "toolbar", "aria-label": "Selected take"})
  mount(part, [head, list, foot])
  const send = (what, id) => model.send_msg({do: what, id: id ?? model.selected})
  const picks = () => [...list.querySelectorAll(".pick")]
  list.addEventListener("keydown", (event) => {
    arrows(event, picks)
    const id = event.target.dataset?.id
    const what = {f: "favourite", k: "accepted", c: "compare", Delete: "delete", a: "again", y: "style"}[event.key]
    if (id && event.key === "t" && !event.ctrlKey && !event.metaKey && !event.altKey) {
      event.preventDefault()
      event.stopPropagation()
      window.dispatchEvent(new CustomEvent("motionloom:tag"))
    }
    if (id && what && !event.ctrlKey && !event.metaKey && !event.altKey) { event.preventDefault(); event.stopPropagation(); send(what, id) }
  })
  list.addEventListener("focusin", (event) => {
    const id = event.target.classList?.contains("pick") && event.target.dataset.id
    if (id && event.target.matches(":focus-visible")) model.selected = id
  })
  let waiting = 0
  const look = (event) => {
    const text = event.target.value
    clearTimeout(waiting)
    waiting = setTimeout(() => { model.search = text }, 120)
  }
  const field = () => h("input", {
    class: "field find", type: "search", "data-key": "find", value: model.search, placeholder: "Find: walk  tag:good  is:starred", "aria-label": "Find takes",
    title: "Words, or action: prompt: style: engine: tag: with a word, or is:starred is:kept is:imported", oninput: look,
    onkeydown: (event) => {
      if (event.key === "ArrowDown") { event.preventDefault(); picks()[0]?.focus() }
      else if (event.key === "Escape" && event.target.value) { event.stopPropagation(); event.target.value = ""; model.search = "" }
    },
  })
  const draw = () => {
    const fits = {all: () => true, kept: (take) => take.accepted, starred: (take) => take.favourite}
    const takes = model.takes.filter(fits[shown]).filter(({id}) => model.found === null || model.found.includes(id))
    redraw(head, h("h4", {role: "status"}, counted(takes.length, model.takes.length)),
      h("div", {class: "filters", role: "radiogroup", "aria-label": "Show"}, ...[["all", "All"], ["kept", "Kept"], ["starred", "★"]].map(([key, text]) =>
        h("button", {type: "button", role: "radio", "data-key": key, "aria-checked": String(key === shown), "aria-label": key === "starred" ? "Starred" : text, onclick: () => { shown = key; draw() }}, text))),
      h("button", {class: "btn icon quiet", type: "button", "data-key": "clear", "aria-label": "Clear takes that are neither kept nor starred", title: "Clear takes that are neither kept nor starred", disabled: model.takes.length === 0, onclick: () => send("clear", "")}, icon("broom")),
      model.takes.length > 0 && field())
    redraw(list, ...groups(takes).flatMap((group) => [
      h("div", {class: "group", "data-key": `head ${group[0].group}`}, h("span", {class: "subject"}, group[0].subject), h("span", {}, group[0].about)),
      h("ul", {"data-key": group[0].group}, ...group.map((take) => card(model, take, send))),
    ]), takes.length === 0 && h("p", {class: "hint none"}, empty(model, shown)))
    const take = model.takes.find(({id}) => id === model.selected)
    const tool = (what, name, text, on, title) => h("button", {
      class: `btn ${on ? "on" : ""}`, type: "button", "data-key": what, disabled: !take, "aria-pressed": on == null ? null : String(on), title, onclick: () => send(what),
    }, icon(name), text)
    redraw(foot, tool("accepted", "check", take?.accepted ? "Kept" : "Keep", Boolean(take?.accepted), "Keep this take (K)"),
      h("button", {class: "btn", type: "button", "data-key": "again", disabled: !take?.again || model.busy, title: "The same settings on another seed (A)", onclick: () => send("again")}, icon("again"), "Again"),
      tool("compare", "compare", "Compare", model.compared.includes(model.selected), "Show it beside others, in sync (C); Ctrl-click ticks, Shift-click ticks a row"),
      h("button", {class: "btn icon", type: "button", "data-key": "delete", disabled: !take, "aria-label": "Delete this take", title: "Delete (Del); undo brings it back", onclick: () => send("delete")}, icon("trash")))
  }
  watch(model, ["takes", "selected", "compared", "shown", "thumbnails", "busy", "found", "search"], draw)
  model.on("selected", () => requestAnimationFrame(() => list.querySelector(`[data-id="${CSS.escape(model.selected)}"]`)?.closest("li").scrollIntoView({block: "nearest"})))
}
function counted(seen, all) {
  if (!all) return "Takes"
  const whole = `${all} take${all === 1 ? "" : "s"}`
  return seen < all ? `${seen} of ${whole}` : whole
}
function empty(model, shown) {
  if (model.found?.length === 0) return `No take fits “${model.search}”.`
  if (model.takes.length) return shown === "kept" ? "No take is kept yet." : "No take is starred yet."
  return model.busy ? "The first takes are on their way…" : "Generate or import a motion: it appears here."
}
/** The colour the take has on the stage. */
function dot(model, take) {
  const place = model.shown.indexOf(take.id)
  return place >= 0 && h("span", {class: "dot", style: `background: ${model.palette[place % model.palette.length]}`})
}
function groups(takes) {
  const found = new Map()
  for (const take of takes) found.set(take.group, [...(found.get(take.group) ?? []), take])
  return [...found.values()].reverse()
}
/** A click picks; with Ctrl it ticks for comparison, with Shift it ticks all from the picked one to here. */
function choose(model, take, event) {
  const ids = [...event.currentTarget.closest(".list").querySelectorAll(".pick")].map((pick) => pick.dataset.id)
  const [from, to] = [ids.indexOf(model.selected), ids.indexOf(take.id)].sort((a, b) => a - b)
  if (event.shiftKey && from >= 0) model.send_msg({do: "compare_these", ids: ids.slice(from, to + 1)})
  else if (event.ctrlKey || event.metaKey) model.send_msg({do: "compare", id: take.id})
  else model.selected = take.id
}
function card(model, take, send) {
  const on = take.id === model.selected
  const ticked = model.compared.includes(take.id)
  const picture = model.thumbnails[take.id]
  const spoken = [take.title, take.subject, take.caption && `shows: ${take.caption.replace(/\.$/, "")}`, take.line, ...take.measures.map(({name, text, level}) => `${name} ${text}, ${level}`), take.accepted && "kept", take.favourite && "starred", take.edits.length > 0 && `shown with ${take.edits.join(", ")}`, take.tags.length > 0 && `tagged ${take.tags.join(", ")}`].filter(Boolean).join(", ")
  return h("li", {class: `take ${on ? "on" : ""}`, "data-key": take.id},
    h("button", {class: "pick", type: "button", "data-id": take.id, "aria-pressed": String(on), "aria-label": spoken, title: take.caption || null, onclick: (event) => choose(model, take, event),
      draggable: "true", ondragstart: (event) => event.dataTransfer.setData("application/x-motionloom-block", JSON.stringify({kind: "clip", take: take.id}))}),
    h("span", {class: "picture"}, picture ? h("img", {src: picture, alt: "", width: "58", height: "58"}) : icon("person")),
    h("div", {class: "text"},
      h("div", {class: "title"}, dot(model, take), take.title, take.accepted && h("span", {class: "kept", title: "Kept"}, icon("check")), take.edits.length > 0 && h("span", {class: "edited", title: `Shown with: ${take.edits.join(", ")}`}, icon("pen"))),
      h("div", {class: "line"}, ...take.tags.map((tag) => h("span", {class: "tag", "data-key": `tag ${tag}`}, tag)), take.line),
      h("div", {class: "line measures"}, ...take.measures.map(({word, level, name, text, real}) => h("span", {class: level, title: `${name}: ${text}${real ? ` (real motion: ${real})` : ""}`}, word)))),
    h("div", {class: "marks"},
      h("button", {class: "mark", type: "button", tabindex: "-1", "aria-label": `Another manner of ${take.title}`, title: "In another manner (Y)", onclick: () => send("style", take.id)}, icon("mask")),
      h("button", {class: `mark star ${take.favourite ? "on" : ""}`, type: "button", tabindex: "-1", "aria-pressed": String(take.favourite), "aria-label": `Star ${take.title}`, title: "Star (F)", onclick: () => send("favourite", take.id)}, icon("star", take.favourite)),
      h("button", {class: `mark ${ticked ? "on" : ""}`, type: "button", tabindex: "-1", "aria-pressed": String(ticked), "aria-label": `Compare ${take.title}`, title: "Compare (C)", onclick: () => send("compare", take.id)}, icon("compare"))))
}
