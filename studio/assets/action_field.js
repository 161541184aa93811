// The action asked for: type to search the grid below, Enter takes the best match; an unknown word is named at once.
export function render(part) {
  const {model} = part
  const input = h("input", {
    class: "field", id: "action", type: "text", autocomplete: "off", spellcheck: "false", placeholder: "walk, jump, wave right hand…",
    "aria-describedby": "problem", maxlength: "80",
  })
  const problem = h("div", {id: "problem", role: "alert"})
  const about = h("p", {class: "hint about"})
  const search = (text) => window.dispatchEvent(new CustomEvent("motionloom:search", {detail: text}))
  const commit = (text) => { search(""); model.value = text.trim().toLowerCase().split(/\s+/).join(" ") }
  input.addEventListener("input", () => search(input.value))
  input.addEventListener("focus", () => input.select())
  input.addEventListener("change", () => commit(input.value))
  input.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown") { event.preventDefault(); window.dispatchEvent(new CustomEvent("motionloom:browse")) }
    if (event.key === "Escape") { input.value = model.value; search("") }
  })
  const box = h("div", {class: "box"}, icon("search"), input)
  mount(part, [h("label", {for: "action"}, "Action"), box, problem, about])
  watch(model, ["value", "description", "error", "nearest"], () => {
    input.value = model.value
    input.setAttribute("aria-invalid", String(Boolean(model.error)))
    about.textContent = model.description
    about.hidden = !model.description
    const picks = model.nearest.map((name) => h("button", {class: "chip", type: "button", "data-key": name, onclick: () => commit(name)}, name))
    redraw(problem, model.error && h("p", {class: "fault"}, model.error), picks.length > 0 && h("div", {class: "chips"}, ...picks))
  })
}
