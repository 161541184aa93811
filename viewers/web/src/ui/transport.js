// Play, step, readout, loop, speed and the toggles beside them.
import { readable } from "../clock.js";
import { button, choice, h, icon, press } from "./dom.js";

const SPEEDS = [0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4];
const LOOPS = [["off", "Loop off"], ["all", "Loop all"], ["selection", "Loop selection"]];

export class Transport {
  constructor(player, { screenshot, help, say }) {
    this.player = player;
    this.say = say;
    this.element = h("div", { class: "transport", role: "toolbar", "aria-label": "Transport" },
      this.#buttons(), this.#readout(), this.#pace(), h("span", { class: "space" }), this.#toggles(), this.#extras(screenshot, help));
    this.refresh();
  }

  #buttons() {
    const { player } = this;
    this.play = button({ label: "Play", symbol: "play", key: "Space", className: "icon play", onclick: () => player.toggle("playing") });
    return h("span", { class: "group" },
      button({ label: "First frame", symbol: "first", key: "Home", className: "icon", onclick: () => player.step(-Infinity) }),
      button({ label: "Previous frame", symbol: "back", key: "ArrowLeft", className: "icon", onclick: () => player.step(-1) }),
      this.play,
      button({ label: "Next frame", symbol: "forward", key: "ArrowRight", className: "icon", onclick: () => player.step(1) }),
      button({ label: "Last frame", symbol: "last", key: "End", className: "icon", onclick: () => player.step(Infinity) }));
  }

  #readout() {
    const { player } = this;
    this.now = h("span", { class: "now" });
    this.total = h("span", { class: "total" });
    this.frame = h("input", {
      type: "number", min: 0, class: "frame", "aria-label": "Go to frame", title: "Go to frame",
      onchange: () => this.#goTo(), onfocus: () => this.frame.select(),
      onkeydown: (event) => { if (event.key === "Enter") this.frame.blur(); },
    });
    player.addEventListener("takes", () => this.frame.setAttribute("max", player.clock.frames - 1));
    return h("span", { class: "readout" }, this.now, this.total, h("span", { class: "dim" }, " · frame "), this.frame);
  }

  #goTo() {
    const { player } = this;
    player.set("playing", false);
    player.seek(Math.round(Number(this.frame.value)));
    this.say(`Frame ${player.frame}, ${player.clock.seconds.toFixed(2)} seconds`);
  }

  #pace() {
    const { player } = this;
    this.loop = choice({ label: "Loop", entries: LOOPS, onchange: (value) => player.set("loop", value) });
    this.speed = choice({
      label: "Speed", entries: SPEEDS.map((speed) => [speed, `${speed}×`]), onchange: (value) => player.set("speed", Number(value)),
    });
    return h("span", { class: "group pace" }, this.loop, this.speed);
  }

  #toggles() {
    const { player } = this;
    const make = (name, label) => [name, button({ label, text: label, onclick: () => player.toggle(name) })];
    this.toggles = [make("in_place", "In place"), make("mirror", "Mirror"), make("floor", "Floor")];
    this.edits = h("span", { class: "group", role: "group" });
    return h("span", { class: "group toggles" }, this.edits,
      h("span", { class: "group", role: "group", "aria-label": "View changes" }, ...this.toggles.map(([, element]) => element)));
  }

  // Changes that somebody else carries out, for the picked figure: offered by `editable`, pressed in `edits`.
  #showEdits({ editable, edits, selected }) {
    const { player } = this;
    const offered = editable.split(",").filter(Boolean).map((entry) => entry.split("="));
    const pressed = edits.split(",").filter(Boolean);
    const toggle = (name) => () => {
      const now = player.options.edits.split(",").filter(Boolean);
      player.set("edits", (now.includes(name) ? now.filter((other) => other !== name) : [...now, name]).join(","));
    };
    if (this.offered !== editable) {
      this.offered = editable;
      this.edits.replaceChildren(...offered.map(([name, label]) => button({ label, text: label, onclick: toggle(name) })));
    }
    const name = player.actors[selected]?.take.name;
    this.edits.setAttribute("aria-label", name ? `Changes to ${name}` : "Changes");
    offered.forEach(([key], i) => press(this.edits.children[i], pressed.includes(key)));
    for (const [key, element] of this.toggles) element.hidden = offered.length > 0 && key !== "floor";
  }

  #extras(screenshot, help) {
    const { player } = this;
    return h("span", { class: "group extras" },
      button({ label: "Light or dark", symbol: "theme", className: "icon", onclick: () => player.set("theme", player.themeName === "dark" ? "light" : "dark") }),
      button({ label: "Download picture", symbol: "camera", key: "P", className: "icon", onclick: screenshot }),
      button({ label: "Help", symbol: "help", key: "?", className: "icon", onclick: help }));
  }

  refresh() {
    const { options } = this.player;
    const label = options.playing ? "Pause" : "Play";
    if (this.play.getAttribute("aria-label") !== label) {
      this.play.setAttribute("aria-label", label);
      this.play.title = `${label} (Space)`;
      this.play.replaceChildren(icon(options.playing ? "pause" : "play"));
    }
    this.loop.value = options.loop;
    this.#showSpeed(options.speed);
    for (const [name, element] of this.toggles) press(element, options[name]);
    this.#showEdits(options);
  }

  // A speed set from Python need not be one of the list's; it gets an entry while it lasts.
  #showSpeed(speed) {
    if (![...this.speed.options].some((option) => Number(option.value) === speed)) {
      this.speed.querySelector("[data-own]")?.remove();
      this.speed.append(h("option", { value: speed, "data-own": true }, `${Number(speed.toFixed(2))}×`));
    }
    this.speed.value = String(speed);
  }

  tick() {
    const { clock } = this.player;
    this.now.textContent = readable(clock.frame / clock.fps);
    this.total.textContent = ` / ${readable(clock.duration)}`;
    if (this.frame.getRootNode().activeElement !== this.frame) this.frame.value = clock.frame;
  }
}
