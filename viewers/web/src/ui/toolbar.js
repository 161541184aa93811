// The floating controls over the stage: what is shown (left), from where (right), what it is (bottom).
import { button, h, press } from "./dom.js";

const SHOW = [["body", "Body"], ["skeleton", "Skeleton"], ["both", "Both"]];
const SIDES = [["front", "F", "Front view", "1"], ["back", "B", "Back view", "2"], ["left", "L", "Left view", "3"], ["right", "R", "Right view", "4"]];
const GHOSTS_AT_FIRST = 8;

export class Toolbar {
  constructor(player) {
    this.player = player;
    this.lastGhosts = GHOSTS_AT_FIRST;
    this.element = h("div", { class: "over" }, this.#looks(), this.#views(), (this.caption = h("div", { class: "float caption" })));
    this.refresh();
  }

  #looks() {
    const { player } = this;
    this.shows = SHOW.map(([value, text]) => button({ label: text, text, key: "S", onclick: () => player.set("show", value) }));
    this.ghosts = button({ label: "Ghosts", text: "Ghosts", key: "G", onclick: () => this.toggleGhosts() });
    this.every = h("input", {
      type: "number", min: 1, max: 200, class: "every", "aria-label": "A ghost every so many frames", title: "A ghost every so many frames",
      onchange: () => player.set("ghosts", Math.max(1, Number(this.every.value) || GHOSTS_AT_FIRST)),
    });
    this.trail = button({ label: "Trail", text: "Trail", key: "T", onclick: () => player.toggle("trail") });
    this.contacts = button({ label: "Contacts", text: "Contacts", key: "C", onclick: () => player.toggle("contacts") });
    this.overlay = button({ label: "Overlay: all in one place", text: "Overlay", key: "V", onclick: () => this.toggleOverlay() });
    return h("div", { class: "float looks", role: "toolbar", "aria-label": "What is shown" },
      h("span", { class: "group", role: "group", "aria-label": "Figure" }, ...this.shows), h("i", { class: "bar" }),
      h("span", { class: "group" }, this.ghosts, this.every), h("i", { class: "bar" }), this.trail, h("i", { class: "bar" }), this.contacts, this.overlay);
  }

  #views() {
    const { player } = this;
    this.orbit = button({ label: "Frame everything", symbol: "frame", key: "0", className: "icon", onclick: () => player.resetView() });
    this.follow = button({ label: "Follow", text: "Follow", key: "F", onclick: () => player.toggleFollow() });
    this.sides = SIDES.map(([view, text, label, key]) => button({ label, text, key, className: "side", onclick: () => player.set("camera", view) }));
    return h("div", { class: "float views", role: "toolbar", "aria-label": "Camera" },
      this.orbit, this.follow, h("span", { class: "group", role: "group", "aria-label": "Fixed views" }, ...this.sides));
  }

  toggleGhosts() {
    const { ghosts } = this.player.options;
    if (ghosts) this.lastGhosts = ghosts;
    this.player.set("ghosts", ghosts ? 0 : this.lastGhosts);
  }

  toggleOverlay() {
    this.player.set("arrangement", this.player.options.arrangement === "overlay" ? "side" : "overlay");
  }

  cycleShow() {
    const names = SHOW.map(([value]) => value);
    this.player.set("show", names[(names.indexOf(this.player.options.show) + 1) % names.length]);
  }

  refresh() {
    const { options, cameraman } = this.player;
    SHOW.forEach(([value], i) => press(this.shows[i], options.show === value));
    press(this.ghosts, options.ghosts > 0);
    this.every.hidden = !options.ghosts;
    if (options.ghosts) this.every.value = options.ghosts;
    press(this.trail, options.trail);
    press(this.contacts, options.contacts);
    press(this.overlay, options.arrangement === "overlay");
    this.overlay.hidden = this.player.actors.length < 2;
    press(this.follow, cameraman.tracking);
    SIDES.forEach(([view], i) => press(this.sides[i], options.camera === view));
  }

  /** The line at the bottom: which take, what it does now. */
  tick() {
    const { actors, options, clock } = this.player;
    const take = actors[options.selected]?.take;
    const text = take ? captionOf(take, options.selected, actors.length, clock) : "";
    if (text === this.said) return;
    this.said = text;
    this.caption.textContent = text;
    this.caption.hidden = !text;
  }
}

function captionOf(take, index, count, clock) {
  const frame = Math.min(Math.round(clock.seconds * take.fps), take.frames - 1);
  const now = take.labels.filter(({ start, end }) => start <= frame && frame < end);
  const sentence = now.find(({ kind }) => kind === "text")?.value ?? take.prompt;
  const parts = [];
  if (count > 1) parts.push(take.name && take.name !== `Take ${index + 1}` ? `${take.name} (${index + 1} of ${count})` : `Take ${index + 1} of ${count}`);
  else if (take.name) parts.push(take.name);
  const action = now.find(({ kind }) => kind === "action" || kind === "transition")?.value;
  const style = now.find(({ kind }) => kind === "style")?.value;
  if (action) parts.push(style ? `${action}, ${style}` : action);
  else if (style) parts.push(style);
  if (sentence && sentence !== action) parts.push(`“${sentence}”`);
  return parts.join(" · ");
}
