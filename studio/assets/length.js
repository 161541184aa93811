// How long a motion is: seconds, and a box that leaves it to what is asked.
export function render(part) {
  const {model} = part
  const input = h("input", {class: "field", id: "length", type: "number", min: "0", step: "0.5", autocomplete: "off"})
  const box = h("input", {type: "checkbox", onchange: () => { model.found = box.checked }})
  const leave = h("label", {class: "leave"}, box, "as long as it takes")
  const show = () => {
    input.value = model.seconds.toFixed(2).replace(/0$/, "")
    box.checked = model.found && !model.pinned
    box.disabled = model.pinned
    leave.hidden = !model.finds
    leave.title = model.pinned ? "What is pinned lies in a motion of the length that is shown" : "The engine finds how long; a length that is typed holds instead"
  }
  input.addEventListener("change", () => {
    const seconds = Math.min(Number(input.value), model.most)
    if (seconds > 0) model.send_msg({do: "say", seconds})
    show()
    if (seconds > 0) input.value = String(seconds)
  })
  mount(part, [h("label", {for: "length"}, "Length, seconds"), h("div", {class: "line"}, input, leave)])
  watch(model, ["seconds", "most", "found", "finds", "pinned"], show)
}
