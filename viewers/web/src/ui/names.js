// Names under the figures: buttons, so that a figure can be picked without a pointer.
import { Vector3 } from "three";
import { button, h, press } from "./dom.js";

const LINE = 25; // pixels from one name to the next below it

export class Names {
  constructor(player) {
    this.player = player;
    this.element = h("div", { class: "names", role: "group", "aria-label": "Figures" });
    this.spot = new Vector3();
  }

  rebuild() {
    const { player } = this;
    this.buttons = player.actors.map(({ take }, i) => {
      const text = take.name || `Figure ${i + 1}`;
      const tag = button({ label: text, text, className: "name", onclick: () => player.set("selected", i) });
      tag.style.setProperty("--dye", take.colour);
      tag.hidden = !take.name;
      tag.addEventListener("pointerenter", () => player.hover(i));
      tag.addEventListener("pointerleave", () => player.hover(-1));
      return tag;
    });
    this.widths = [];
    this.element.replaceChildren(...this.buttons);
    this.refresh();
  }

  refresh() {
    const { options } = this.player;
    this.element.hidden = !options.names;
    this.buttons?.forEach((tag, i) => press(tag, i === options.selected));
  }

  tick() {
    const { player, element } = this;
    if (element.hidden || !this.buttons) return;
    const { clientWidth: width, clientHeight: height } = player.stage.canvas;
    const taken = [];
    this.buttons.forEach((tag, i) => {
      player.actors[i].foot(this.spot).project(player.stage.camera);
      const seen = this.spot.z < 1 && Math.abs(this.spot.x) < 1.1 && Math.abs(this.spot.y) < 1.1;
      tag.style.visibility = seen ? "visible" : "hidden";
      if (!seen) return;
      const x = ((this.spot.x + 1) / 2) * width;
      this.widths[i] ??= tag.offsetWidth;
      const y = clear(taken, x, ((1 - this.spot.y) / 2) * height + 16, this.widths[i]);
      tag.style.transform = `translate(-50%, 0) translate(${x}px, ${y}px)`;
    });
  }
}

// Moves a name down until it hides none of those placed before it.
function clear(taken, x, y, width) {
  while (taken.some((other) => Math.abs(other.x - x) < (width + other.width) / 2 && Math.abs(other.y - y) < LINE)) y += LINE;
  taken.push({ x, y, width });
  return y;
}
