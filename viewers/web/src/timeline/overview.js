// All of the sequence in a strip, with the part that is in view; only where that is not all of it, its place kept free.
import { h } from "../ui/dom.js";
import { follow, prepare } from "../ui/timeline.js";

export class Overview {
  constructor(sequencer) {
    this.sequencer = sequencer;
    this.canvas = h("canvas", { "aria-hidden": "true" });
    this.window = h("div", { class: "seq-window" });
    this.now = h("div", { class: "seq-now" });
    this.element = h("div", { class: "seq-overview", "aria-hidden": "true" }, this.canvas, this.window, this.now);
    this.element.addEventListener("pointerdown", (event) => this.#down(event));
  }

  render() {
    const { sequencer } = this;
    this.element.style.visibility = sequencer.fitted ? "hidden" : "";
    if (sequencer.fitted) return;
    const { context, width, height } = prepare(this.canvas);
    this.scale = width / sequencer.length;
    for (const { block, start, end } of sequencer.spans) {
      context.fillStyle = sequencer.hues.get(block.what);
      context.fillRect(start * this.scale, 2, Math.max((end - start) * this.scale - 0.5, 0.5), height - 4);
    }
    const from = Math.max(sequencer.from, 0);
    this.window.style.cssText = `left:${from * this.scale}px;width:${Math.max((Math.min(sequencer.to, sequencer.length) - from) * this.scale, 6)}px`;
  }

  tick(now) {
    if (!this.sequencer.fitted) this.now.style.transform = `translateX(${now * this.scale}px)`;
  }

  #down(event) {
    if (event.button !== 0) return;
    event.preventDefault();
    const { sequencer } = this;
    const go = (at) => {
      const time = (at.clientX - this.element.getBoundingClientRect().left) / this.scale;
      sequencer.scroll(time - (sequencer.to - sequencer.from) / 2);
    };
    this.element.setPointerCapture(event.pointerId);
    go(event);
    follow(this.element, go, () => {});
  }
}
