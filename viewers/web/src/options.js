// What can be set on a player, from its own controls or from Python: names, defaults, accepted values.
import { LOOPS, SPEED } from "./clock.js";
import { VIEWS } from "./cameraman.js";

const flag = (fallback) => ({ fallback, clean: (value) => Boolean(value) });
const oneOf = (...values) => ({ fallback: values[0], clean: (value) => (values.includes(value) ? value : undefined) });
const text = (fallback) => ({ fallback, clean: (value) => (typeof value === "string" ? value : undefined) });
const number = (fallback, low, high) => ({
  fallback,
  clean: (value) => (Number.isFinite(value) ? Math.min(Math.max(value, low), high) : undefined),
});
const whole = (fallback, low, high) => ({
  fallback,
  clean: (value) => (Number.isFinite(value) ? Math.round(Math.min(Math.max(value, low), high)) : undefined),
});

/** Each cleans a value that came from outside; `undefined` means it is not accepted and is left alone. */
export const OPTIONS = {
  show: oneOf("body", "skeleton", "both"),
  camera: oneOf(...VIEWS),
  theme: oneOf("dark", "light", "auto"),
  ghosts: whole(0, 0, 1000),
  trail: flag(false),
  contacts: flag(false),
  floor: flag(true),
  names: flag(true),
  in_place: flag(false),
  mirror: flag(false),
  editable: text(""),
  edits: text(""),
  arrangement: oneOf("side", "overlay"),
  spacing: number(1.2, 0, 20),
  controls: oneOf("full", "minimal", "none"),
  tool: oneOf("none", "path", "joint"),
  block: text(""),
  open_strips: text("words"),
  playing: flag(false),
  speed: number(1, SPEED.min, SPEED.max),
  loop: { ...oneOf(...LOOPS), fallback: "all" },
  selection: { fallback: [], clean: cleanRange },
  selected: whole(0, -1, 15),
  sync_url: flag(false),
  global_keys: flag(false),
};

function cleanRange(value) {
  if (!Array.isArray(value) || value.length === 0) return [];
  const [start, end] = value.map((x) => Math.round(x));
  return Number.isFinite(start) && end > start && start >= 0 ? [start, end] : undefined;
}

export function defaults() {
  return Object.fromEntries(Object.entries(OPTIONS).map(([name, { fallback }]) => [name, fallback]));
}

export function same(a, b) {
  return Array.isArray(a) && Array.isArray(b) ? a.length === b.length && a.every((x, i) => x === b[i]) : a === b;
}
