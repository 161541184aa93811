// The blocks and the transitions between them as elements: only those in the window, and of these only those wide enough.
import { h, icon } from "../ui/dom.js";
import { prepare } from "../ui/timeline.js";
import { LONGEST_TRANSITION, within } from "./layout.js";

const THINNEST = 5; // pixels; narrower blocks are painted
const NARROW = 34; // pixels in which there is no room for a second line
const LEAST_GAP = 9; // pixels in which a transition can be taken hold of

export class Blocks {
  constructor(sequencer) {
    this.sequencer = sequencer;
    this.there = new Map(); // id -> {block, gap}
    this.slivers = h("canvas", { class: "slivers", "aria-hidden": "true" });
    this.element = h("div", { class: "track", role: "group", "aria-label": "Blocks" }, this.slivers);
  }

  render() {
    const { sequencer } = this;
    const { spans, floating, scale } = sequencer;
    const [first, last] = within(spans, sequencer.from, sequencer.to);
    const wanted = new Set();
    const thin = [];
    const focused = this.element.getRootNode().activeElement?.dataset?.id;
    for (let i = first; i < last; i++) {
      const span = spans[i];
      if (span.block.seconds * scale < THINNEST && span.block.id !== focused) thin.push(span);
      else wanted.add(span);
    }
    const kept = spans.find(({ block }) => block.id === floating?.id) ?? spans.find(({ block }) => block.id === focused);
    if (kept) wanted.add(kept); // out of sight, but in a hand or with the keyboard
    const ids = new Set([...wanted].map(({ block }) => block.id));
    for (const [id, { block, gap }] of this.there) {
      if (ids.has(id)) continue;
      block.remove();
      gap.remove();
      this.there.delete(id);
    }
    for (const span of wanted) this.#show(span, span.block.id === floating?.id ? floating.left : null);
    this.#paint(thin);
  }

  #show(span, left) {
    const { sequencer } = this;
    const entry = this.there.get(span.block.id) ?? this.#make(span.block.id);
    const { block, gap } = entry;
    const picked = sequencer.player.options.block === span.block.id;
    const width = span.block.seconds * sequencer.scale;
    block.style.left = `${left ?? sequencer.x(span.start)}px`;
    block.style.width = `${Math.max(width - 1, 2)}px`;
    this.#placeGap(gap, span);
    // all else stays while it is only zoomed and scrolled
    const { spans, hues } = sequencer;
    const said = [span.block, span.index, spans.length, picked, sequencer.picked === null, left === null, width < NARROW, hues.get(span.block.what)];
    if (said.every((value, i) => value === entry.said?.[i])) return;
    entry.said = said;
    this.#describe(entry, span, picked, left !== null);
    block.classList.toggle("bare", width < NARROW);
  }

  #describe({ block, gap }, span, picked, held) {
    const { sequencer } = this;
    const { what, seconds, locked, made, kind, style, seed } = span.block;
    block.className = `block seq ${kind}${made ? "" : " stale"}${locked ? " locked" : ""}${picked ? " picked" : ""}${held ? " held" : ""}`;
    block.style.setProperty("--hue", sequencer.hues.get(what));
    block.setAttribute("aria-label", inWords(span, sequencer.spans.length));
    block.setAttribute("aria-current", String(picked));
    block.tabIndex = picked || (!sequencer.picked && span.index === 0) ? 0 : -1;
    block.title = `${what}\n${seconds} s${style ? `, ${style}` : ""}${kind === "clip" ? "" : `, seed ${seed}`}${made ? "" : ", not made yet"}`;
    block.querySelector("b").textContent = kind === "prompt" ? `“${what}”` : what;
    block.querySelector("small").textContent = [`${seconds} s`, style, kind === "clip" ? "clip" : `seed ${seed}`].filter(Boolean).join(" · ");
    gap.hidden = span.index === 0;
    gap.tabIndex = picked ? 0 : -1;
    gap.title = `Transition, ${span.gap} s: drag it longer or shorter`;
    gap.setAttribute("aria-label", `Transition to ${span.block.what}, seconds`);
    gap.setAttribute("aria-valuenow", span.gap);
  }

  #placeGap(gap, span) {
    const { sequencer } = this;
    const width = span.gap * sequencer.scale;
    const room = Math.max(width - 1, LEAST_GAP);
    gap.style.left = `${sequencer.x(span.start) - width / 2 - room / 2}px`;
    gap.style.width = `${room}px`;
    gap.classList.toggle("slim", width < LEAST_GAP);
  }

  #make(id) {
    const block = h("button", { type: "button", "data-id": id, "data-part": "block" },
      h("b"), h("small"), h("span", { class: "lock", "aria-hidden": "true" }, icon("lock")), h("i", { class: "edge", "data-part": "edge", "aria-hidden": "true" }));
    const gap = h("div", { class: "gap", "data-id": id, "data-part": "gap", role: "slider", "aria-valuemin": 0, "aria-valuemax": LONGEST_TRANSITION });
    this.element.append(gap, block);
    const entry = { block, gap, said: null };
    this.there.set(id, entry);
    return entry;
  }

  #paint(thin) {
    const { context, height } = prepare(this.slivers);
    for (const { block, start } of thin) {
      context.fillStyle = this.sequencer.hues.get(block.what);
      context.fillRect(this.sequencer.x(start), 4, Math.max(block.seconds * this.sequencer.scale - 0.5, 0.5), height - 8);
    }
  }

  /** The element of a block, if it is in the window. */
  of(id) {
    return this.there.get(id)?.block ?? null;
  }

  focus(id) {
    this.of(id)?.focus({ preventScroll: true });
  }
}

function inWords({ block, index }, count) {
  const { what, seconds, style, locked, made } = block;
  const more = [style, locked && "locked", !made && "not made yet"].filter(Boolean).join(", ");
  return `Block ${index + 1} of ${count}: ${what}, ${seconds} seconds${more ? `, ${more}` : ""}`;
}
