// Blocks for the timeline: described in words, or a clip of the picked take; and what goes for all of them.
export function render(part) {
  const {model} = part
  const send = (what, more = {}) => model.send_msg({do: what, ...more})
  const words = h("input", {class: "field", id: "block-words", maxlength: "1000", placeholder: "a person waves, proudly", autocomplete: "off", onkeydown: (event) => { if (event.key === "Enter" && !event.ctrlKey && !event.metaKey) add() }})
  const add = () => {
    if (!words.value.trim()) return
    send("add", {kind: "prompt", what: words.value.trim(), seconds: 4})
    words.value = ""
  }
  const described = h("div", {}, h("label", {for: "block-words"}, "A block in words"),
    h("div", {class: "row"}, words, h("button", {class: "btn add", type: "button", title: "Add it behind the picked block (Enter)", onclick: add}, icon("plus"), "Add")))
  const clip = h("button", {class: "btn", type: "button", title: "The picked take, as it is shown, becomes a block", onclick: () => send("clip")})
  const renew = h("button", {class: "btn", type: "button", title: "Other seeds for all blocks that are not locked, and the sequence made with them", onclick: () => send("renew")}, icon("dice"), "New seeds")
  const clear = h("button", {class: "btn", type: "button", title: "Take all blocks away; undo brings them back", onclick: () => send("clear")}, icon("broom"), "Clear")
  const note = h("p", {class: "hint", role: "status"})
  const fault = h("p", {class: "fault", role: "alert"})
  mount(part, [h("section", {class: "whole", "aria-label": "Blocks"}, described, h("div", {class: "row"}, clip), h("div", {class: "row"}, renew, clear), note, fault)])
  watch(model, ["take", "words", "blocks", "about", "how", "error"], () => {
    described.hidden = !model.words
    redraw(clip, icon("frames"), model.take ? `Add ${model.take} as a clip` : "Pick a take to add it")
    clip.disabled = !model.take
    renew.disabled = clear.disabled = !model.blocks
    note.textContent = `${model.about || "Press an action, or drag it onto the timeline."} ${model.how}`
    fault.textContent = model.error
    fault.hidden = !model.error
  })
}
