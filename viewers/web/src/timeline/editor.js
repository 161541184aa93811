// What a block is, in fields: what it shows, how long, in which manner, from which seed.
import { button, h } from "../ui/dom.js";
import { LONGEST_TRANSITION, SHORTEST } from "./layout.js";

export class Editor {
  constructor(sequencer) {
    this.sequencer = sequencer;
    this.id = null;
    this.known = h("datalist", { id: "seq-actions" });
    this.fields = {
      kind: h("select", {}, h("option", { value: "action" }, "Action"), h("option", { value: "prompt" }, "In words")),
      what: h("input", { type: "text", list: "seq-actions", autocomplete: "off", maxlength: 1000 }),
      style: h("select"),
      engine: h("select"),
      seconds: h("input", { type: "number", min: SHORTEST, max: 600, step: 0.1 }),
      transition: h("input", { type: "number", min: 0, max: LONGEST_TRANSITION, step: 0.1 }),
      seed: h("input", { type: "number", min: 0, step: 1 }),
    };
    for (const [name, field] of Object.entries(this.fields)) field.addEventListener("change", () => this.#changed(name));
    this.title = h("strong");
    const close = button({ label: "Close", symbol: "close", key: "Escape", className: "icon", onclick: () => this.close(true) });
    const labels = { kind: "Kind", what: "Shows", style: "Style", engine: "Engine", seconds: "Seconds", transition: "Transition", seed: "Seed" };
    this.rows = Object.fromEntries(Object.entries(this.fields).map(([name, field]) => [name, h("label", { class: name }, h("span", {}, labels[name]), field)]));
    // put in while it is open: a page is searched for labels, hidden ones too
    this.parts = [h("div", { class: "seq-editor-head" }, this.title, close), this.known, h("div", { class: "seq-fields" }, ...Object.values(this.rows))];
    this.element = h("div", { class: "seq-editor", role: "dialog", "aria-label": "Block", hidden: true });
    this.element.addEventListener("keydown", (event) => this.#key(event));
  }

  get span() {
    return this.sequencer.spans.find(({ block }) => block.id === this.id) ?? null;
  }

  open(id) {
    this.id = id;
    this.element.replaceChildren(...this.parts);
    this.element.hidden = false;
    this.refresh();
    const field = this.fields.what.disabled ? this.fields.transition : this.fields.what;
    field.focus();
    field.select();
  }

  close(back = false) {
    if (this.element.hidden) return;
    const { id } = this;
    this.id = null;
    this.element.hidden = true;
    this.element.replaceChildren();
    if (back) this.sequencer.blocks.focus(id);
  }

  refresh() {
    const { span, sequencer } = this;
    if (this.element.hidden) return;
    if (!span) {
      this.close();
      return;
    }
    const { block, index } = span;
    const { actions, styles, engines, words } = sequencer.data;
    this.title.textContent = `Block ${index + 1}${block.locked ? ", locked" : ""}`;
    this.known.replaceChildren(...(block.kind === "action" ? actions : []).map((name) => h("option", { value: name })));
    fill(this.fields.style, [["", "any"], ...styles.map((name) => [name, name])]);
    fill(this.fields.engine, [["", "usual"], ...engines.map((name) => [name, name])]);
    this.rows.kind.hidden = block.kind === "clip" || !words;
    this.rows.style.hidden = block.kind === "clip" || !styles.length;
    this.rows.engine.hidden = block.kind === "clip" || engines.length < 2;
    this.rows.seed.hidden = block.kind === "clip";
    this.rows.transition.hidden = index === 0;
    const active = this.element.getRootNode().activeElement;
    for (const [name, field] of Object.entries(this.fields)) {
      field.disabled = block.locked && name !== "transition";
      if (field !== active || field.tagName === "SELECT") field.value = block[name];
    }
    const middle = (sequencer.x(span.start) + sequencer.x(span.end)) / 2;
    const room = sequencer.element.clientWidth - this.element.offsetWidth - 8;
    this.element.style.left = `${Math.max(8, Math.min(middle - this.element.offsetWidth / 2, room))}px`;
  }

  #changed(name) {
    const field = this.fields[name];
    const value = field.type === "number" ? field.valueAsNumber : field.value.trim();
    if (!this.span || value === this.span.block[name]) return;
    const { rangeUnderflow, rangeOverflow, badInput } = field.validity;
    if (rangeUnderflow || rangeOverflow || badInput || Number.isNaN(value) || (name === "what" && !value)) {
      this.sequencer.tools.complain(field.validationMessage || "A block shows something.");
      field.value = this.span.block[name];
      return;
    }
    this.sequencer.tell("change", { id: this.id, values: { [name]: value } });
  }

  #key(event) {
    event.stopPropagation();
    if (event.key === "Escape" || (event.key === "Enter" && event.target.matches("input"))) {
      event.preventDefault();
      if (event.key === "Enter") event.target.dispatchEvent(new Event("change"));
      this.close(true);
    }
  }
}

function fill(field, entries) {
  const now = JSON.stringify(entries);
  if (field.dataset.now === now) return;
  field.dataset.now = now;
  field.replaceChildren(...entries.map(([value, text]) => h("option", { value }, text)));
}
