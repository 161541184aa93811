// The seed, always shown: a number, a die for another one, and a lock for an identical repeat.
export function render(part) {
  const {model} = part
  const input = h("input", {class: "field", id: "seed", inputmode: "numeric", maxlength: "10", autocomplete: "off"})
  const die = h("button", {class: "in", type: "button", "aria-label": "Another seed", title: "Another seed", onclick: () => { model.value = Math.floor(Math.random() * 10000) }}, icon("dice"))
  const lock = h("button", {class: "in", type: "button"})
  lock.addEventListener("click", () => { model.locked = !model.locked })
  input.addEventListener("change", () => {
    const number = Number.parseInt(input.value.replace(/\D/g, ""), 10)
    if (Number.isFinite(number)) { model.value = Math.min(number, 2147483647); model.locked = true }
    input.value = String(model.value)
  })
  mount(part, [h("label", {for: "seed"}, "Seed"), h("div", {class: "box"}, input, die, lock)])
  watch(model, ["value", "locked"], () => {
    input.value = String(model.value)
    lock.replaceChildren(icon(model.locked ? "lock" : "unlock"))
    lock.setAttribute("aria-pressed", String(model.locked))
    lock.setAttribute("aria-label", "Keep this seed")
    lock.title = model.locked ? "Locked: the same seed and settings give the identical takes" : "Unlocked: every draw takes another seed"
  })
}
