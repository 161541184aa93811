// The player with its controls inside an element: canvas, floating tools, transport, timeline, keys.
import { MotionPlayer } from "./player.js";
import { resolveTheme } from "./theme.js";
import css from "./style.css";
import { Sequencer } from "./timeline/sequencer.js";
import sequencerCss from "./timeline/sequencer.css";
import { h } from "./ui/dom.js";
import { Help } from "./ui/help.js";
import { listenToKeys } from "./ui/keys.js";
import { Names } from "./ui/names.js";
import { Strips } from "./ui/strips.js";
import stripsCss from "./ui/strips.css";
import { Timeline } from "./ui/timeline.js";
import { ToolHint } from "./ui/hint.js";
import { Toolbar } from "./ui/toolbar.js";
import { Transport } from "./ui/transport.js";

const CLICK = 5; // pixels a pointer may move between down and up and still pick

export class Widget {
  constructor(el, theme) {
    this.host = h("div", { class: "motion-player", "data-lm-suppress-shortcuts": "true" });
    this.root = this.host.attachShadow({ mode: "open" }); // keeps the page's styles out and ours in
    this.canvas = h("canvas", { class: "view", tabindex: 0, role: "img", "aria-label": "3D stage" });
    this.status = h("div", { class: "status", role: "status", "aria-live": "polite" });
    this.view = h("div", { class: "stage" }, this.canvas);
    this.frame = h("div", { class: "player", role: "region", "aria-label": "Motion player" }, this.view, this.status);
    this.root.append(h("style", {}, css, sequencerCss, stripsCss), this.frame);
    el.append(this.host);
    this.undo = [() => this.host.remove()];
    this.paint(resolveTheme(theme));
  }

  /** Builds the stage and the controls. Throws WebGLMissing where there is no WebGL 2. */
  start() {
    this.player = new MotionPlayer(this.canvas);
    this.undo.unshift(() => this.player.dispose());
    this.host.player = this.player; // a handle for scripts and tests
    const commands = { screenshot: () => this.screenshot(), help: () => this.help.show(true), say: (text) => this.say(text) };
    this.help = new Help();
    this.toolbar = new Toolbar(this.player);
    this.names = new Names(this.player);
    this.transport = new Transport(this.player, commands);
    this.timeline = new Timeline(this.player);
    this.strips = new Strips(this.player);
    this.timeline.lanes.after(this.strips.element);
    this.sequencer = new Sequencer(this.player);
    this.hint = new ToolHint(this.player);
    this.view.append(this.names.element, this.toolbar.element, this.sequencer.plan.element, this.hint.element);
    this.frame.append(this.transport.element, this.timeline.element, this.sequencer.element, this.help.element);
    this.undo.unshift(() => this.timeline.dispose(), () => this.strips.dispose(), () => this.sequencer.dispose());
    this.#listen();
    this.#pointer();
    this.player.resize(this.view.clientWidth, this.view.clientHeight);
    this.#watch();
    this.undo.unshift(listenToKeys(this.host, this.player, { toolbar: this.toolbar, help: this.help, screenshot: commands.screenshot }));
    this.#refresh();
  }

  #listen() {
    const { player } = this;
    player.addEventListener("option", ({ detail }) => {
      if (detail.name === "selected" && player.actors.length) {
        this.timeline.rebuild();
        this.say(`${player.actors[detail.value]?.take.name || "Nothing"} picked`);
      }
      this.#refresh();
    });
    player.addEventListener("takes", () => {
      this.names.rebuild();
      this.timeline.rebuild();
      for (const part of [this.toolbar, this.transport]) part.refresh(); // they name the figures
      this.sequencer.refresh();
      this.canvas.setAttribute("aria-label", this.#inWords());
    });
    player.addEventListener("sequence", () => { this.timeline.element.hidden = this.sequencer.shown; });
    player.addEventListener("tick", () => {
      for (const part of [this.names, this.toolbar, this.transport, this.timeline, this.strips, this.sequencer]) part.tick();
    });
  }

  #refresh() {
    const { player } = this;
    this.paint(player.themeName);
    this.frame.dataset.controls = player.options.controls;
    for (const part of [this.names, this.toolbar, this.hint, this.transport, this.timeline, this.strips, this.sequencer]) part.refresh();
  }

  paint(theme) {
    this.frame.dataset.theme = theme;
  }

  #inWords() {
    const { actors, clock } = this.player;
    const names = actors.map(({ take }) => take.name).filter(Boolean).join(", ");
    const count = actors.length === 1 ? "one figure" : `${actors.length} figures`;
    return `3D stage: ${count}${names ? ` (${names})` : ""}, ${clock.duration.toFixed(1)} seconds`;
  }

  // ---- pointer, size, visibility ------------------------------------------------------------------

  #pointer() {
    const { canvas, player, host } = this;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return player.figureAt((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
    };
    let down = null;
    canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > CLICK) return;
      const picked = at(event);
      if (picked >= 0) player.set("selected", picked);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons || player.actors.length < 2) return;
      const over = at(event);
      player.hover(over);
      canvas.style.cursor = over >= 0 ? "pointer" : "";
    });
    canvas.addEventListener("pointerleave", () => player.hover(-1));
    // a page scrolls past the player; the wheel zooms once the player has the focus, or with Ctrl
    const wheel = (event) => { player.cameraman.controls.enableZoom = event.ctrlKey || host.matches(":focus-within"); };
    canvas.addEventListener("wheel", wheel, { capture: true, passive: true });
  }

  #watch() {
    const { player, view } = this;
    // drawn at once, not with the next frame: a resized canvas is blank
    const resized = new ResizeObserver(() => player.resize(view.clientWidth, view.clientHeight));
    resized.observe(view);
    const seen = new IntersectionObserver((entries) => player.stage.show(entries.at(-1).isIntersecting));
    seen.observe(this.host);
    const scheme = globalThis.matchMedia?.("(prefers-color-scheme: light)");
    const onScheme = () => { if (player.options.theme === "auto") { player.setTheme(); this.#refresh(); } };
    scheme?.addEventListener("change", onScheme);
    this.undo.unshift(() => {
      resized.disconnect();
      seen.disconnect();
      scheme?.removeEventListener("change", onScheme);
    });
  }

  // ---- the rest -----------------------------------------------------------------------------------

  /** For screen readers. */
  say(text) {
    this.status.textContent = text;
  }

  async screenshot() {
    const blob = await this.player.picture();
    const name = (this.player.actors[this.player.options.selected]?.take.name || "motion").replace(/[^\w-]+/g, "-");
    const url = URL.createObjectURL(blob);
    h("a", { href: url, download: `${name}-frame-${String(this.player.frame).padStart(4, "0")}.png` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
    this.say("Picture downloaded");
  }

  /** A message in place of the stage. */
  complain(title, detail) {
    this.frame.replaceChildren(h("div", { class: "complaint", role: "alert" }, h("strong", {}, title), h("p", {}, detail)));
  }

  height(pixels) {
    this.host.style.height = Number.isFinite(pixels) && pixels > 0 ? `${pixels}px` : "100%";
  }

  dispose() {
    for (const step of this.undo.splice(0)) step();
  }
}
