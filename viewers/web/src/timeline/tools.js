// The row above the blocks: how long it all is, what went wrong, what can be done, and how much is in view.
import { button, h, press } from "../ui/dom.js";
import { COMMANDS, fits, named } from "./commands.js";
import { clockText } from "./layout.js";

export class Tools {
  constructor(sequencer) {
    this.sequencer = sequencer;
    this.about = h("span", { class: "seq-about" });
    this.fault = h("span", { class: "seq-fault", role: "alert" });
    this.acts = COMMANDS.map((command) => [command, button({
      label: command.label, symbol: command.symbol, key: command.key, className: "icon",
      onclick: () => sequencer.picked && command.act(sequencer, sequencer.picked),
    })]);
    const out = button({ label: "Show more of it", symbol: "minus", className: "icon", onclick: () => sequencer.zoom(1 / 1.5) });
    const near = button({ label: "Show less of it", symbol: "plus", className: "icon", onclick: () => sequencer.zoom(1.5) });
    this.fit = button({ label: "Fit", text: "Fit", onclick: () => sequencer.fit() });
    this.above = button({ label: "From above", text: "From above", onclick: () => { sequencer.plan.toggle(); this.refresh(); } });
    this.element = h("div", { class: "seq-tools", role: "toolbar", "aria-label": "Blocks" },
      this.about, this.fault, h("span", { class: "group" }, ...this.acts.map(([, element]) => element)),
      h("span", { class: "group" }, out, near, this.fit), this.above);
  }

  refresh() {
    const { sequencer } = this;
    const { data, picked } = sequencer;
    const count = data.blocks.length;
    this.about.textContent = count ? `${count} block${count === 1 ? "" : "s"} · ${clockText(Math.round(sequencer.length * 10) / 10)}` : "No blocks yet";
    this.complain(data.error);
    for (const [command, element] of this.acts) {
      element.disabled = !picked || !fits(command, picked);
      element.setAttribute("aria-label", named(command, picked));
      element.title = `${named(command, picked)} (${command.key})`;
    }
    press(this.above, sequencer.plan.wanted);
  }

  /** Says what cannot be done, until something else is. */
  complain(text) {
    this.fault.textContent = text;
    this.fault.title = text;
  }
}
