// The action asked for: type to search the grid below, Enter takes the best match; a word that fits none is named.
export function render(part) {
  const {model} = part
  const input = h("input", {
    class: "field", id: "action", type: "text", autocomplete: "off", spellcheck: "false", placeholder: "walk, jump, wave right hand…",
    "aria-describedby": "problem", maxlength: "80",
  })
  const problem = h("div", {id: "problem", role: "alert"})
  const about = h("p", {class: "hint about"})
  const search = (text) => window.dispatchEvent(new CustomEvent("motionloom:search", {detail: text}))
  const commit = (text) => {
    const typed = text.trim().toLowerCase().split(/\s+/).join(" ")
    search("")
    model.value = input.value = model.names.includes(typed) ? typed : matching(model.names, typed)[0] ?? typed
  }
  let toCards = false // a card that is pressed, or gone to with the arrow, says itself which action it is
  const pressed = (event) => { toCards = event.composedPath().some((node) => node.classList?.contains("action")) }
  const chosen = (event) => { input.value = event.detail }
  input.addEventListener("input", () => search(input.value))
  input.addEventListener("focus", () => input.select())
  input.addEventListener("change", () => { if (!toCards) commit(input.value) })
  input.addEventListener("keydown", (event) => {
    toCards = event.key === "ArrowDown"
    if (event.key === "Enter") commit(input.value)
    if (toCards) { event.preventDefault(); window.dispatchEvent(new CustomEvent("motionloom:browse")) }
    if (event.key === "Escape") { input.value = model.value; search("") }
  })
  const box = h("div", {class: "box"}, icon("search"), input)
  mount(part, [h("label", {for: "action"}, "Action"), box, problem, about], {pointerdown: pressed, "motionloom:chosen": chosen})
  watch(model, ["value", "description", "error", "nearest"], () => {
    input.value = model.value
    input.setAttribute("aria-invalid", String(Boolean(model.error)))
    about.textContent = model.description
    about.hidden = !model.description
    const picks = model.nearest.map((name) => h("button", {class: "chip", type: "button", "data-key": name, onclick: () => commit(name)}, name))
    redraw(problem, model.error && h("p", {class: "fault"}, model.error), picks.length > 0 && h("div", {class: "chips"}, ...picks))
  })
}
