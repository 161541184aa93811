// One of several: tabs (role tablist) or a choice (role radiogroup).
export function render(part) {
  const {model} = part
  const tabs = model.role === "tablist"
  const box = h("div", {class: `seg ${model.role}`, role: model.role, "aria-label": model.label})
  box.addEventListener("keydown", (event) => arrows(event, () => [...box.children]))
  mount(part, [box])
  watch(model, ["options", "value"], () => {
    redraw(box, ...model.options.map(([value, text]) => {
      const on = value === model.value
      const pick = () => { model.value = value }
      return h("button", {
        type: "button", role: tabs ? "tab" : "radio", [tabs ? "aria-selected" : "aria-checked"]: String(on), tabindex: on ? "0" : "-1",
        "data-key": value, onclick: pick, onfocus: pick,
      }, text)
    }))
  })
}
