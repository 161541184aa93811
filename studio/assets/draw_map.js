// A map: draws as dots, like beside like. Press or drag anywhere, or move the point with the arrow keys.
export function render(part) {
  const {model} = part
  const send = (what, more = {}) => model.send_msg({do: what, ...more})
  const svg = (tag, attributes = {}, ...children) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag)
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value)
    node.append(...children)
    return node
  }
  const SIDE = 240
  const across = ([x]) => x * SIDE
  const down = ([, y]) => (1 - y) * SIDE
  const dots = svg("g", {class: "dots"})
  const way = svg("polyline", {class: "way"})
  const straight = svg("line", {class: "straight"})
  const real = svg("circle", {class: "real", r: "5"})
  const point = svg("circle", {class: "point", r: "8"})
  const picture = svg("svg", {viewBox: `0 0 ${SIDE} ${SIDE}`, "aria-hidden": "true"}, straight, way, dots, real, point)
  const face = h("img", {alt: "", width: "64", height: "64"})
  const name = h("span")
  const peek = h("div", {class: "peek", hidden: true}, face, name)
  const told = h("p", {class: "hint told", role: "status"})
  const map = h("div", {class: "map", tabindex: "0", role: "application", "aria-label": "Map"}, picture, peek)
  const keep = h("button", {class: "btn primary", type: "button", onclick: () => send("keep")}, icon("check"), "Keep this one")
  const draw = h("button", {class: "btn wide", type: "button", onclick: () => send("draw")})
  const stop = h("button", {class: "btn wide", type: "button", onclick: () => send("cancel")}, icon("cross"), "Cancel the map")
  const bar = h("progress", {max: "1", "aria-label": "Draws made"})
  const note = h("p", {class: "hint"})
  const fault = h("p", {class: "fault", role: "alert"})
  mount(part, [h("section", {class: "whole", "aria-label": model.title}, h("h4", {}, model.title), map, told, note, keep, draw, stop, bar, fault)])

  // the point goes with the hand at once; the page's thread is told once a picture
  let here = null
  let waiting = false
  const go = (x, y) => {
    here = [Math.max(0, Math.min(1, x)), Math.max(0, Math.min(1, y))]
    put(point, here)
    if (waiting) return
    waiting = true
    requestAnimationFrame(() => { waiting = false; send("move", {x: here[0], y: here[1]}) })
  }
  const put = (node, place) => {
    node.style.display = place ? "" : "none"
    if (place) { node.setAttribute("cx", across(place)); node.setAttribute("cy", down(place)) }
  }
  const place = (event) => {
    const box = picture.getBoundingClientRect()
    return [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height]
  }
  const nearest = ([x, y]) => {
    let best = [0.04, -1]
    model.points.forEach(([px, py], i) => { const off = Math.hypot(px - x, py - y); if (off < best[0]) best = [off, i] })
    return best[1]
  }
  let looked = -1
  const look = (i) => {
    looked = i
    peek.hidden = !(i >= 0 && (model.pictures[i] || model.names[i]))
    if (peek.hidden) return
    face.hidden = !model.pictures[i]
    if (face.getAttribute("src") !== model.pictures[i]) face.src = model.pictures[i]
    name.textContent = model.names[i] ?? ""
    const [x, y] = model.points[i]
    peek.style.left = `${Math.min(74, Math.max(0, 100 * x - 13))}%`
    peek.style.top = y > 0.4 ? `${100 * (1 - y) + 4}%` : `${100 * (1 - y) - 32}%`
  }
  map.onpointerdown = (event) => { if (model.points.length && event.button === 0) { map.setPointerCapture(event.pointerId); go(...place(event)) } }
  map.onpointermove = (event) => { if (map.hasPointerCapture(event.pointerId)) go(...place(event)); look(nearest(place(event))) }
  map.onpointerleave = () => look(-1)
  map.onkeydown = (event) => {
    const step = event.shiftKey ? 0.1 : 0.02
    const by = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step]}[event.key]
    if (by && model.points.length) { const [x, y] = here ?? [0.5, 0.5]; go(x + by[0], y + by[1]) }
    else if (event.key === "Enter" && model.at.length) send("keep")
    else return
    event.preventDefault()
    event.stopPropagation()
  }
  model.on("points", () => { here = null })
  watch(model, ["subject", "names", "asked", "problem", "points", "pictures", "at", "ends", "line", "words", "busy", "progress", "error"], () => {
    const there = model.points.length > 0
    map.hidden = !there
    map.setAttribute("aria-label", `Map of ${model.subject}: arrow keys move the point, Enter keeps what is shown`)
    if (dots.childNodes.length !== model.points.length || dots.of !== model.points) {
      dots.of = model.points
      const kinds = [...new Set(model.names)]
      dots.replaceChildren(...model.points.map((at, i) => {
        const dot = svg("circle", {class: "dot", r: "4.5", cx: across(at), cy: down(at)})
        // draws of one name have one colour
        if (kinds.length < model.points.length) dot.style.setProperty("--kind", `hsl(${Math.round(360 * kinds.indexOf(model.names[i]) / kinds.length)} 55% 58%)`)
        return dot
      }))
    }
    dots.childNodes.forEach((dot, i) => dot.setAttribute("class", model.ends.includes(i) ? "dot on" : "dot"))
    look(looked < model.points.length ? looked : -1)
    put(point, here ?? (model.at.length ? model.at : null))
    const [a, b] = model.ends.map((i) => model.points[i])
    straight.style.display = a && b ? "" : "none"
    if (a && b) for (const [name, value] of [["x1", across(a)], ["y1", down(a)], ["x2", across(b)], ["y2", down(b)]]) straight.setAttribute(name, value)
    way.setAttribute("points", model.line.map((at) => `${across(at)},${down(at)}`).join(" "))
    const share = /^(\d+) %/.exec(model.words)
    put(real, share && model.line.length ? model.line[Math.round(Number(share[1]) / 100 * (model.line.length - 1))] : null)
    told.textContent = model.words
    told.hidden = !there || !model.words
    keep.hidden = !there || !model.at.length
    draw.replaceChildren(icon("pick"), `Draw ${there ? "another" : "the"} map of “${model.asked}”`)
    draw.disabled = model.busy || Boolean(model.problem)
    draw.title = model.problem
    stop.hidden = bar.hidden = !model.busy
    bar.value = model.progress
    note.textContent = !there ? model.about : !model.words ? `${model.points.length} draws of “${model.subject}”. Press a dot, or a place between dots.` : model.ends.length > 1 ? "The way from the one to the other; the ring is where this one truly lies." : ""
    note.hidden = !note.textContent || model.busy
    fault.textContent = model.error || (model.busy ? "" : model.problem)
    fault.hidden = !fault.textContent
  })
}
