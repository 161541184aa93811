// The motion in words.
export function render(part) {
  const {model} = part
  const field = h("textarea", {class: "field", id: "prompt", rows: "3", maxlength: String(model.limit), placeholder: "a person walks forward, stops and waves"})
  let timer = 0
  const commit = () => { clearTimeout(timer); if (field.value !== model.value) model.value = field.value }
  field.addEventListener("input", () => { clearTimeout(timer); timer = setTimeout(commit, 200) })
  field.addEventListener("change", commit)
  const fill = (text) => { field.value = text; commit(); field.focus() }
  const understood = h("p", {class: "hint", id: "prompt-understood", role: "status"})
  field.setAttribute("aria-describedby", "prompt-understood")
  mount(part, [h("label", {for: "prompt"}, "Describe the motion"), field, understood], {"motionloom:prompt": (event) => fill(event.detail)})
  watch(model, ["understood"], () => {
    understood.textContent = model.understood
    understood.hidden = !model.understood
  })
  watch(model, ["value"], () => {
    if (field.getRootNode().activeElement !== field || model.value.trim() !== field.value.trim()) field.value = model.value
  })
}
