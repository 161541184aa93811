// Blocks one after the other, to be arranged: the timeline of a sequence, in place of the plain one.
import { h } from "../ui/dom.js";
import { follow, prepare } from "../ui/timeline.js";
import { huesOf } from "../hues.js";
import { Blocks } from "./blocks.js";
import { Editor } from "./editor.js";
import { Gestures } from "./gestures.js";
import { onBlockKey } from "./keys.js";
import { clockText, layOut, lengthOf, round, spanAt, tickStep } from "./layout.js";
import { Menu } from "./menu.js";
import { Overview } from "./overview.js";
import { Plan } from "./plan.js";
import { Tools } from "./tools.js";

const PAD = 8; // pixels before the first second and behind the last
const LEAST = 4; // seconds the window shows at least where everything is in view
const CLOSEST = 400; // pixels a second

export class Sequencer {
  constructor(player) {
    this.player = player;
    this.spans = [];
    this.hues = new Map();
    this.draft = null; // blocks as a hand moves them, until the answer comes
    this.floating = null; // {id, left}: the block in that hand
    this.from = 0;
    this.scale = 50;
    this.fitted = true;
    this.width = 0; // of the view in pixels, kept: asking the page for it in between costs a layout each time
    this.blocks = new Blocks(this);
    this.editor = new Editor(this);
    this.menu = new Menu(this);
    this.tools = new Tools(this);
    this.overview = new Overview(this);
    this.plan = new Plan(player);
    this.marks = h("canvas", { class: "marks", "aria-hidden": "true" });
    this.ruler = h("div", { class: "ruler", role: "slider", tabindex: 0, "aria-label": "Scrub", "aria-valuemin": 0 }, this.marks);
    this.playhead = h("div", { class: "seq-playhead", "aria-hidden": "true" });
    this.mark = h("div", { class: "drop-mark", hidden: true });
    this.empty = h("p", { class: "seq-empty" }, "Drag an action here, or press one in the list.");
    this.view = h("div", { class: "seq-view" }, this.ruler, this.blocks.element, this.empty, this.mark, this.playhead);
    this.element = h("div", { class: "sequencer", role: "group", "aria-label": "Sequence", hidden: true },
      this.tools.element, this.view, this.overview.element, this.editor.element, this.menu.element);
    this.gestures = new Gestures(this);
    this.#listen();
  }

  #listen() {
    const { player, view } = this;
    player.addEventListener("sequence", () => this.#receive());
    this.observer = new ResizeObserver(() => this.#resized());
    this.observer.observe(view);
    view.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    this.ruler.addEventListener("pointerdown", (event) => this.#scrub(event));
    this.blocks.element.addEventListener("focusin", ({ target }) => { if (target.dataset.part === "block") this.pick(target.dataset.id); });
    this.blocks.element.addEventListener("keydown", (event) => {
      if (onBlockKey(this, event)) {
        event.preventDefault();
        event.stopPropagation(); // the player has other plans for these keys
      }
    });
  }

  // ---- what there is ------------------------------------------------------------------------------

  get data() {
    return this.player.sequence;
  }

  get shown() {
    return Boolean(this.data.blocks);
  }

  get picked() {
    return this.spans.find(({ block }) => block.id === this.player.options.block) ?? null;
  }

  #receive() {
    this.element.hidden = !this.shown;
    this.width = this.view.clientWidth;
    if (!this.shown) {
      this.editor.close();
      this.plan.refresh(false);
      return;
    }
    const held = this.blocks.element.contains(this.blocks.element.getRootNode().activeElement);
    this.draft = this.floating = null;
    this.hues = huesOf(this.data.blocks.map(({ what }) => what));
    this.#lay(this.data.blocks);
    this.empty.hidden = this.data.blocks.length > 0;
    this.tools.refresh();
    this.editor.refresh();
    this.plan.refresh(true);
    if (held) this.blocks.focus(this.player.options.block);
  }

  #lay(blocks) {
    this.spans = layOut(blocks);
    if (this.fitted) this.fit();
    else this.#place(this.from, this.scale);
  }

  /** Shows other blocks than there are, while a hand moves them; `floating` is the one in that hand. */
  preview(blocks, floating = null) {
    this.draft = blocks;
    this.floating = floating;
    this.spans = layOut(blocks);
    this.render();
  }

  /** Back to what there is. */
  forget() {
    this.draft = this.floating = null;
    this.#lay(this.data.blocks);
  }

  /** Reports what was done to the blocks. */
  tell(what, details = {}) {
    this.player.dispatchEvent(new CustomEvent("arranged", { detail: { do: what, ...details } }));
  }

  pick(id, { focus = false } = {}) {
    this.player.set("block", id);
    const span = this.picked;
    if (span && focus) {
      this.reveal(span);
      this.blocks.focus(id);
    }
  }

  // ---- the window ---------------------------------------------------------------------------------

  get to() {
    return this.from + this.width / this.scale;
  }

  x(time) {
    return (time - this.from) * this.scale;
  }

  /** The time under a pointer. */
  timeAt(event) {
    return this.from + (event.clientX - this.view.getBoundingClientRect().left) / this.scale;
  }

  get length() {
    return lengthOf(this.spans);
  }

  get #fitScale() {
    return Math.max((this.width - 2 * PAD) / Math.max(this.length, LEAST), 0.1);
  }

  fit() {
    this.fitted = true;
    this.#place(-PAD / this.#fitScale, this.#fitScale);
  }

  /** Nearer (above 1) or farther, with what is at `x` pixels staying there. */
  zoom(factor, x = this.width / 2) {
    const time = this.from + x / this.scale;
    const scale = Math.min(Math.max(this.scale * factor, this.#fitScale), CLOSEST);
    this.fitted = scale === this.#fitScale;
    if (this.fitted) this.fit();
    else this.#place(time - x / scale, scale);
  }

  /** Begins the window at a time. */
  scroll(from) {
    this.#place(from, this.scale);
  }

  reveal({ start, end }) {
    const room = 30 / this.scale;
    if (start < this.from) this.scroll(start - room);
    else if (end > this.to) this.scroll(Math.min(start - room, end + room - this.width / this.scale));
  }

  #place(from, scale) {
    this.scale = scale;
    const pad = PAD / scale;
    const last = this.length + pad - this.width / scale;
    this.from = Math.max(-pad, Math.min(from, last));
    this.render();
  }

  #resized() {
    this.width = this.view.clientWidth;
    if (!this.shown || !this.width) return;
    if (this.fitted) this.fit();
    else this.#place(this.from, this.scale);
  }

  #wheel(event) {
    event.preventDefault();
    const aside = Math.abs(event.deltaX) > Math.abs(event.deltaY) || event.shiftKey;
    if (aside) this.scroll(this.from + (event.deltaX || event.deltaY) / this.scale);
    else this.zoom(Math.exp(-event.deltaY * (event.ctrlKey ? 0.01 : 0.0016)), event.clientX - this.view.getBoundingClientRect().left);
  }

  // ---- drawing ------------------------------------------------------------------------------------

  render() {
    if (!this.shown || !this.width) return;
    this.blocks.render();
    this.#drawRuler();
    this.overview.render();
    this.tick();
  }

  #drawRuler() {
    const { context, width, height } = prepare(this.marks);
    const style = getComputedStyle(this.element);
    const [tick, faint] = ["--tick", "--faint"].map((name) => style.getPropertyValue(name));
    const step = tickStep(this.scale);
    const minor = step / 5;
    context.font = `10.5px ${style.fontFamily}`;
    for (let i = Math.max(0, Math.floor(this.from / minor)); i * minor <= this.to; i++) {
      const x = Math.round(this.x(i * minor));
      const tall = i % 5 === 0;
      context.fillStyle = tick;
      context.fillRect(x, height - (tall ? 8 : 4), 1, tall ? 8 : 4);
      context.fillStyle = faint;
      if (tall && x < width - 26) context.fillText(clockText(i * minor, { tenths: step < 1 }), x + 4, 11);
    }
  }

  refresh() {
    if (!this.shown) return;
    this.render();
    this.tools.refresh();
    this.editor.refresh();
    this.plan.refresh(true);
  }

  tick() {
    if (!this.shown) return;
    const { clock } = this.player;
    const now = Math.min(clock.at, clock.frames) / clock.fps;
    if (clock.playing && !this.fitted && (now > this.to || now < this.from)) this.scroll(now - 20 / this.scale);
    this.playhead.style.transform = `translateX(${this.x(now)}px)`;
    this.overview.tick(now);
    this.plan.tick();
    const said = round(now);
    if (this.said === said) return;
    this.said = said;
    this.ruler.setAttribute("aria-valuemax", round(this.length));
    this.ruler.setAttribute("aria-valuenow", said);
    this.ruler.setAttribute("aria-valuetext", `${said} seconds${this.spans.length ? `, ${spanAt(this.spans, now).block.what}` : ""}`);
  }

  // ---- scrubbing ----------------------------------------------------------------------------------

  get now() {
    return this.player.clock.at / this.player.clock.fps;
  }

  #scrub(event) {
    if (event.button !== 0) return;
    event.preventDefault();
    const { player } = this;
    const resume = player.options.playing;
    const seek = (at) => player.seek(Math.round(this.timeAt(at) * player.clock.fps), { settled: false });
    this.ruler.focus({ preventScroll: true });
    this.ruler.setPointerCapture(event.pointerId);
    player.set("playing", false);
    seek(event);
    follow(this.ruler, seek, () => {
      player.seek(player.frame);
      if (resume) player.set("playing", true);
    });
  }

  dispose() {
    this.observer.disconnect();
    this.gestures.dispose();
  }
}
