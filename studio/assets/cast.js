// The characters that are kept: wear, rename, delete.
export function render(part) {
  const {model} = part
  const send = (what, name, more = {}) => model.send_msg({do: what, name, ...more})
  const box = h("section", {"aria-label": "Your characters"})
  mount(part, [box])
  let renamed = "" // who is being renamed
  let doomed = "" // who is to be deleted, if the person says so again
  const turn = (who) => () => { [renamed, doomed] = who; draw(); box.querySelector("input, .sure")?.focus() }
  const quiet = (text, shape, act) => h("button", {class: "btn icon quiet", type: "button", "aria-label": text, title: text, onclick: act}, icon(shape))
  const naming = (name) => {
    const done = (event) => { send("rename", name, {to: event.target.value}); turn(["", ""])() }
    return [h("input", {class: "field", value: name, maxlength: "60", "aria-label": `New name of ${name}`, onkeydown: (event) => {
      event.stopPropagation()
      if (event.key === "Enter") done(event)
      else if (event.key === "Escape") turn(["", ""])()
    }}), quiet("Cancel", "cross", turn(["", ""]))]
  }
  const asking = (name) => [h("span", {class: "ask"}, `Delete ${name}?`),
    h("button", {class: "btn sure", type: "button", onclick: () => { send("delete", name); turn(["", ""])() }}, "Delete"),
    h("button", {class: "btn", type: "button", onclick: turn(["", ""])}, "Keep")]
  const plain = (name) => [
    h("button", {class: "name", type: "button", "aria-pressed": String(name === model.worn), title: "Have the takes wear it", onclick: () => send("wear", name)}, icon("person"), h("span", {}, name)),
    quiet(`Rename ${name}`, "pen", turn([name, ""])), quiet(`Delete ${name}`, "trash", turn(["", name]))]
  const draw = () => redraw(box, h("h4", {}, "Your characters"),
    model.names.length > 0 ? h("ul", {}, ...model.names.map((name) => h("li", {class: name === model.worn ? "on" : "", "data-key": `${name}${renamed === name ? " renamed" : doomed === name ? " doomed" : ""}`},
      ...(renamed === name ? naming(name) : doomed === name ? asking(name) : plain(name))))) : h("p", {class: "hint"}, "None yet."),
    model.error && h("p", {class: "fault", role: "alert"}, model.error))
  watch(model, ["names", "worn", "error"], draw)
}
