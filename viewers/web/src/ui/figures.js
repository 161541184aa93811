// Small moving figures: what each motion token looks like, decoded alone.
import { h } from "./dom.js";
import { prepare } from "./timeline.js";

const PACE = 160; // milliseconds a frame; slower than life, since four frames last a fifth of a second

export class Figures {
  constructor(player) {
    this.player = player;
    this.frame = 0;
    this.set({ parents: [], head: 0, points: {} });
  }

  /** `parents` of the joints, which one is the `head`; `points` {code: frames of [x, y, x, y, ...], 0 to 100 upwards}. */
  set(figures) {
    this.figures = figures;
  }

  /** Draw those in this gallery, moving unless the person asked for calm; null: none. */
  show(gallery) {
    clearInterval(this.timer);
    this.gallery = gallery;
    if (!gallery) return;
    this.#draw();
    if (this.player.cameraman.calm) return;
    this.timer = setInterval(() => {
      if (!gallery.isConnected || !gallery.offsetParent) return;
      this.frame += 1;
      this.#draw();
    }, PACE);
  }

  #draw() {
    const box = this.gallery.getBoundingClientRect();
    for (const button of this.gallery.querySelectorAll(".figure")) {
      const own = button.getBoundingClientRect();
      if (own.bottom > box.top && own.top < box.bottom) this.#pose(button.querySelector("canvas"), this.figures.points[button.dataset.code]);
    }
  }

  #pose(canvas, frames) {
    const { context, width, height } = prepare(canvas);
    const there = frames.length - 1;
    const turn = this.frame % (2 * there || 1); // there and back
    const points = frames[turn > there ? 2 * there - turn : turn];
    const at = (joint) => [width / 2 + ((points[2 * joint] - 50) / 100) * height, height * (1 - points[2 * joint + 1] / 100)];
    context.strokeStyle = getComputedStyle(canvas).color;
    context.lineWidth = 1.6;
    context.lineCap = "round";
    context.beginPath();
    this.figures.parents.forEach((parent, joint) => {
      if (parent < 0) return;
      context.moveTo(...at(parent));
      context.lineTo(...at(joint));
    });
    const [x, y] = at(this.figures.head);
    context.moveTo(x + 0.06 * height, y);
    context.arc(x, y, 0.06 * height, 0, 2 * Math.PI);
    context.stroke();
  }
}

/** A figure to press, with where its token stands. */
export function figureButton(code, codes, seconds, onclick) {
  const places = codes.flatMap((other, place) => (other === code ? [place] : []));
  const where = places.length ? `${places.length} × from ${(places[0] * seconds).toFixed(1)} s` : "not in this motion";
  return h("button", { type: "button", class: "figure", "data-code": code, disabled: !places.length, title: `Token ${code}, ${where}`, "aria-label": `Token ${code}, ${where}`, onclick },
    h("canvas", { "aria-hidden": "true" }), h("small", {}, String(code)));
}
