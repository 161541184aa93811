export function render(part) {
  const {model} = part
  const send = (what) => () => model.send_msg({do: what})
  const bar = h("div", {class: "bar", role: "toolbar", "aria-label": "Studio"})
  mount(part, [bar])
  watch(model, ["scene", "undo_name", "redo_name", "theme", "saved", "saved_note"], () => {
    const dark = model.theme === "dark"
    const scene = h("input", {
      class: "scene", "data-key": "scene", "aria-label": "Project name", title: "Rename the project", value: model.scene, spellcheck: "false", maxlength: "60",
      onchange: (event) => { model.scene = event.target.value.trim() || "Untitled scene" },
      onkeydown: (event) => { if (event.key === "Enter") event.target.blur() },
    })
    const undo = model.undo_name ? `Undo ${model.undo_name}` : "Nothing to undo"
    const redo = model.redo_name ? `Redo ${model.redo_name}` : "Nothing to redo"
    redraw(bar,
      h("b", {class: "name"}, mark(), "motionloom"), scene,
      h("button", {class: "btn icon quiet", "data-key": "projects", "aria-label": "Projects: open another, begin a new one", title: "Projects (Ctrl+Shift+P)", onclick: () => window.dispatchEvent(new CustomEvent("motionloom:projects"))}, icon("folder")),
      state(model), h("span", {class: "space"}),
      h("button", {class: "btn icon", "data-key": "undo", "aria-label": undo, title: `${undo} (Ctrl+Z)`, disabled: !model.undo_name, onclick: send("undo")}, icon("undo")),
      h("button", {class: "btn icon", "data-key": "redo", "aria-label": redo, title: `${redo} (Ctrl+Shift+Z)`, disabled: !model.redo_name, onclick: send("redo")}, icon("redo")),
      h("button", {class: "btn", "data-key": "import", title: "Import a motion file (Ctrl+O)", onclick: send("import")}, icon("upload"), "Import"),
      h("button", {class: "btn primary", "data-key": "export", title: "Export the selected take (Ctrl+E)", onclick: send("export")}, icon("download"), "Export"),
      h("button", {class: "btn icon", "data-key": "theme", "aria-label": dark ? "Use light colours" : "Use dark colours", title: dark ? "Light colours" : "Dark colours",
        onclick: () => { model.theme = dark ? "light" : "dark" }}, icon(dark ? "sun" : "moon")),
      h("button", {class: "btn icon", "data-key": "help", "aria-label": "Help and keyboard shortcuts", title: "Help (?)",
        onclick: () => window.dispatchEvent(new CustomEvent("motionloom:help"))}, icon("help")),
    )
  })
}
/** Whether everything is saved, in a word; a press on it tells more. */
function state(model) {
  const [text, shape, level] = {saved: ["Saved", "check", "good"], unsaved: ["Not saved", "warning", "poor"], memory: ["In memory only", "warning", "fair"]}[model.saved]
  return h("button", {class: `saved ${level}`, type: "button", "data-key": "saved", title: model.saved_note, "aria-label": `${text}. ${model.saved_note}`,
    onclick: () => window.dispatchEvent(new CustomEvent("motionloom:projects"))}, icon(shape), h("span", {role: "status"}, text))
}
function mark() {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg")
  svg.setAttribute("viewBox", "0 0 24 24")
  svg.setAttribute("class", "mark")
  svg.setAttribute("aria-hidden", "true")
  svg.innerHTML = '<path d="M3 17c3-11 6-11 9 0s6 11 9-10" /><path d="M3 8c3 11 6 11 9 0s6-9 9 9" />'
  return svg
}
