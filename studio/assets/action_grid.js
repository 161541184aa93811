// The actions, or the styles, that an engine knows, on shelves; the picture of the one under the pointer or focus moves.
export function render(part) {
  const {model} = part
  let shelf = "all"
  let typed = ""
  let shown = null
  const shelves = h("div", {class: "shelves", role: "radiogroup", "aria-label": `Group of ${model.noun}s`})
  const grid = h("div", {class: "grid", role: "listbox", "aria-label": `${model.noun[0].toUpperCase()}${model.noun.slice(1)}s this engine knows`})
  const empty = h("p", {class: "hint none"}, `No ${model.noun} of that name.`)
  const title = h("h4")
  const cards = () => [...grid.children]
  const columns = () => getComputedStyle(grid).gridTemplateColumns.split(" ").length
  grid.addEventListener("keydown", (event) => arrows(event, cards, columns))
  shelves.addEventListener("keydown", (event) => arrows(event, () => [...shelves.children]))
  const onBrowse = () => (grid.querySelector('[tabindex="0"]') ?? grid.firstElementChild)?.focus()
  const onSearch = (event) => { typed = event.detail.trim().toLowerCase(); draw() }
  const draw = () => {
    const named = new Map(model.actions.map((action) => [action.name, action]))
    const found = typed ? matching([...named.keys()], typed).map((name) => named.get(name)) : model.actions.filter(({group}) => shelf === "all" || group === shelf)
    title.textContent = typed ? `${found.length} of ${model.actions.length} ${model.noun}s` : `${model.actions.length} ${model.noun}s this engine knows`
    const groups = ["all", ...new Set(model.actions.map(({group}) => group))]
    shelves.hidden = Boolean(typed) || groups.length < 3
    redraw(shelves, ...groups.map((group) => {
      const pick = () => { shelf = group; draw() }
      return h("button", {type: "button", role: "radio", "data-key": group, "aria-checked": String(group === shelf), tabindex: group === shelf ? "0" : "-1", onclick: pick}, group)
    }))
    const current = found.some(({name}) => name === model.value) ? model.value : found[0]?.name
    redraw(grid, ...found.map((action) => card(model, action, action.name === current, () => { typed = ""; draw() })))
    empty.hidden = found.length > 0
    const chosen = model.value !== shown && cards().find((one) => one.dataset.key === model.value)
    if (chosen) { chosen.scrollIntoView({block: "nearest"}); shown = model.value }
  }
  const heard = model.noun === "action" ? {"motionloom:browse": onBrowse, "motionloom:search": onSearch} : {}
  mount(part, [title, shelves, h("div", {class: "scroll"}, grid, empty)], heard)
  watch(model, ["actions", "value", "adds"], draw)
}
function card(model, {name, description, picture}, reachable, forget) {
  const view = h("span", {class: "picture"})
  if (picture) view.style.backgroundImage = `url("${picture}")`
  else view.append(icon("person"))
  if (picture) view.classList.add("strip")
  return h("button", {
    type: "button", role: "option", class: "action", "data-key": name, "aria-selected": String(name === model.value), tabindex: reachable ? "0" : "-1", title: description,
    onclick: () => {
      forget()
      if (model.adds) return model.send_msg({do: "add", what: name})
      model.value = name
      if (model.noun === "action") window.dispatchEvent(new CustomEvent("motionloom:chosen", {detail: name}))
    },
    ondblclick: () => { if (!model.adds) model.send_msg({do: "generate"}) },
    draggable: model.adds ? "true" : null, ondragstart: (event) => event.dataTransfer.setData("application/x-motionloom-block", JSON.stringify({what: name})),
  }, view, h("span", {class: "words"}, name))
}
