// The page as a whole: colours, shortcuts, a line in the corner, help. It draws nothing of its own in the layout.
const HELP = [
  ["Everywhere", [["Ctrl Enter", "generate"], ["Ctrl Z", "undo"], ["Ctrl Shift Z", "redo"], ["Ctrl O", "import a file"], ["Ctrl E", "export the selected take"], ["Ctrl Shift P", "projects"], ["?", "this help"]]],
  ["Takes", [["↑ ↓", "pick another"], ["F", "star"], ["K", "keep"], ["C", "compare (or Ctrl click)"], ["Shift click", "compare a row"], ["A", "again, on another seed"], ["Y", "in another manner"], ["T", "tag"], ["Del", "delete"]]],
  ["Stage", [["Space", "play or pause"], ["← →", "one frame back or on"], ["Shift ← →", "ten frames"], ["Home End", "first or last frame"], ["I O", "loop from here, to here"], ["S", "body, skeleton, both"], ["G T C", "ghosts, trail, foot contacts"], ["V", "overlaid or side by side"], ["F", "follow the picked one"], ["1 2 3 4", "front, back, left, right"], ["0", "everybody in view"], ["P", "picture of the stage"], ["Esc", "put the drawing tool down"]]],
  ["Blocks", [["← →", "the one before, the next"], ["Shift ← →", "move it"], ["Alt ← →", "shorter, longer"], ["Enter", "edit"], ["R S D", "regenerate, split, duplicate"], ["L Del", "lock, delete"], ["wheel", "zoom (Shift wheel: along)"]]],
  ["Actions", [["type", "search"], ["↓", "into the grid"], ["arrows", "move"], ["Enter", "choose"]]],
]
export function render(part) {
  const {model} = part
  const toast = h("div", {class: "toast", role: "status", hidden: true})
  const dialog = h("dialog", {class: "help", "aria-label": "Help"},
    h("div", {class: "title"}, h("h3", {}, "Keyboard"), h("button", {class: "btn icon", type: "button", "aria-label": "Close help", onclick: () => dialog.close()}, icon("cross"))),
    h("div", {class: "columns"}, ...HELP.map(([name, keys]) => h("section", {}, h("h4", {}, name),
      h("dl", {}, ...keys.flatMap(([key, what]) => [h("dt", {}, ...key.split(" ").flatMap((part) => [h("kbd", {}, part), " "])), h("dd", {}, what)]))))),
    h("p", {class: "hint"}, "Drag to turn the camera, scroll to come nearer, drag with the right button to move aside. Drop a motion file anywhere to import it."),
    h("p", {class: "hint"}, model.about))
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close() })
  const lost = h("div", {class: "lost", role: "alert", hidden: true}, icon("warning"), h("span", {}, "The studio does not answer. Everything shown as saved is safe; this page opens again by itself once it is back."))
  const veil = h("div", {class: "veil", hidden: true}, h("div", {}, icon("upload"), "Drop to import"))

  const deepActive = () => { let node = document.activeElement; while (node?.shadowRoot?.activeElement) node = node.shadowRoot.activeElement; return node }
  const typing = (node) => node && (node.tagName === "TEXTAREA" || node.tagName === "SELECT" || (node.tagName === "INPUT" && !["range", "checkbox", "radio", "button"].includes(node.type)))
  const onKey = (event) => {
    const command = event.ctrlKey || event.metaKey
    const active = deepActive()
    if (command && event.key === "Enter") {
      event.preventDefault()
      if (typing(active)) active.blur()  // takes over what was being typed
      setTimeout(() => model.send_msg({do: "generate"}), 60)
    } else if (command && event.key.toLowerCase() === "z" && !typing(active)) {
      event.preventDefault()
      model.send_msg({do: event.shiftKey ? "redo" : "undo"})
    } else if (command && event.key.toLowerCase() === "y" && !typing(active)) {
      event.preventDefault()
      model.send_msg({do: "redo"})
    } else if (command && event.key.toLowerCase() === "o") {
      event.preventDefault()
      model.send_msg({do: "import"})
    } else if (command && event.key.toLowerCase() === "e") {
      event.preventDefault()
      model.send_msg({do: "export"})
    } else if (event.key === "?" && !command && !typing(active)) {
      event.preventDefault()
      event.stopPropagation()
      if (!dialog.open) dialog.showModal()
    }
  }
  const onHelp = () => { if (!dialog.open) dialog.showModal() }
  mount(part, [toast, dialog, lost, veil], {keydown: onKey, "motionloom:help": onHelp, ...fileListeners(veil)})
  let timer = 0
  model.on("message", () => {
    if (!model.message) return
    toast.textContent = model.message
    toast.hidden = false
    clearTimeout(timer)
    timer = setTimeout(() => { toast.hidden = true }, 3500)
  })
  model.on("msg:custom", (message) => {
    if (message?.choose) window.dispatchEvent(new CustomEvent("motionloom:choose-file"))
  })
  const saved = document.documentElement.dataset.theme
  if (saved && saved !== model.theme) model.theme = saved
  watch(model, ["theme"], () => {
    document.documentElement.dataset.theme = model.theme
    try { localStorage.setItem("motionloom-theme", model.theme) } catch { /* private window */ }
  })
  watch(model, ["title"], () => { document.title = model.title })
  watch(model, ["address", "cookie"], () => follow(model))
  mind(lost)
  requestAnimationFrame(() => document.getElementById("splash")?.classList.add("gone"))
}
/** The address says what is shown, and a cookie which project was open last. */
function follow({address, cookie}) {
  if (!address.project) return
  const query = new URLSearchParams(location.search)
  for (const [name, value] of Object.entries(address)) if (value) query.set(name, value); else query.delete(name)
  const next = `${location.pathname}?${query}`
  if (next !== location.pathname + location.search) history.replaceState(history.state, "", next)
  if (cookie) document.cookie = `${cookie}=${address.project}; path=/; max-age=31536000; samesite=strict`
}
/** The studio may be stopped and started again while the page is open: it says so, and comes back with the same takes. */
function mind(lost) {
  for (const shown of Bokeh.documents) {
    Object.assign(shown.config, {reconnect_session: false, notify_connection_status: false})
    shown.on_event("connection_lost", () => {
      if (!lost.hidden) return
      lost.hidden = false
      const ask = async () => {
        const answer = await fetch("assets/favicon.svg", {cache: "no-store"}).catch(() => null)
        if (answer?.ok) location.reload()
        else setTimeout(ask, 1000)
      }
      setTimeout(ask, 500)
    })
  }
}
/** A file dropped anywhere is handed to the import. */
function fileListeners(veil) {
  let depth = 0
  const carried = (act) => (event) => {
    if (![...(event.dataTransfer?.types ?? [])].includes("Files")) return
    event.preventDefault()
    depth = Math.max(0, act(event))
    veil.hidden = depth === 0
  }
  return {
    dragenter: carried(() => depth + 1),
    dragover: carried(() => Math.max(depth, 1)),
    dragleave: carried(() => depth - 1),
    drop: carried((event) => { window.dispatchEvent(new CustomEvent("motionloom:file", {detail: event.dataTransfer.files[0]})); return 0 }),
  }
}
