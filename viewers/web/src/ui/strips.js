// Under the lanes: which words each moment of the motion came from, and its tokens with what each of them looks like.
import { figureButton, Figures } from "./figures.js";
import { h } from "./dom.js";
import { prepare } from "./timeline.js";

const ROW = 13; // pixels of a word

export class Strips {
  constructor(player) {
    this.player = player;
    this.words = new Fold(player, "words", "words", "Which words each moment came from");
    this.tokens = new Fold(player, "tokens", "tokens", "Motion tokens");
    this.element = h("div", { class: "strips" }, this.words.element, this.tokens.element);
    this.figures = new Figures(player);
    for (const name of ["strips", "takes"]) player.addEventListener(name, () => this.rebuild());
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(this.element);
  }

  get data() {
    return this.player.strips;
  }

  rebuild() {
    this.words.offer(this.data.words);
    this.tokens.offer(this.data.tokens);
    this.element.hidden = !this.data.words && !this.data.tokens;
    this.#rebuildWords();
    this.#rebuildTokens();
    this.draw();
    this.tick();
  }

  #rebuildWords() {
    const { text, weights, seconds } = this.data.words ?? {};
    if (!text) return this.words.fill("…");
    this.heat = h("canvas", { role: "img", style: `height:${text.length * ROW}px`, "aria-label": inWords(text, weights, seconds) });
    this.#seeks(this.heat, seconds, weights.length, (step, y) => {
      const place = Math.min(text.length - 1, Math.max(0, Math.floor(y / ROW)));
      return `${(step * seconds).toFixed(1)} s: ${text[place]} ${Math.round(100 * weights[step][place])} %`;
    });
    this.labels = text.map((word) => h("span", { title: word }, word));
    this.words.fill(h("div", { class: "heat", role: "group", "aria-label": "Words", tabindex: 0 }, h("div", { class: "said", "aria-hidden": "true" }, ...this.labels), this.heat));
  }

  #rebuildTokens() {
    const { codes, seconds, figures, all } = this.data.tokens ?? {};
    if (!codes) return this.tokens.fill("…");
    this.band = h("canvas", { class: "codes", role: "img", "aria-label": `Motion tokens, ${seconds} s each: ${codes.join(", ")}` });
    this.#seeks(this.band, seconds, codes.length, (step) => `${(step * seconds).toFixed(1)} s: token ${codes[step]}`);
    this.figures.set(figures);
    const buttons = Object.keys(figures.points).map(Number).map((code) => figureButton(code, codes, seconds, () => this.#next(code)));
    const whole = h("button", {
      type: "button", class: "whole", "aria-pressed": String(this.player.options.open_strips.includes("all")),
      onclick: () => flip(this.player, "all"),
    }, `All ${all}`);
    this.tokens.fill(h("div", { class: "token-lane" }, this.band), h("div", { class: "gallery", role: "group", "aria-label": "What each token looks like" }, whole, ...buttons));
  }

  /** To where the token comes next. */
  #next(code) {
    const { codes, seconds } = this.data.tokens;
    const { clock } = this.player;
    const now = Math.floor(clock.frame / clock.fps / seconds + 1e-6);
    const places = codes.flatMap((other, place) => (other === code ? [place] : []));
    const place = places.find((one) => one > now) ?? places[0];
    if (place !== undefined) this.#seek(place * seconds);
  }

  #seek(time) {
    this.player.set("playing", false);
    this.player.seek(Math.ceil(time * this.player.clock.fps - 1e-6));
  }

  /** A press goes to the step under the pointer, which is said in the tooltip. */
  #seeks(canvas, seconds, steps, say) {
    const stepAt = (event) => {
      const box = canvas.getBoundingClientRect();
      const step = Math.floor((((event.clientX - box.left) / box.width) * this.player.clock.duration) / seconds);
      return Math.min(steps - 1, Math.max(0, step));
    };
    canvas.addEventListener("pointermove", (event) => {
      const step = stepAt(event);
      canvas.title = say(step, event.offsetY);
      if (canvas === this.band) this.#pointAt(this.data.tokens.codes[step]);
    });
    canvas.addEventListener("pointerleave", () => this.#pointAt(null));
    canvas.addEventListener("click", (event) => this.#seek(stepAt(event) * seconds));
  }

  /** The figure of the token under the pointer stands out. */
  #pointAt(code) {
    this.pointed = code;
    this.#mark();
  }

  draw() {
    const style = getComputedStyle(this.element);
    const { duration } = this.player.clock;
    if (this.words.open && this.data.words?.text) this.#drawHeat(style, duration);
    if (this.tokens.open && this.data.tokens?.codes) this.#drawCodes(style, duration);
    this.figures.show(this.tokens.open ? this.tokens.element.querySelector(".gallery") : null);
  }

  #drawHeat(style, duration) {
    const { weights, seconds } = this.data.words;
    const { context, width } = prepare(this.heat);
    const most = Math.max(...weights.flat(), 2 / (weights[0]?.length ?? 1)); // heard alike, none is bright
    context.fillStyle = style.getPropertyValue("--accent");
    weights.forEach((row, step) => row.forEach((weight, place) => {
      const [from, to] = [step, step + 1].map((at) => Math.min(width, (at * seconds * width) / duration));
      context.globalAlpha = weight / most;
      context.fillRect(from, place * ROW + 1, to - from, ROW - 2);
    }));
  }

  #drawCodes(style, duration) {
    const { codes, seconds } = this.data.tokens;
    const { context, width, height } = prepare(this.band);
    context.font = `10.5px ${style.fontFamily}`;
    context.textAlign = "center";
    codes.forEach((code, step) => {
      const [from, to] = [step, step + 1].map((at) => Math.min(width, (at * seconds * width) / duration));
      context.fillStyle = hue(code);
      context.fillRect(from + 0.5, 0, Math.max(to - from - 1, 0.5), height);
      if (to - from < 22) return;
      context.fillStyle = "#0d1117";
      context.fillText(code, (from + to) / 2, height / 2 + 4);
    });
  }

  refresh() {
    this.words.refresh();
    this.tokens.refresh();
    this.draw();
    this.tick();
  }

  tick() {
    const { clock } = this.player;
    const { text, weights, seconds } = this.data.words ?? {};
    if (text && this.words.open) {
      const row = weights[Math.min(weights.length - 1, Math.floor(clock.at / clock.fps / seconds))] ?? [];
      const loud = Math.max(0.6 * Math.max(...row), 1.2 / row.length);
      this.labels.forEach((label, place) => label.classList.toggle("heard", row[place] > loud));
    }
    this.#mark();
  }

  #mark() {
    const { codes, seconds } = this.data.tokens ?? {};
    if (!codes || !this.tokens.open) return;
    const { clock } = this.player;
    const code = this.pointed ?? codes[Math.min(codes.length - 1, Math.floor(clock.at / clock.fps / seconds))];
    if (code === this.marked && this.tokens.element.querySelector(".figure.on")) return;
    this.marked = code;
    for (const one of this.tokens.element.querySelectorAll(".figure")) one.classList.toggle("on", Number(one.dataset.code) === code);
  }

  dispose() {
    this.observer.disconnect();
    this.figures.show(null);
  }
}

/** A part that opens and closes by its name in the gutter; which are open is the option `open_strips`. */
class Fold {
  constructor(player, name, text, label) {
    Object.assign(this, { player, name });
    this.toggle = h("button", { type: "button", class: "fold", title: label, "aria-label": label, onclick: () => flip(player, name) }, text);
    this.body = h("div", { class: "fold-body" });
    this.element = h("div", { class: `strip ${name}` }, this.toggle, this.body);
  }

  get open() {
    return this.player.options.open_strips.split(",").includes(this.name) && !this.element.hidden;
  }

  offer(data) {
    this.element.hidden = !data;
    this.refresh();
  }

  fill(...children) {
    this.body.replaceChildren(...children);
  }

  refresh() {
    this.toggle.setAttribute("aria-expanded", String(this.open));
    this.body.hidden = !this.open;
  }
}

function flip(player, name) {
  const open = player.options.open_strips.split(",").filter(Boolean);
  player.set("open_strips", (open.includes(name) ? open.filter((other) => other !== name) : [...open, name]).join(","));
}

/** Tokens far apart in number look apart; each has one colour. */
function hue(code) {
  return `hsl(${(code * 137.508) % 360} 42% 66%)`;
}

function inWords(text, weights, seconds) {
  const peaks = text.map((word, place) => {
    const column = weights.map((row) => row[place]);
    return `${word} most at ${(column.indexOf(Math.max(...column)) * seconds).toFixed(1)} s`;
  });
  return `Which words each moment came from: ${peaks.join(", ")}`;
}
