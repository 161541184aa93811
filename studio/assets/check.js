// A box to tick, with its words as its label.
export function render(part) {
  const {model} = part
  const box = h("input", {type: "checkbox", onchange: () => { model.value = box.checked }})
  const words = document.createTextNode("")
  mount(part, [h("label", {}, box, words)])
  watch(model, ["value", "label"], () => {
    box.checked = model.value
    words.data = model.label
  })
}
