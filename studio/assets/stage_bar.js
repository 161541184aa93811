// Over the stage: what it shows, and which takes together.
export function render(part) {
  const {model} = part
  const bar = h("div", {class: "glass"})
  bar.addEventListener("keydown", (event) => arrows(event, () => [...bar.querySelectorAll("[role=radio]")]))
  mount(part, [bar])
  watch(model, ["mode", "together", "ticked"], () => {
    const choices = [["all", model.together > 1 ? `All ${model.together}` : "One"], ...(model.together > 1 ? [["one", "One"]] : []), ["compare", `Compare ${model.ticked || ""}`]]
    redraw(bar, h("div", {class: "seg", role: "radiogroup", "aria-label": "Takes on the stage"}, ...choices.map(([value, text]) => h("button", {
        type: "button", role: "radio", "data-key": value, "aria-checked": String(model.mode === value), tabindex: model.mode === value ? "0" : "-1",
        disabled: value === "compare" && !model.ticked, onclick: () => { model.mode = value },
      }, text))))
    bar.hidden = model.together < 2 && !model.ticked
  })
}
