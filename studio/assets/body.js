// The body that takes are shown with: which one, its shape; and the bones of takes to come.
const SHOWN_EVERY = 120 // milliseconds between what is shown while a slider is dragged
export function render(part) {
  const {model} = part
  const box = h("div", {class: "body"})
  mount(part, [box])
  let dragged = null // name of the slider in a person's hand: what comes back from the studio does not move it
  let timer = 0
  const percent = (value) => `${Math.round(value * 100)} %`
  const number = (value) => Number(value).toFixed(2)
  const send = (what, name, value, keep) => model.send_msg({do: what, values: {[name]: Number(value)}, keep})
  const slider = (what, {name, text, ends, low, high, step, usual, value}) => {
    const says = what === "bones" ? percent : number
    const key = `${what}-${name}`
    const written = (field) => {
      field.setAttribute("aria-valuetext", says(field.value))
      field.closest(".slider").querySelector("output").textContent = says(field.value)
    }
    const changed = (event) => {
      written(event.target)
      dragged = key
      if (what === "bones" || timer) return
      timer = setTimeout(() => { timer = 0; send(what, name, event.target.value, false) }, SHOWN_EVERY)
    }
    const let_go = (event) => {
      clearTimeout(timer)
      timer = 0
      dragged = null
      send(what, name, event.target.value, true)
    }
    const [first, last] = ends
    return h("div", {class: "slider", "data-key": key},
      h("label", {for: key}, text),
      h("div", {class: "track"},
        h("input", {type: "range", id: key, min: low, max: high, step, value, "aria-valuetext": says(value), oninput: changed, onchange: let_go,
          ondblclick: () => send(what, name, usual, true), title: `Double-click: ${says(usual)}`}),
        first && h("div", {class: "ends", "aria-hidden": "true"}, h("span", {}, first), h("span", {}, last))),
      h("output", {for: key}, says(value)))
  }
  const group = (title, what, sliders, reset, ...more) => h("section", {"data-key": what, "aria-label": title},
    h("div", {class: "head"}, h("h4", {}, title),
      h("button", {class: "btn small", type: "button", "aria-label": `Reset ${title.toLowerCase()}`, disabled: sliders.every(({value, usual}) => value === usual), onclick: () => model.send_msg({do: reset})}, "Reset")),
    ...sliders.map((one) => slider(what, one)), ...more)
  watch(model, ["bodies", "body", "sliders", "bones", "error", "note"], () => {
    const held = dragged && box.querySelector(`#${dragged}`)?.value
    redraw(box,
      h("section", {"data-key": "which", "aria-label": "Body"},
        h("label", {for: "body"}, "Body of this project"),
        h("select", {class: "field", id: "body", onchange: (event) => model.send_msg({do: "wear", name: event.target.value})},
          ...model.bodies.map(({name, text}) => h("option", {value: name}, text))),
        model.error && h("p", {class: "fault", role: "alert"}, model.error)),
      model.sliders.length > 0 && group("Shape", "shape", model.sliders, "reset"),
      model.bones.length > 0 && group("Bones of the next takes", "bones", model.bones, "reset_bones",
        model.note && h("p", {class: "hint"}, model.note)))
    box.querySelector("select").value = model.body
    for (const [what, sliders] of [["shape", model.sliders], ["bones", model.bones]]) {
      for (const {name, value} of sliders) {
        const key = `${what}-${name}`
        box.querySelector(`#${key}`).value = key === dragged ? held : value
      }
    }
  })
}
