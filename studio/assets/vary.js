// What can be made of takes: a blend of two; or, as the section says, another action from the playhead on, other ways to go on.
export function render(part) {
  const {model} = part
  const send = (what, more = {}) => model.send_msg({do: what, ...more})
  // told with the press: what was typed last may else arrive after it
  const told = () => ({action: action.value.trim(), seconds: Number(seconds.value), count: Math.round(Number(ways.value))})
  const select = (id, label, change) => h("select", {class: "field", id, "aria-label": label, onchange: (event) => change(event.target.value)})
  const from = select("blend-from", "Blend from", (value) => { model.first = value })
  const to = select("blend-to", "Blend to", (value) => { model.second = value })
  const pick = (which, name) => h("button", {class: "btn icon", type: "button", title: `The picked take as the ${name}`, "aria-label": `The picked take as the ${name}`, onclick: () => { model[which] = model.selected }}, icon("pick"))
  const strip = h("div", {class: "strip", role: "group", "aria-label": "What lies between"})
  const slider = h("input", {type: "range", id: "blend-share", min: "0", max: "1", step: "0.05", "aria-label": "How far from the one to the other", oninput: () => { model.share = Number(slider.value) }})
  const share = h("output", {for: "blend-share", class: "share"})
  const keep = h("button", {class: "btn primary", type: "button", onclick: () => send("keep")}, icon("check"), "Keep this one")
  const mixed = h("div", {class: "mixed"}, strip, h("div", {class: "row"}, slider, share), keep)
  const blendNote = h("p", {class: "hint", role: "status"})
  const blend = h("section", {"aria-label": "Between two takes"}, h("h4", {}, "Between two takes"),
    h("div", {class: "row"}, h("label", {for: "blend-from"}, "From"), from, pick("first", "one to begin with")),
    h("div", {class: "row"}, h("label", {for: "blend-to"}, "To"), to, pick("second", "one to end with")), blendNote, mixed)

  const action = h("input", {class: "field", id: "next-action", list: "next-actions", placeholder: "as before", autocomplete: "off", onchange: () => { model.action = action.value.trim() }})
  const known = h("datalist", {id: "next-actions"})
  const seconds = h("input", {class: "field", id: "next-seconds", type: "number", min: "0.1", max: "600", step: "0.5", onchange: () => { const value = Number(seconds.value); if (value >= 0.1 && value <= 600) model.seconds = value; else seconds.value = String(model.seconds) }})
  const ways = h("input", {class: "field", id: "next-ways", type: "number", min: "1", max: "32", step: "1", onchange: () => { const value = Math.round(Number(ways.value)); if (value >= 1 && value <= 32) model.count = value; else ways.value = String(model.count) }})
  const goOn = h("button", {class: "btn primary wide", type: "button", onclick: () => send("go_on", told())})
  const change = h("button", {class: "btn wide", type: "button", onclick: () => send("change", told())})
  const stop = h("button", {class: "btn wide", type: "button", onclick: () => send("cancel")}, icon("cross"), "Cancel")
  const fault = h("p", {class: "fault", role: "alert"})
  const later = h("section", {"aria-label": "From the playhead on"}, h("h4", {}, "From the playhead on"),
    h("label", {for: "next-action"}, "What follows"), action, known,
    h("div", {class: "pair"}, h("div", {}, h("label", {for: "next-seconds"}, "Seconds"), seconds), h("div", {}, h("label", {for: "next-ways"}, "Ways"), ways)),
    goOn, h("p", {class: "hint about"}, "Keeps the take as it is up to the playhead."), change, h("p", {class: "hint about"}, "Draws anew: its action up to the playhead, then this one."), stop, fault)
  mount(part, [model.section === "later" ? later : blend])

  const choices = (field, value, other) => {
    const rest = model.sources.filter(({id}) => id !== other || id === value)
    const wanted = [["", "choose a take"], ...rest.map(({id, text}) => [id, text])]
    const now = JSON.stringify(wanted)
    if (field.dataset.now !== now) {
      field.dataset.now = now
      field.replaceChildren(...wanted.map(([key, text]) => h("option", {value: key}, text)))
    }
    field.value = wanted.some(([key]) => key === value) ? value : ""
  }
  watch(model, ["sources", "first", "second", "share", "strip", "problem", "mixing", "selected"], () => {
    choices(from, model.first, "")
    choices(to, model.second, model.first)
    const ready = model.strip.length > 0 || model.between
    mixed.hidden = !model.between
    blendNote.textContent = model.problem || (model.mixing ? "Working out what lies between…" : "") || (model.sources.length < 2 ? "Two takes of one action are needed; generate some." : model.first && model.second ? "" : "Choose two takes of the same action and length.")
    blendNote.className = model.problem ? "fault" : "hint"
    blendNote.hidden = !blendNote.textContent
    slider.value = String(model.share)
    share.textContent = `${Math.round(model.share * 100)} %`
    slider.setAttribute("aria-valuetext", `${Math.round(model.share * 100)} percent of the way`)
    const last = Math.max(1, model.strip.length - 1)
    const nearest = Math.round(model.share * last)
    redraw(strip, ...model.strip.map((picture, place) => h("button", {
      class: `step ${place === nearest ? "on" : ""}`, type: "button", "data-key": String(place), tabindex: "-1", "aria-label": `${Math.round(100 * place / last)} percent`,
      onclick: () => { model.share = Math.round(20 * place / last) / 20 },
    }, h("img", {src: picture, alt: "", width: "34", height: "44"}))))
    strip.hidden = !ready
  })
  model.on("between", () => { mixed.hidden = !model.between })
  watch(model, ["actions", "action", "seconds", "count", "at", "busy", "error", "selected", "change_problem", "go_problem"], () => {
    redraw(known, ...model.actions.map((name) => h("option", {value: name, "data-key": name})))
    const focused = part.el.getRootNode().activeElement ?? null
    for (const [field, value] of [[action, model.action], [seconds, model.seconds], [ways, model.count]]) if (field !== focused) field.value = String(value)
    const none = !model.selected
    goOn.replaceChildren(icon("frames"), `Go on from ${model.at}`)
    change.replaceChildren(icon("again"), `Change at ${model.at}`)
    goOn.disabled = none || model.busy || Boolean(model.go_problem)
    change.disabled = none || model.busy || Boolean(model.change_problem)
    goOn.title = model.go_problem
    change.title = model.change_problem
    stop.hidden = !model.busy
    fault.textContent = model.error || [model.go_problem, model.change_problem].filter(Boolean).join(" ")
    fault.hidden = !fault.textContent
    fault.classList.toggle("quiet", !model.error)
  })
}
