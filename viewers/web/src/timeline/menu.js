// The menu of a block: right button, or the menu key.
import { h, icon } from "../ui/dom.js";
import { COMMANDS, fits, named } from "./commands.js";

export class Menu {
  constructor(sequencer) {
    this.sequencer = sequencer;
    this.element = h("div", { class: "seq-menu", role: "menu", "aria-label": "Block", hidden: true });
    this.element.addEventListener("keydown", (event) => this.#key(event));
    this.element.addEventListener("focusout", (event) => { if (!this.element.contains(event.relatedTarget)) this.close(); });
  }

  open(span, event) {
    const { sequencer } = this;
    this.id = span.block.id;
    this.element.replaceChildren(...COMMANDS.map((command) => h("button", {
      type: "button", role: "menuitem", tabindex: -1, disabled: !fits(command, span),
      onclick: () => {
        this.close(true);
        command.act(sequencer, span);
      },
    }, icon(command.symbol), h("span", {}, named(command, span)), h("kbd", {}, command.key === "Delete" ? "Del" : command.key))));
    this.element.hidden = false;
    const box = sequencer.element.getBoundingClientRect();
    const block = sequencer.blocks.of(this.id).getBoundingClientRect();
    const at = event.clientX || block.left + 12; // the menu key has no place
    this.element.style.left = `${Math.max(8, Math.min(at - box.left, box.width - this.element.offsetWidth - 8))}px`;
    this.element.style.bottom = `${box.bottom - (event.clientY || block.top)}px`;
    this.#items()[0].focus();
  }

  #items() {
    return [...this.element.querySelectorAll("button:not(:disabled)")];
  }

  #key(event) {
    const items = this.#items();
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (by) items.at((items.indexOf(this.element.getRootNode().activeElement) + by) % items.length).focus();
    else if (event.key === "Escape" || event.key === "Tab") this.close(true);
    else if (event.key !== "Enter" && event.key !== " ") return;
    else {
      event.stopPropagation();
      return; // the button's own
    }
    event.preventDefault();
    event.stopPropagation();
  }

  close(back = false) {
    if (this.element.hidden) return;
    this.element.hidden = true;
    if (back) this.sequencer.blocks.focus(this.id);
  }
}
