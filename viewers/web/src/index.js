// Entry of the bundle. `render` is what anywidget and Panel call; `mount` is for plain pages.
import { bind } from "./bind.js";
import { WebGLMissing } from "./stage.js";
import { syncAddress } from "./url.js";
import { Widget } from "./widget.js";

const panelViews = new WeakMap();

/** Shows a model's player in `el`; returns the function that takes it down again. */
function render({ model, el }) {
  // Panel renders a view anew without taking the old rendering down; its adapter (unlike anywidget's model) is per view
  if ("view" in model) panelViews.get(model)?.();
  const widget = new Widget(el, model.get("theme"));
  const resize = () => widget.height(model.get("height"));
  resize();
  model.on("change:height", resize);
  const undo = [() => model.off("change:height", resize), () => widget.dispose()];
  try {
    widget.start();
    undo.unshift(bind(model, widget.player));
    undo.unshift(syncAddress(widget.player));
    report(model, { ready: true, error: "" });
  } catch (error) {
    fail(model, widget, error);
  }
  const takeDown = () => undo.splice(0).forEach((step) => step());
  if ("view" in model) panelViews.set(model, takeDown);
  return takeDown;
}

function fail(model, widget, error) {
  const missing = error instanceof WebGLMissing;
  const title = missing ? "This browser cannot draw in 3D here" : "The motion could not be shown";
  const detail = missing
    ? "The player needs WebGL 2. Turn on hardware acceleration, or open the page in a current Chrome, Edge, Firefox or Safari."
    : String(error.message ?? error);
  if (!missing) console.error(error);
  widget.complain(title, detail);
  report(model, { ready: false, error: `${title}: ${detail}` });
}

function report(model, values) {
  for (const [name, value] of Object.entries(values)) model.set(name, value);
  model.save_changes();
}

/** A model for pages without Python: a bag of values with anywidget's interface. */
class PlainModel {
  constructor(values) {
    this.values = values;
    this.callbacks = new Map();
  }

  get(name) {
    return this.values[name];
  }

  set(name, value) {
    this.values[name] = value;
    this.callbacks.get(`change:${name}`)?.forEach((callback) => callback());
  }

  on(event, callback) {
    this.callbacks.set(event, [...(this.callbacks.get(event) ?? []), callback]);
  }

  off(event, callback) {
    this.callbacks.set(event, (this.callbacks.get(event) ?? []).filter((other) => other !== callback));
  }

  save_changes() {}
}

function bytes(base64) {
  return base64 ? Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)) : new Uint8Array();
}

/**
 * A player on a plain page. `values` holds options by their trait names, and `body_data` and `take_data` in base64.
 * Returns {model, dispose}; set traits with model.set(name, value).
 */
export function mount(el, values) {
  const model = new PlainModel({ ...values, body_data: bytes(values.body_data), take_data: bytes(values.take_data) });
  return { model, dispose: render({ model, el }) };
}

// Every cell of a notebook loads the bundle anew; three.js would warn of a second copy at each of them.
delete globalThis.__THREE__;

export default { render };
