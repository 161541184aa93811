// Shared by every component: elements, icons, and redrawing without losing the focus.
const SHAPES = {
  undo: "M8 5 3.5 9.5 8 14M4 9.5h9a6 6 0 0 1 0 12h-3",
  redo: "M16 5l4.5 4.500L16 14M20 9.500h-9a6 6 0 0 0 0 12h3",
  sun: "M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8M12 2.500v2M12 19.500v2M2.5 12h2M19.5 12h2M5.3 5.300l1.4 1.400M17.3 17.300l1.4 1.400M18.7 5.300l-1.4 1.400M6.7 17.300l-1.4 1.4",
  moon: "M20 14.500A8.5 8.5 0 0 1 9.5 4a8.5 8.5 0 1 0 10.5 10.500z",
  help: "M9 9a3 3 0 1 1 4.3 2.700c-.9.45-1.3 1-1.3 2.300M12 17.500v.1",
  star: "M12 3.500l2.6 5.4 5.9.8-4.3 4.1 1 5.9-5.2-2.8-5.2 2.8 1-5.9-4.3-4.1 5.9-.8z",
  check: "M4.5 12.500l5 5 10-11",
  again: "M20 5v5h-5M19.5 10A8 8 0 1 0 20 14",
  trash: "M4 7h16M9.5 7V4.500h5V7M6.5 7l1 13h9l1-13M10 11v5M14 11v5",
  compare: "M12 3v18M9 6H4v12h5M15 6h5v12h-5",
  cross: "M6 6l12 12M18 6L6 18",
  search: "M11 4a7 7 0 1 0 0 14 7 7 0 0 0 0-14M16 16l4.5 4.5",
  download: "M12 4v11M7.5 11 12 15.5 16.5 11M5 20h14",
  upload: "M12 16V5M7.5 9 12 4.5 16.5 9M5 20h14",
  lock: "M6.5 11h11v9h-11zM8.5 11V8a3.5 3.5 0 0 1 7 0v3",
  unlock: "M6.5 11h11v9h-11zM8.5 11V8a3.5 3.5 0 0 1 6.8-1.2",
  dice: "M4.5 4.500h15v15h-15zM9 9v.1M15 9v.1M12 12v.1M9 15v.1M15 15v.1",
  person: "M12 3.500a2 2 0 1 0 0 4 2 2 0 0 0 0-4M12 9.500v5.500M7 11.500l5-2 5 2M9 21l3-6 3 6",
  down: "M7 10l5 5 5-5",
  copy: "M9 9h11v11H9zM5 15H4V4h11v1",
  pose: "M12 3.500a2 2 0 1 0 0 4 2 2 0 0 0 0-4M12 9.500v5.500M5 8l7 2.500L19 8M8.5 21l3.5-6 3.5 6",
  frames: "M4 6.500h16v11H4zM8 6.500v11M12.5 6.500v11M4 20.500h8.5",
  path: "M5 19.500a1.8 1.8 0 1 0 0-3.600 1.8 1.8 0 0 0 0 3.600M7 17.500c8 0 2-9 11-9.500M14.5 4.500 18.5 8l-3.5 4",
  joint: "M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6M12 3v3.500M12 17.500V21M3 12h3.5M17.5 12H21",
  folder: "M3.5 6.500h6l2 2.500h9v10.500h-17z",
  plus: "M12 5v14M5 12h14",
  tag: "M4 4h7.500l8.500 8.500-7.500 7.500L4 11.500zM8 8v.1",
  warning: "M12 4.500 21 20H3zM12 10.500v4.500M12 17.500v.1",
  mask: "M4.500 5.500c5 1.500 10 1.500 15 0v6c0 5-3.500 8.500-7.500 9-4-.5-7.500-4-7.500-9zM8 10.500q1.300-1.200 2.600 0M13.4 10.500q1.300-1.200 2.600 0M9 15q3 2.500 6 0",
  pick: "M12 3.500v4M12 16.500v4M3.5 12h4M16.5 12h4M12 9.500a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5",
  pen: "M5 19l1-4L16.5 4.500l3 3L9 18zM14.5 6.500l3 3",
  disk: "M12 4v9M8 9.500l4 4 4-4M4.5 14.500v5h15v-5",
  broom: "M14 4l-3 8M7 12h9l2 8H5zM10 16v4M13.5 16v4",
}
function icon(name, solid = false) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg")
  svg.setAttribute("viewBox", "0 0 24 24")
  svg.setAttribute("class", solid ? "i solid" : "i")
  svg.setAttribute("aria-hidden", "true")
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path")
  path.setAttribute("d", SHAPES[name])
  svg.append(path)
  return svg
}
/** An element: attributes by name, `on*` as its handlers, booleans as present or absent, children appended. */
function h(tag, attributes = {}, ...children) {
  const node = document.createElement(tag)
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node[name] = value
    else if (value === true) node.setAttribute(name, "")
    else if (value !== false && value != null) node.setAttribute(name, value)
  }
  node.handlers = Object.keys(attributes).filter((name) => name.startsWith("on"))
  node.append(...children.filter((child) => child != null && child !== false))
  return node
}
/** Make what `root` holds equal to the new children, changing the elements that are there rather than replacing them:
 * a button stays itself between press and release, a picture is not loaded twice, focus and scroll stay. */
function redraw(root, ...children) {
  const wanted = children.filter((child) => child != null && child !== false).map((child) => typeof child === "string" ? document.createTextNode(child) : child)
  const keyed = new Map([...root.childNodes].filter((old) => old.dataset?.key).map((old) => [old.dataset.key, old]))
  wanted.forEach((next, place) => {
    const here = root.childNodes[place]
    const old = next.dataset?.key ? keyed.get(next.dataset.key) : here?.dataset?.key ? undefined : here
    const same = old && old.nodeName === next.nodeName && old.nodeType === next.nodeType
    if (same) become(old, next)
    const node = same ? old : next
    if (root.childNodes[place] !== node) root.insertBefore(node, root.childNodes[place] ?? null)
  })
  while (root.childNodes.length > wanted.length) root.lastChild.remove()
}
function become(old, next) {
  if (old.nodeType !== Node.ELEMENT_NODE) {
    if (old.data !== next.data) old.data = next.data
    return
  }
  for (const {name} of [...old.attributes]) if (!next.hasAttribute(name)) old.removeAttribute(name)
  for (const {name, value} of next.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value)
  for (const name of old.handlers ?? []) old[name] = null
  for (const name of next.handlers ?? []) old[name] = next[name]
  old.handlers = next.handlers
  if (old.nodeName === "INPUT" && old.getRootNode().activeElement !== old) old.value = next.getAttribute("value") ?? ""
  redraw(old, ...next.childNodes)
}
/** Redraw once now and once after each burst of changes of the named parameters. */
function watch(model, names, draw) {
  let asked = false
  const later = () => {
    if (asked) return
    asked = true
    queueMicrotask(() => { asked = false; draw() })
  }
  for (const name of names) model.on(name, later)
  draw()
}
/** Those of `names` in which every word typed is found, those that begin with it first. */
function matching(names, typed) {
  const words = typed.trim().toLowerCase().split(/\s+/).filter(Boolean)
  const found = words.length ? names.filter((name) => words.every((word) => name.includes(word))) : []
  const begins = (name) => name.startsWith(words.join(" "))
  return [...found.filter(begins), ...found.filter((name) => !begins(name))]
}
/** Arrow keys move the focus among `items()`; `columns()` says how far up and down go. */
function arrows(event, items, columns = () => 1) {
  const list = items()
  const place = list.indexOf(event.target.getRootNode().activeElement)
  const step = {ArrowRight: 1, ArrowLeft: -1, ArrowDown: columns(), ArrowUp: -columns()}[event.key]
  let next = step === undefined ? {Home: 0, End: list.length - 1}[event.key] : place + step
  if (next === undefined || place < 0) return
  event.preventDefault()
  event.stopPropagation()
  list[Math.max(0, Math.min(list.length - 1, next))]?.focus()
}
const mounted = new WeakMap()
/** Show `nodes` in a component and listen on the window. Panel may render a view anew without taking the old rendering
 * down, so what was there before goes first. */
function mount({view, model, el}, nodes, listeners = {}) {
  mounted.get(view)?.()
  el.replaceChildren(...nodes)
  for (const [name, act] of Object.entries(listeners)) window.addEventListener(name, act, name === "keydown")
  const takeDown = () => { for (const [name, act] of Object.entries(listeners)) window.removeEventListener(name, act, name === "keydown") }
  mounted.set(view, takeDown)
  model.on("lifecycle:remove", takeDown)
}
