// Prompts that fill the field.
export function render(part) {
  const {model} = part
  const list = h("div", {class: "examples", role: "group", "aria-labelledby": "examples"})
  mount(part, [h("div", {class: "box"}, h("h4", {id: "examples"}, "For example"), list)])
  const fill = (text) => window.dispatchEvent(new CustomEvent("motionloom:prompt", {detail: text}))
  watch(model, ["examples"], () => {
    redraw(list, ...model.examples.map((text) => h("button", {class: "example", type: "button", "data-key": text, onclick: () => fill(text)}, text)))
  })
}
