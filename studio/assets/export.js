// The file being written: progress and cancel, then the download.
export function render(part) {
  const {model} = part
  const box = h("div", {class: "box"})
  mount(part, [box])
  const size = (bytes) => bytes < 1e6 ? `${Math.max(1, Math.round(bytes / 1e3))} kB` : `${(bytes / 1e6).toFixed(1)} MB`
  // of the page, not of this drawing: a panel drawn anew neither fetches a file again nor misses one finished meanwhile
  const fetched = window.motionloomFetched ??= new Set()
  watch(model, ["status", "progress", "error", "file", "url", "bytes", "ready", "label"], () => {
    const busy = model.status === "queued" || model.status === "running"
    // properties arrive one by one: the next export's empty address may come while the last one still counts as done
    const done = model.status === "done" && model.url !== ""
    const percent = Math.round(model.progress * 100)
    redraw(box,
      busy
        ? h("div", {class: "work"},
            h("div", {class: "row"}, h("span", {class: "file"}, model.file), h("span", {class: "number"}, model.status === "queued" ? "in line" : `${percent}%`)),
            h("progress", {max: "1", value: String(model.progress), "aria-label": `Exporting ${model.file}`}),
            h("button", {class: "btn wide", type: "button", "data-key": "main", onclick: () => model.send_msg({do: "cancel"})}, icon("cross"), "Cancel"))
        : h("button", {class: "btn primary wide", type: "button", "data-key": "main", disabled: !model.ready, onclick: () => model.send_msg({do: "export"})}, model.label),
      h("div", {role: "status"},
        done && h("a", {class: "btn wide link", "data-key": "link", href: model.url, download: model.file}, icon("download"), h("span", {class: "file"}, model.file), h("span", {class: "number"}, size(model.bytes))),
        model.status === "failed" && h("p", {class: "fault", role: "alert"}, model.error),
        model.status === "cancelled" && h("p", {class: "hint"}, "Cancelled; nothing was written.")))
    if (done && !fetched.has(model.url)) {
      fetched.add(model.url)
      box.querySelector("a.link").click()
    }
  })
}
