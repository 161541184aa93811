// Import: choose a file or drop one anywhere on the page. It travels in pieces, so that the page stays alive.
const PIECE = 2 ** 20
export function render(part) {
  const {model} = part
  const input = h("input", {type: "file", accept: model.accept.join(","), class: "vh", id: "file", tabindex: "-1", "aria-label": model.label})
  const choose = h("button", {class: "btn", type: "button", onclick: () => input.click()}, icon("upload"), "Choose a file")
  const outcome = h("div", {role: "status"})
  const words = h("p")
  const zone = h("div", {}, icon("upload"), words, choose, input, h("p", {class: "hint"}, `${model.accept.join(", ")} up to ${model.limit / 2 ** 20} MB`))
  const refuse = (text) => { model.error = text; model.status = "" }
  async function send(file) {
    if (!file) return
    model.send_msg({do: "open"})
    if (file.size > model.limit) return refuse(`${file.name}: ${(file.size / 2 ** 20).toFixed(0)} MB is too large; accepted: up to ${model.limit / 2 ** 20} MB.`)
    const ending = model.accept.find((kind) => file.name.toLowerCase().endsWith(kind))
    if (!ending) return refuse(`${file.name}: files of this kind are not read; accepted: ${model.accept.join(", ")}.`)
    model.error = ""
    const id = crypto.getRandomValues(new Uint32Array(2)).join("-")
    for (let start = 0; start === 0 || start < file.size; start += PIECE) {
      const piece = await file.slice(start, start + PIECE).arrayBuffer()
      model.send_msg({do: "piece", id, name: file.name, start, size: file.size, data: piece})
      outcome.textContent = `Sending ${file.name}… ${Math.round(100 * Math.min(1, (start + PIECE) / Math.max(file.size, 1)))}%`
    }
  }
  input.addEventListener("change", () => { send(input.files[0]); input.value = "" })
  mount(part, [zone, outcome], {"motionloom:file": (event) => { if (model.active) send(event.detail) }, "motionloom:choose-file": () => { if (model.active) input.click() }})
  watch(model, ["compact", "text"], () => {
    zone.className = model.compact ? "zone compact" : "zone"
    words.textContent = model.text
  })
  watch(model, ["error", "status", "active"], () => {
    if (!model.active) redraw(outcome)
    else redraw(outcome, model.error ? h("p", {class: "fault", role: "alert"}, model.error) : model.status && h("p", {class: "hint"}, model.status))
  })
}
