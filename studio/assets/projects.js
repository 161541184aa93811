// The projects: open another, begin a new one, delete and bring back; and where everything is saved, or why it is not.
export function render(part) {
  const {model} = part
  const send = (message) => model.send_msg(message)
  const dialog = h("dialog", {class: "projects", "aria-label": "Projects"})
  const open = () => {
    if (dialog.open) return
    send({do: "list"})
    dialog.showModal()
    dialog.querySelector("input")?.focus()
  }
  const onKey = (event) => {
    if (!(event.ctrlKey || event.metaKey) || !event.shiftKey || event.key.toLowerCase() !== "p") return
    event.preventDefault()
    open()
  }
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close() })
  dialog.addEventListener("keydown", (event) => {
    event.stopPropagation()  // the stage's keys rest while the list is open
    if (event.target.matches(".open")) arrows(event, () => [...dialog.querySelectorAll(".open")])
    else if (event.key === "ArrowDown" && event.target.matches("input")) { event.preventDefault(); dialog.querySelector(".open")?.focus() }
  })
  mount(part, [dialog], {"motionloom:projects": open, keydown: onKey})
  let waiting = 0
  let unfolded = false
  const look = (event) => {
    const text = event.target.value
    clearTimeout(waiting)
    waiting = setTimeout(() => { model.search = text }, 150)
  }
  const go = (project, take = "") => () => { send({do: "open", key: project.key, take}); dialog.close() }
  watch(model, ["projects", "deleted", "current", "search", "saved", "saved_note"], () => {
    const kept = model.saved !== "memory"
    redraw(dialog,
      h("div", {class: "title"}, h("h3", {}, "Projects"), h("button", {class: "btn icon quiet", type: "button", "data-key": "close", "aria-label": "Close projects", onclick: () => dialog.close()}, icon("cross"))),
      h("div", {class: `note ${model.saved}`, role: "status"}, icon(model.saved === "saved" ? "disk" : "warning"), h("span", {}, model.saved_note),
        model.saved === "unsaved" && h("button", {class: "btn", type: "button", onclick: () => send({do: "retry"})}, "Try again")),
      kept && h("div", {class: "row"},
        h("input", {class: "field", type: "search", "data-key": "search", value: model.search, placeholder: "Find a project, or a take in any of them", "aria-label": "Find a project or a take", oninput: look}),
        h("button", {class: "btn primary", type: "button", "data-key": "new", onclick: () => { send({do: "new"}); dialog.close() }}, icon("plus"), "New project")),
      kept && h("ul", {class: "list", "data-key": "list", "aria-label": "Projects"}, ...model.projects.map((project) => row(model, project, go, send))),
      kept && model.projects.length === 0 && h("p", {class: "hint", "data-key": "none"}, model.search ? "No project and no take fits." : "What you work in appears here."),
      kept && model.deleted.length > 0 && h("details", {"data-key": "deleted", open: unfolded, ontoggle: (event) => { unfolded = event.target.open }}, h("summary", {}, `Deleted in the last 30 days (${model.deleted.length})`),
        h("ul", {class: "list"}, ...model.deleted.map((project) => h("li", {class: "project gone", "data-key": project.key},
          h("span", {class: "open"}, h("b", {}, project.name), h("span", {class: "about"}, project.about)),
          h("button", {class: "btn", type: "button", "aria-label": `Bring back ${project.name}`, onclick: () => send({do: "restore", key: project.key})}, icon("undo"), "Bring back"))))))
  })
}
function row(model, project, go, send) {
  const here = project.key === model.current
  return h("li", {class: `project ${here ? "on" : ""}`, "data-key": project.key},
    h("button", {class: "open", type: "button", "aria-current": here ? "true" : null, onclick: go(project)}, h("b", {}, project.name), h("span", {class: "about"}, here ? `open · ${project.about}` : project.about)),
    h("button", {class: "btn icon quiet", type: "button", "aria-label": `Delete ${project.name}`, title: "Delete; it can be brought back for 30 days", onclick: () => send({do: "delete", key: project.key})}, icon("trash")),
    project.found.length > 0 && h("div", {class: "found"}, ...project.found.map(({id, text}) => h("button", {class: "chip", type: "button", "data-key": id, onclick: go(project, id)}, text)),
      project.more > 0 && h("span", {class: "about"}, `and ${project.more} more`)))
}
