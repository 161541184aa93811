// The help overlay: every key, closable with Esc.
import { button, h } from "./dom.js";

const KEYS = [
  ["Space", "play or pause"],
  ["← →  or  , .", "one frame back or on (with Shift: ten, with the arrows)"],
  ["Home  End", "first or last frame"],
  ["I  O", "start or end of the looped selection here (or Shift-drag the ruler)"],
  ["L", "loop off, all, selection"],
  ["S", "body, skeleton, both"],
  ["G  T  C", "ghosts, trail, foot contacts"],
  ["V", "several figures in one place, or side by side"],
  ["F", "follow the figure"],
  ["1  2  3  4", "front, back, left, right"],
  ["0", "frame everything"],
  ["Alt + arrows", "orbit; + and − zoom"],
  ["P", "download a picture"],
  ["Esc", "put down what the mouse draws with"],
  ["?", "this help"],
];

export class Help {
  constructor() {
    this.close = button({ label: "Close help", symbol: "close", key: "Escape", className: "icon close", onclick: () => this.show(false) });
    const rows = KEYS.flatMap(([keys, what]) => [h("dt", {}, ...keys.split(/\s{2,}/).map(keycap)), h("dd", {}, what)]);
    this.element = h("div", { class: "help", role: "dialog", "aria-modal": "true", "aria-label": "Help: keys and pointer", hidden: true, tabindex: -1 },
      h("div", { class: "sheet" }, h("h2", {}, "Keys"), this.close, h("dl", {}, ...rows),
        h("p", {}, "Drag the stage to orbit, right-drag to pan, wheel to zoom. Click a figure to pick it. Click a label to go there, double-click to loop it.")));
    this.element.addEventListener("keydown", (event) => this.#keys(event));
    this.element.addEventListener("click", (event) => { if (event.target === this.element) this.show(false); });
  }

  // The close button is the only control inside, so Tab has nowhere else to go.
  #keys(event) {
    if (event.key === "Tab") {
      event.preventDefault();
      this.close.focus();
    }
  }

  get open() {
    return !this.element.hidden;
  }

  show(on) {
    if (on === this.open) return;
    const root = this.element.getRootNode();
    if (on) this.before = root.activeElement;
    this.element.hidden = !on;
    (on ? this.close : this.before)?.focus?.();
  }
}

function keycap(text) {
  return text === "or" ? h("span", {}, "or") : h("kbd", {}, text);
}
