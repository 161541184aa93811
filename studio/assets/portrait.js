// A person in a picture: joints to drag, a silhouette to paint; in the panel, or as large as the window.
const AFTER_KEYS = 350 // milliseconds after the last arrow key until a joint is said to be moved
export function render(part) {
  const {model} = part
  const send = (what, more = {}) => model.send_msg({do: what, ...more})
  const photo = h("img", {alt: "", draggable: "false"})
  const tint = h("canvas", {"aria-hidden": "true"})
  const cut = document.createElement("canvas")
  const lines = document.createElementNS("http://www.w3.org/2000/svg", "svg")
  lines.setAttribute("aria-hidden", "true")
  const points = h("div", {class: "points", role: "group", "aria-label": "Joints; arrow keys move the one in focus, with Shift farther"})
  const ring = h("div", {class: "ring", hidden: true})
  const sheet = h("div", {class: "sheet"}, photo, tint, lines, points, ring)
  const tools = h("div", {class: "seg", role: "radiogroup", "aria-label": "What the mouse does"})
  const size = h("input", {type: "range", id: "brush", min: "4", max: "80", step: "1", value: "20", oninput: () => { radius = Number(size.value) }})
  const brush = h("div", {class: "brush"}, h("label", {for: "brush"}, "Brush"), size)
  const back = h("button", {class: "btn", type: "button", onclick: () => send("undo")}, icon("undo"), "Undo")
  const enlarge = h("button", {class: "btn", type: "button", onclick: () => large.open ? large.close() : grow()})
  const work = h("div", {class: "work"}, sheet, tools, h("div", {class: "row"}, brush, back, enlarge))
  const small = h("section", {class: "small", "aria-label": "Who is seen"}, work)
  const large = h("dialog", {class: "large", "aria-label": "Who is seen, enlarged"})
  mount(part, [small, large])
  const grow = () => { large.append(work); large.showModal(); label() }
  large.addEventListener("close", () => { small.append(work); label() })
  large.addEventListener("keydown", (event) => event.stopPropagation()) // the stage's keys rest
  const label = () => { enlarge.replaceChildren(large.open ? "Done" : "Enlarge") }
  let tool = "move"
  let radius = 20 // pixels of the picture as it is shown
  let places = {} // name -> [x, y], as drawn: ahead of the model while something is moved
  let held = "" // what is moved
  let timer = 0
  let stroke = null

  const inPicture = (event) => {
    const box = sheet.getBoundingClientRect()
    return [(event.clientX - box.left) / box.width * model.size[0], (event.clientY - box.top) / box.height * model.size[1]]
  }
  const scale = () => model.size[0] / sheet.getBoundingClientRect().width
  const within = ([x, y]) => [Math.min(Math.max(x, 0), model.size[0]), Math.min(Math.max(y, 0), model.size[1])]
  const moved = (name) => { clearTimeout(timer); timer = 0; held = ""; send("move", {landmark: name, to: places[name]}) }
  const place = () => {
    for (const dot of points.children) {
      const [x, y] = places[dot.dataset.key]
      dot.style.left = `${100 * x / model.size[0]}%`
      dot.style.top = `${100 * y / model.size[1]}%`
    }
    lines.replaceChildren(...model.bones.map(([a, b]) => {
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line")
      const ends = {x1: places[a][0], y1: places[a][1], x2: places[b][0], y2: places[b][1]}
      for (const [name, value] of Object.entries(ends)) line.setAttribute(name, value)
      if (a.startsWith("left") && b.startsWith("left")) line.setAttribute("class", "left")
      return line
    }))
  }
  const dot = ([name, text]) => h("button", {
    class: name.startsWith("left") ? "dot left" : "dot", type: "button", "data-key": name, "aria-label": text, title: text,
    onpointerdown: (event) => { event.target.setPointerCapture(event.pointerId); held = name },
    onpointermove: (event) => { if (held === name && event.buttons) { places[name] = within(inPicture(event)); place() } },
    onpointerup: () => { if (held === name) moved(name) },
    onblur: () => { if (timer) moved(name) },
    onkeydown: (event) => {
      const far = (event.shiftKey ? 10 : 1) * scale()
      const by = {ArrowLeft: [-far, 0], ArrowRight: [far, 0], ArrowUp: [0, -far], ArrowDown: [0, far]}[event.key]
      if (!by) return
      event.preventDefault()
      event.stopPropagation()
      held = name
      places[name] = within([places[name][0] + by[0], places[name][1] + by[1]])
      place()
      clearTimeout(timer)
      timer = setTimeout(() => moved(name), AFTER_KEYS)
    },
  })
  // the silhouette is a picture whose transparency says where the person is; it is filled with a colour
  const fill = () => {
    const pen = tint.getContext("2d")
    pen.globalCompositeOperation = "copy"
    pen.drawImage(cut, 0, 0)
    pen.globalCompositeOperation = "source-in"
    pen.fillStyle = "#3f8cff"
    pen.fillRect(0, 0, tint.width, tint.height)
  }
  const load = () => {
    if (!model.mask) return
    const mask = new Image()
    mask.onload = () => {
      for (const canvas of [cut, tint]) Object.assign(canvas, {width: mask.width, height: mask.height})
      cut.getContext("2d").drawImage(mask, 0, 0)
      fill()
    }
    mask.src = model.mask
  }
  const dab = (from, to) => {
    const pen = cut.getContext("2d")
    const fit = cut.width / model.size[0]
    pen.globalCompositeOperation = tool === "add" ? "source-over" : "destination-out"
    Object.assign(pen, {lineWidth: 2 * stroke.radius * fit, lineCap: "round", strokeStyle: "#fff"})
    pen.beginPath()
    pen.moveTo(from[0] * fit, from[1] * fit)
    pen.lineTo(to[0] * fit + 0.01, to[1] * fit)
    pen.stroke()
    fill()
  }
  sheet.onpointerdown = (event) => {
    if (tool === "move" || event.button !== 0) return
    sheet.setPointerCapture(event.pointerId)
    stroke = {points: [inPicture(event)], radius: radius * scale()}
    dab(stroke.points[0], stroke.points[0])
  }
  sheet.onpointermove = (event) => {
    const box = sheet.getBoundingClientRect()
    Object.assign(ring.style, {left: `${event.clientX - box.left}px`, top: `${event.clientY - box.top}px`, width: `${2 * radius}px`, height: `${2 * radius}px`})
    ring.hidden = tool === "move"
    if (!stroke) return
    const here = inPicture(event)
    dab(stroke.points.at(-1), here)
    stroke.points.push(here)
  }
  sheet.onpointerup = () => {
    if (stroke) send("paint", {points: stroke.points, radius: stroke.radius, adds: tool === "add"})
    stroke = null
  }
  sheet.onpointerleave = () => { ring.hidden = true }
  tools.addEventListener("keydown", (event) => arrows(event, () => [...tools.children]))
  const choose = (next) => () => { tool = next; pick() }
  const pick = () => {
    redraw(tools, ...[["move", "Move joints"], ["add", "Paint"], ["erase", "Erase"]].map(([name, text]) => h("button", {
      type: "button", role: "radio", "data-key": name, "aria-checked": String(tool === name), tabindex: tool === name ? "0" : "-1", onclick: choose(name), onfocus: choose(name),
    }, text)))
    brush.hidden = tool === "move"
    sheet.classList.toggle("painting", tool !== "move")
  }
  pick()
  label()
  watch(model, ["mask"], load)
  watch(model, ["picture", "size", "points", "changes"], () => {
    small.hidden = !model.picture
    if (!model.picture) { large.close(); return }
    if (photo.getAttribute("src") !== model.picture) photo.src = model.picture
    const [wide, high] = model.size
    sheet.style.setProperty("--ratio", String(wide / high))
    lines.setAttribute("viewBox", `0 0 ${wide} ${high}`)
    places = {...model.points, ...(held ? {[held]: places[held]} : {})}
    redraw(points, ...model.names.map(dot))
    place()
    back.disabled = model.changes === 0
  })
}
