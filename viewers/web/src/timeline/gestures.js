// The pointer on the blocks: move, trim, transitions, what is dropped from elsewhere, the menu.
import { follow } from "../ui/timeline.js";
import { LONGEST_TRANSITION, SHORTEST, layOut, placeAt, round, snapped, tickStep } from "./layout.js";

const SLOP = 4; // pixels before a press becomes a move
const NEAR = 7; // pixels in which edges catch
const CARRIED = "application/x-motionloom-block";

export class Gestures {
  constructor(sequencer) {
    this.sequencer = sequencer;
    this.cancel = null;
    const track = sequencer.blocks.element;
    track.addEventListener("pointerdown", (event) => this.#down(event));
    track.addEventListener("dblclick", (event) => this.#edit(event));
    track.addEventListener("contextmenu", (event) => this.#menu(event));
    sequencer.view.addEventListener("dragover", (event) => this.#over(event));
    sequencer.view.addEventListener("dragleave", (event) => this.#leave(event));
    sequencer.view.addEventListener("drop", (event) => this.#drop(event));
    this.onEscape = (event) => {
      if (event.key !== "Escape" || !this.cancel) return;
      event.stopPropagation();
      this.cancel();
    };
    document.addEventListener("keydown", this.onEscape, true);
  }

  dispose() {
    document.removeEventListener("keydown", this.onEscape, true);
  }

  #span(event) {
    const id = event.target.closest("[data-id]")?.dataset.id;
    return this.sequencer.spans.find(({ block }) => block.id === id) ?? null;
  }

  #down(event) {
    const { sequencer } = this;
    const part = event.target.closest("[data-part]")?.dataset.part;
    const span = this.#span(event);
    if (event.button !== 0 || !span) return;
    sequencer.menu.close();
    if (part === "block" || part === "edge") {
      sequencer.pick(span.block.id);
      sequencer.blocks.focus(span.block.id);
    }
    event.preventDefault();
    if (part === "gap") this.#drag(event, (at) => this.#transition(span, event, at));
    else if (part === "edge") this.#drag(event, (at) => this.#trim(span, at));
    else this.#drag(event, (at) => this.#move(span, event, at));
  }

  // `step` shows what a place of the pointer means and returns what to tell of it.
  #drag(first, step) {
    const { sequencer } = this;
    const track = sequencer.blocks.element;
    let told = null;
    let moved = false;
    track.setPointerCapture(first.pointerId);
    const move = (at) => {
      moved ||= Math.abs(at.clientX - first.clientX) > SLOP;
      if (!moved || !this.cancel) return;
      sequencer.element.classList.add("dragging");
      told = step(at);
    };
    this.cancel = () => {
      told = null;
      this.cancel = null;
      sequencer.forget();
      track.releasePointerCapture(first.pointerId);
    };
    follow(track, move, () => {
      this.cancel = null;
      sequencer.element.classList.remove("dragging");
      sequencer.floating = null;
      if (told) sequencer.tell(...told);
      else if (sequencer.draft) sequencer.forget();
      else return;
      sequencer.render();
    });
  }

  #with(id, values) {
    return this.sequencer.data.blocks.map((block) => (block.id === id ? { ...block, ...values } : block));
  }

  // Seconds at which edges catch: ticks of the ruler and the playhead.
  #caught(time, event) {
    const { sequencer } = this;
    if (event.altKey) return time;
    const step = tickStep(sequencer.scale, 12);
    return snapped(time, [Math.round(time / step) * step, sequencer.now], NEAR / sequencer.scale);
  }

  #trim(span, at) {
    const { sequencer } = this;
    const most = span.block.kind === "clip" ? span.block.seconds : Infinity;
    const seconds = round(Math.min(Math.max(this.#caught(sequencer.timeAt(at), at) - span.start, SHORTEST), most));
    sequencer.preview(this.#with(span.block.id, { seconds, made: span.block.made && seconds === span.block.seconds }));
    return ["change", { id: span.block.id, values: { seconds } }];
  }

  #transition(span, first, at) {
    const { sequencer } = this;
    const wanted = span.gap + (at.clientX - first.clientX) / sequencer.scale;
    const start = this.#caught(span.start - span.gap + wanted, at);
    const transition = round(Math.min(Math.max(start - span.start + span.gap, 0), LONGEST_TRANSITION));
    sequencer.preview(this.#with(span.block.id, { transition }));
    return ["change", { id: span.block.id, values: { transition } }];
  }

  #move(span, first, at) {
    const { sequencer } = this;
    const { id, seconds } = span.block;
    const grabbed = first.clientX - sequencer.view.getBoundingClientRect().left - sequencer.x(span.start);
    const left = at.clientX - sequencer.view.getBoundingClientRect().left - grabbed;
    const others = sequencer.data.blocks.filter((block) => block.id !== id);
    const to = placeAt(layOut(others), sequencer.from + left / sequencer.scale + seconds / 2);
    sequencer.preview([...others.slice(0, to), span.block, ...others.slice(to)], { id, left });
    return to === span.index ? null : ["move", { id, to }];
  }

  #edit(event) {
    const span = this.#span(event);
    if (span && event.target.closest("[data-part]")?.dataset.part !== "gap") this.sequencer.editor.open(span.block.id);
  }

  #menu(event) {
    const span = this.#span(event);
    if (!span) return;
    event.preventDefault();
    this.sequencer.pick(span.block.id);
    this.sequencer.menu.open(span, event);
  }

  // ---- from elsewhere -----------------------------------------------------------------------------

  #over(event) {
    if (![...event.dataTransfer.types].includes(CARRIED)) return;
    event.preventDefault();
    event.stopPropagation();
    event.dataTransfer.dropEffect = "copy";
    const { sequencer } = this;
    const at = placeAt(sequencer.spans, sequencer.timeAt(event));
    const span = sequencer.spans[at];
    sequencer.mark.hidden = false;
    sequencer.mark.style.left = `${sequencer.x(span ? span.start - span.gap / 2 : sequencer.length)}px`;
  }

  #leave(event) {
    if (!this.sequencer.view.contains(event.relatedTarget)) this.sequencer.mark.hidden = true;
  }

  #drop(event) {
    const { sequencer } = this;
    const carried = event.dataTransfer.getData(CARRIED);
    sequencer.mark.hidden = true;
    if (!carried) return;
    event.preventDefault();
    event.stopPropagation();
    sequencer.tell("add", { ...JSON.parse(carried), at: placeAt(sequencer.spans, sequencer.timeAt(event)) });
  }
}
