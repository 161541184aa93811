// The keyboard on a block or on the transition before it.
import { COMMANDS, fits } from "./commands.js";
import { LONGEST_TRANSITION, SHORTEST, round } from "./layout.js";

const FINE = 0.1; // seconds a press
const COARSE = 1;

/** Does what a key means there; returns whether it means anything. */
export function onBlockKey(sequencer, event) {
  const { id, part } = event.target.dataset;
  const span = sequencer.spans.find(({ block }) => block.id === id);
  if (!span || event.ctrlKey || event.metaKey) return false;
  const along = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
  if (part === "gap") return Boolean(along) && stretch(sequencer, span, along * (event.shiftKey ? COARSE : FINE));
  if (along && event.altKey) return trim(sequencer, span, along * (event.shiftKey ? COARSE : FINE));
  if (along && event.shiftKey) return move(sequencer, span, along);
  if (along) return pick(sequencer, span.index + along);
  if (event.key === "Home") return pick(sequencer, 0);
  if (event.key === "End") return pick(sequencer, sequencer.spans.length - 1);
  if (event.altKey) return false;
  const pressed = event.key === "Backspace" ? "delete" : event.key.toLowerCase();
  const command = COMMANDS.find(({ key }) => key.toLowerCase() === pressed);
  if (!command) return false;
  if (fits(command, span)) command.act(sequencer, span);
  return true;
}

function pick(sequencer, index) {
  const span = sequencer.spans[Math.min(Math.max(index, 0), sequencer.spans.length - 1)];
  sequencer.pick(span.block.id, { focus: true });
  return true;
}

function move(sequencer, { block, index }, by) {
  const to = index + by;
  if (to >= 0 && to < sequencer.spans.length) sequencer.tell("move", { id: block.id, to });
  return true;
}

function trim(sequencer, { block }, by) {
  const seconds = round(Math.max(block.seconds + by, SHORTEST));
  if (seconds !== block.seconds) sequencer.tell("change", { id: block.id, values: { seconds } });
  return true;
}

function stretch(sequencer, { block }, by) {
  const transition = round(Math.min(Math.max(block.transition + by, 0), LONGEST_TRANSITION));
  if (transition !== block.transition) sequencer.tell("change", { id: block.id, values: { transition } });
  return true;
}
