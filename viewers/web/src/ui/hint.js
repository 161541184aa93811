// A line over the stage that says what the tool in hand does, and puts it down.
import { button, h } from "./dom.js";

const WORDS = {
  path: "Draw on the floor: press, drag, release.",
  joint: "Drag a dot to where that joint is to be.",
};

export class ToolHint {
  constructor(player) {
    this.player = player;
    this.text = h("span", { role: "status" });
    const done = button({ label: "Done", text: "Done", key: "Esc", onclick: () => player.set("tool", "none") });
    this.element = h("div", { class: "float hint", hidden: true }, this.text, done);
    player.addEventListener("say", ({ detail }) => { this.text.textContent = detail.text ?? WORDS[player.options.tool] ?? ""; });
    player.addEventListener("drawn", () => this.refresh());
  }

  refresh() {
    const { tool } = this.player.options;
    this.element.hidden = tool === "none";
    if (tool !== "none") this.text.textContent = WORDS[tool];
  }
}
