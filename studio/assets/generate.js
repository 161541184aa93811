// The Generate button, what it will bring, and how far it is.
export function render(part) {
  const {model} = part
  const box = h("div")
  mount(part, [box])
  watch(model, ["busy", "progress", "problem", "named", "forecast", "error", "label", "note", "doing"], () => {
    const main = model.busy
      ? h("button", {class: "btn wide", "data-key": "main", type: "button", onclick: () => model.send_msg({do: "cancel"})}, icon("cross"), "Cancel")
      : h("button", {class: "btn primary wide", "data-key": "main", type: "button", disabled: Boolean(model.problem), "aria-describedby": "forecast", title: "Ctrl+Enter",
          onclick: () => model.send_msg({do: "generate"})}, model.label, h("kbd", {"aria-hidden": "true"}, "Ctrl ⏎"))
    const line = model.busy
      ? h("progress", {max: "1", value: model.progress > 0 ? String(model.progress) : null, "aria-label": "Generating"})
      : h("p", {class: "hint", id: "forecast"}, model.named ? "Choose an action it knows." : model.problem || model.forecast)
    redraw(box, main, line, model.busy && model.doing && h("p", {class: "hint", role: "status"}, model.doing), model.error && h("p", {class: "fault", role: "alert"}, model.error), model.note && h("p", {class: "note", role: "status"}, model.note))
  })
}
