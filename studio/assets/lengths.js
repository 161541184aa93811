// How long motions of the prompt may be: a bar a length, the one that is asked marked.
export function render(part) {
  const {model} = part
  const bars = h("div", {class: "bars", "aria-hidden": "true"})
  const words = h("span", {class: "words", role: "status"})
  const take = h("button", {class: "btn", type: "button", onclick: () => model.send_msg({do: "take", seconds: model.likeliest})})
  mount(part, [bars, h("div", {class: "line"}, words, take)])
  watch(model, ["seconds", "chances", "words", "likeliest", "asked"], () => {
    const most = Math.max(...model.chances, 1e-9)
    const nearest = near(model.seconds, model.asked)
    redraw(bars, ...model.seconds.map((seconds, place) => h("button", {
      type: "button", tabindex: "-1", class: place === nearest ? "on" : null,
      title: `${seconds.toFixed(1)} s: ${(100 * model.chances[place]).toFixed(1)} %`,
      onclick: () => model.send_msg({do: "take", seconds}),
    }, h("i", {style: `height: ${Math.max(3, 100 * model.chances[place] / most)}%`}))))
    words.textContent = model.words
    take.textContent = `Take ${model.likeliest.toFixed(1)} s`
    take.hidden = nearest >= 0 && model.seconds[nearest] === model.likeliest
  })
}
/** The place of the length nearest to the one that is asked; -1 where that is longer or shorter than all. */
function near(lengths, asked) {
  if (!lengths.length || asked > lengths.at(-1) + 0.1 || asked < lengths[0] - 0.1) return -1
  return lengths.reduce((best, seconds, place) => Math.abs(seconds - asked) < Math.abs(lengths[best] - asked) ? place : best, 0)
}
