// The strip under the transport: ruler with playhead (the scrub bar), label blocks, feet on the ground.
import { readable } from "../clock.js";
import { inContact } from "../payload.js";
import { labelHues } from "../hues.js";
import { h } from "./dom.js";

const LANES = [["action", ["action", "transition"]], ["text", ["text"]], ["style", ["style"]]];
const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600];
const TICK_ROOM = 64; // pixels between numbered ticks
const FEET = [["L", [0, 1]], ["R", [2, 3]]];

export class Timeline {
  constructor(player) {
    this.player = player;
    this.marks = h("canvas", { class: "marks", "aria-hidden": "true" });
    this.band = h("div", { class: "band", hidden: true });
    this.filled = h("div", { class: "filled" });
    this.ruler = h("div", { class: "ruler", role: "slider", tabindex: 0, "aria-label": "Scrub", "aria-valuemin": 0 }, this.band, this.filled, this.marks);
    this.lanes = h("div", { class: "lanes" });
    this.playhead = h("div", { class: "playhead", "aria-hidden": "true" });
    this.element = h("div", { class: "timeline", role: "group", "aria-label": "Timeline" }, this.ruler, this.lanes, this.playhead);
    this.#scrubbing();
    player.addEventListener("pins", () => this.#draw());
    this.observer = new ResizeObserver(() => this.#draw());
    this.observer.observe(this.ruler);
  }

  // ---- building -----------------------------------------------------------------------------------

  /** Lanes of the picked take. */
  rebuild() {
    const { actors, options } = this.player;
    this.take = actors[options.selected]?.take ?? actors[0]?.take ?? null;
    this.lanes.replaceChildren(...(this.take ? [...this.#labelLanes(), this.#feetLane()].filter(Boolean) : []));
    this.ruler.setAttribute("aria-valuemax", this.player.clock.frames - 1);
    this.#draw();
    this.refresh();
    this.tick();
  }

  #labelLanes() {
    const hues = labelHues(this.take.labels);
    return LANES.map(([name, kinds], i) => {
      const segments = this.take.labels.filter(({ kind }) => kinds.includes(kind));
      if (!segments.length) return null;
      const blocks = segments.map((segment) => this.#block(segment, hues.get(segment.value)));
      return lane(name, i === 0 ? "blocks" : "blocks thin", `Labels: ${name}`, ...blocks);
    });
  }

  #block({ start, end, kind, value }, hue) {
    const { player } = this;
    const { clock } = player;
    const seconds = `${(start / this.take.fps).toFixed(1)}–${(end / this.take.fps).toFixed(1)} s`;
    const goTo = () => player.seek(Math.round((start / this.take.fps) * clock.fps));
    const loop = () => {
      player.set("selection", [start, end].map((frame) => Math.round((frame / this.take.fps) * clock.fps)));
      player.set("loop", "selection");
    };
    return h("button", {
      type: "button", class: `block ${kind}`, onclick: goTo, ondblclick: loop,
      title: `${value}, ${seconds}. Click: go there. Double-click: loop it.`,
      "aria-label": kind === "transition" ? `${value}, ${seconds}` : undefined, // others say it in their text
      style: `left:${this.#percent(start)}%;width:${this.#percent(end - start)}%;--hue:${hue ?? "transparent"}`,
    }, kind === "transition" ? null : h("b", {}, value), kind === "transition" ? null : h("small", {}, seconds));
  }

  #feetLane() {
    if (!this.take.skeleton.feet.length) return null;
    this.feet = h("canvas", { class: "feet", role: "img", "aria-label": this.#feetInWords(), title: "Feet on the ground: left above, right below" });
    return lane("feet", "feet-lane", "Feet on the ground", this.feet);
  }

  #feetInWords() {
    const share = FEET.map(([, joints]) => {
      let on = 0;
      for (let f = 0; f < this.take.frames; f++) on += joints.some((joint) => inContact(this.take, f, joint)) ? 1 : 0;
      return Math.round((100 * on) / this.take.frames);
    });
    return `Left foot on the ground ${share[0]} % of the time, right foot ${share[1]} %`;
  }

  // Frames of the picked take -> percent of the strip, which spans the longest take.
  #percent(frames) {
    return (100 * frames) / this.take.fps / this.player.clock.duration;
  }

  // ---- drawing ------------------------------------------------------------------------------------

  #draw() {
    if (!this.take) return;
    this.#drawRuler();
    if (this.feet?.isConnected) this.#drawFeet();
  }

  #drawRuler() {
    const { context, width, height } = prepare(this.marks);
    if (!width) return;
    const style = getComputedStyle(this.element);
    const { duration, fps } = this.player.clock;
    const step = STEPS.find((seconds) => (seconds / duration) * width >= TICK_ROOM) ?? STEPS.at(-1);
    const minor = step / 5;
    const perFrame = width / (duration * fps);
    context.fillStyle = style.getPropertyValue("--tick");
    if (perFrame >= 5) for (let f = 0; f <= duration * fps; f++) context.fillRect(Math.round(f * perFrame), height - 3, 1, 3);
    for (let i = 0; i * minor <= duration + 1e-6; i++) {
      const x = Math.round(((i * minor) / duration) * width);
      const tall = i % 5 === 0 ? 8 : 4;
      context.fillRect(Math.min(x, width - 1), height - tall, 1, tall);
    }
    context.font = `10.5px ${style.fontFamily}`;
    context.fillStyle = style.getPropertyValue("--faint");
    for (let i = 0; i * step < duration - step * 0.2; i++) {
      const text = step < 1 ? (i * step).toFixed(1) : String(i * step);
      context.fillText(i === 0 ? "0 s" : text, ((i * step) / duration) * width + 4, 11);
    }
    context.fillStyle = style.getPropertyValue("--pin");
    context.strokeStyle = style.getPropertyValue("--panel");
    drawPins(context, this.player.pins.data, (seconds) => (seconds / duration) * width, height);
  }

  #drawFeet() {
    const { context, width, height } = prepare(this.feet);
    if (!width) return;
    const style = getComputedStyle(this.element);
    const tall = 5;
    const x = (frame) => (this.#percent(frame) / 100) * width;
    FEET.forEach(([, joints], side) => {
      const y = side === 0 ? height / 2 - tall - 2 : height / 2 + 2;
      context.fillStyle = style.getPropertyValue(side === 0 ? "--left-foot" : "--right-foot");
      for (const [start, end] of spans(this.take, joints)) {
        context.beginPath();
        context.roundRect(x(start) + 0.5, y, Math.max(x(end) - x(start) - 1, 1.5), tall, 2.5);
        context.fill();
      }
    });
  }

  refresh() {
    const { options, clock, themeName } = this.player;
    if (themeName !== this.painted) {
      this.painted = themeName;
      this.#draw();
    }
    const [start, end] = clock.selection ?? [];
    this.band.hidden = end === undefined;
    this.band.classList.toggle("active", options.loop === "selection");
    if (end !== undefined) {
      this.band.style.left = `${(100 * start) / clock.frames}%`;
      this.band.style.width = `${(100 * (end - start)) / clock.frames}%`;
    }
  }

  tick() {
    const { clock } = this.player;
    const share = Math.min(clock.at, clock.frames) / clock.frames;
    this.playhead.style.setProperty("--at", share);
    this.filled.style.width = `${100 * share}%`;
    if (this.frameSaid === clock.frame) return;
    this.frameSaid = clock.frame;
    this.ruler.setAttribute("aria-valuenow", clock.frame);
    this.ruler.setAttribute("aria-valuetext", `frame ${clock.frame}, ${readable(clock.frame / clock.fps)}`);
  }

  // ---- scrubbing ----------------------------------------------------------------------------------

  #scrubbing() {
    const frameAt = (event) => {
      const box = this.ruler.getBoundingClientRect();
      return Math.floor(((event.clientX - box.left) / box.width) * this.player.clock.frames);
    };
    for (const handle of [this.ruler, this.playhead]) {
      handle.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        event.preventDefault();
        this.ruler.focus({ preventScroll: true });
        handle.setPointerCapture(event.pointerId);
        if (event.shiftKey) this.#dragSelection(handle, frameAt, frameAt(event));
        else this.#dragPlayhead(handle, frameAt, event);
      });
    }
  }

  #dragPlayhead(handle, frameAt, first) {
    const { player } = this;
    const resume = player.options.playing;
    player.set("playing", false);
    player.seek(frameAt(first), { settled: false });
    follow(handle, (event) => player.seek(frameAt(event), { settled: false }), () => {
      player.seek(player.frame);
      if (resume) player.set("playing", true);
    });
  }

  #dragSelection(handle, frameAt, from) {
    const { player } = this;
    follow(handle, (event) => {
      const to = frameAt(event);
      player.set("selection", [Math.max(0, Math.min(from, to)), Math.min(Math.max(from, to) + 1, player.clock.frames)]);
    }, () => {
      if (player.clock.selection) player.set("loop", "selection");
    });
  }

  dispose() {
    this.observer.disconnect();
  }
}

function lane(name, className, label, ...children) {
  return h("div", { class: "lane" }, h("span", { class: "lane-name", "aria-hidden": "true" }, name), h("div", { class: className, role: "group", "aria-label": label }, ...children));
}

// Bars over frames that are kept, a diamond for a pose, a dot for a joint.
function drawPins(context, { poses, stretches, joints, fps }, x, height) {
  for (const [start, end] of stretches) context.fillRect(x(start / fps), height - 5, x((end - start) / fps), 4);
  const inside = ({ frame }) => stretches.some(([start, end]) => frame >= start && frame < end);
  for (const pose of poses.filter((pose) => !inside(pose))) {
    const [at, y] = [x((pose.frame + 0.5) / fps), height - 7];
    context.beginPath();
    [[0, -6], [5, 0], [0, 6], [-5, 0]].forEach(([dx, dy]) => context.lineTo(at + dx, y + dy));
    context.fill();
  }
  for (const { frame } of joints) {
    context.beginPath();
    context.arc(x((frame + 0.5) / fps), height - 7, 3, 0, Math.PI * 2);
    context.fill();
    context.stroke(); // seen on a diamond too
  }
}

/** Calls `move` until the pointer is let go, then `done`. */
export function follow(handle, move, done) {
  const stop = () => {
    handle.removeEventListener("pointermove", move);
    done();
  };
  handle.addEventListener("pointermove", move);
  handle.addEventListener("lostpointercapture", stop, { once: true });
}

/** Runs of frames [start, end) in which any of the joints touches the ground. */
export function spans(take, joints) {
  const found = [];
  let start = -1;
  for (let frame = 0; frame <= take.frames; frame++) {
    const on = frame < take.frames && joints.some((joint) => inContact(take, frame, joint));
    if (on && start < 0) start = frame;
    if (!on && start >= 0) {
      found.push([start, frame]);
      start = -1;
    }
  }
  return found;
}

/** Sizes a canvas to its box in device pixels and clears it. */
export function prepare(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ratio = Math.min(globalThis.devicePixelRatio || 1, 3);
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  return { context, width, height };
}
