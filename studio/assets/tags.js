// The words given to the selected take: type one and press Enter; a press on one takes it away.
export function render(part) {
  const {model} = part
  const box = h("section", {class: "box"})
  mount(part, [box], {"motionloom:tag": () => box.querySelector("input")?.focus()})
  const change = (tags) => model.send_msg({do: "tags", tags})
  const add = (field) => {
    const text = field.value.trim()
    field.value = ""
    if (text) change([...model.words, ...text.split(",")])
  }
  watch(model, ["words", "known", "take"], () => {
    box.hidden = !model.take
    redraw(box, h("div", {class: "tags"}, h("h4", {}, "Tags"),
      ...model.words.map((tag) => h("button", {class: "chip", type: "button", "data-key": `tag ${tag}`, "aria-label": `Remove the tag ${tag}`, title: "Remove this tag", onclick: () => change(model.words.filter((other) => other !== tag))}, tag, icon("cross"))),
      h("input", {class: "field", "data-key": "field", list: "known", maxlength: "40", placeholder: model.words.length ? "another" : "add a tag", "aria-label": `Add a tag to ${model.take.toLowerCase()}`,
        onkeydown: (event) => {
          event.stopPropagation()
          if (event.key === "Enter" || event.key === ",") { event.preventDefault(); add(event.target) }
          else if (event.key === "Backspace" && !event.target.value && model.words.length) change(model.words.slice(0, -1))
        },
        onchange: (event) => add(event.target)}),
      h("datalist", {id: "known", "data-key": "known"}, ...model.known.filter((tag) => !model.words.includes(tag)).map((tag) => h("option", {value: tag})))))
  })
}
