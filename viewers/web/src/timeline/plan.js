// The way of the picked figure over the floor, seen from above, in the colours of what it does.
import { h } from "../ui/dom.js";
import { tintsOf } from "../hues.js";
import { prepare } from "../ui/timeline.js";
import { floorWay } from "../ways.js";

const EDGE = 12; // pixels around
const SMALLEST = 2; // metres across
const LINES = [1, 2, 5, 10, 20, 50, 100, 200, 500]; // metres between lines
const ROOM = 14; // pixels between lines at least

export class Plan {
  constructor(player) {
    this.player = player;
    this.wanted = true;
    this.canvas = h("canvas", { role: "img", "aria-label": "The way over the floor, from above" });
    this.note = h("span", {});
    this.dot = h("i", { "aria-hidden": "true" });
    this.element = h("div", { class: "float plan", hidden: true }, this.canvas, this.dot, this.note);
  }

  toggle() {
    this.wanted = !this.wanted;
    this.refresh(true);
  }

  refresh(there) {
    const { player } = this;
    const { selected, mirror, in_place: inPlace } = player.options;
    this.take = (player.actors[selected] ?? player.actors[0])?.take ?? null;
    this.element.hidden = !there || !this.wanted || !this.take;
    if (this.element.hidden) return;
    const drawn = [this.take, mirror, inPlace, player.themeName];
    if (drawn.some((value, i) => value !== this.drawn?.[i])) {
      this.drawn = drawn;
      this.way = floorWay(this.take, { mirror, inPlace });
      this.#draw();
    }
    this.tick();
  }

  #draw() {
    const { context, width, height } = prepare(this.canvas);
    if (!width) return;
    this.#frame(width, height);
    const { way, take } = this;
    const style = getComputedStyle(this.element);
    const step = LINES.find((metres) => metres * this.scale >= ROOM) ?? 1000;
    this.note.textContent = `${step} m`;
    context.strokeStyle = style.getPropertyValue("--line");
    context.lineWidth = 1;
    context.beginPath();
    for (let x = Math.ceil(this.left / step) * step; this.x(x) < width; x += step) context.rect(this.x(x), 0, 0, height);
    for (let z = Math.ceil(this.far / step) * step; this.y(z) < height; z += step) context.rect(0, this.y(z), width, 0);
    context.stroke();
    const tints = tintsOf(take);
    Object.assign(context, { lineWidth: 2.5, lineJoin: "round", lineCap: "round" });
    const points = way.length / 2;
    const starts = tints.length ? [0, ...tints.slice(1).map(({ start }) => start)] : [0];
    starts.forEach((start, n) => {
      context.strokeStyle = tints[n]?.hue ?? take.colour;
      context.beginPath();
      for (let i = start; i < Math.min((starts[n + 1] ?? points) + 1, points); i++) context.lineTo(this.x(way[2 * i]), this.y(way[2 * i + 1]));
      context.stroke();
    });
  }

  // All of the way in view, what is in front below: as it is seen from the front.
  #frame(width, height) {
    const bounds = [Infinity, -Infinity, Infinity, -Infinity];
    for (let i = 0; i < this.way.length; i += 2) {
      bounds[0] = Math.min(bounds[0], this.way[i]);
      bounds[1] = Math.max(bounds[1], this.way[i]);
      bounds[2] = Math.min(bounds[2], this.way[i + 1]);
      bounds[3] = Math.max(bounds[3], this.way[i + 1]);
    }
    const [x0, x1, z0, z1] = bounds;
    this.scale = Math.min((width - 2 * EDGE) / Math.max(x1 - x0, SMALLEST), (height - 2 * EDGE) / Math.max(z1 - z0, SMALLEST));
    this.left = (x0 + x1) / 2 - width / 2 / this.scale;
    this.far = (z0 + z1) / 2 - height / 2 / this.scale;
  }

  x(metres) {
    return (metres - this.left) * this.scale;
  }

  y(metres) {
    return (metres - this.far) * this.scale;
  }

  tick() {
    if (this.element.hidden || !this.take) return;
    const { clock } = this.player;
    const i = Math.min(Math.round((clock.at / clock.fps) * this.take.fps), this.way.length / 2 - 1);
    this.dot.style.transform = `translate(${this.x(this.way[2 * i])}px, ${this.y(this.way[2 * i + 1])}px)`;
  }
}
