// How much of a manner, and how what is made is shown.
export function render(part) {
  const {model} = part
  const says = (value) => `${Math.round(100 * value)} %`
  const strength = h("input", {
    type: "range", id: "strength", min: "0", max: String(model.most), step: "0.05", title: "Double-click: 100 %",
    oninput: () => write(strength.value), onchange: () => { model.strength = Number(strength.value) }, ondblclick: () => { model.strength = 1 },
  })
  const told = h("output", {for: "strength"})
  const write = (value) => { told.textContent = says(value); strength.setAttribute("aria-valuetext", says(value)) }
  const box = (name, text, title) => h("label", {class: "box", title}, h("input", {type: "checkbox", onchange: (event) => { model[name] = event.target.checked }}), text)
  const feet = box("feet", "Foot clean-up", "Standing feet are held; taken back at any time beside the transport")
  const tempo = box("tempo", "Its tempo too", "The take also becomes as fast as the style is")
  mount(part, [h("div", {class: "row"}, h("label", {for: "strength"}, "Strength"), strength, told), h("div", {class: "boxes"}, feet, tempo)])
  watch(model, ["strength", "feet", "tempo", "timed"], () => {
    strength.value = String(model.strength)
    write(model.strength)
    for (const [field, value] of [[feet, model.feet], [tempo, model.tempo]]) field.firstChild.checked = value
    tempo.hidden = !model.timed
  })
}
