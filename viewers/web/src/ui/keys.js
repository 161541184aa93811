// The keyboard.
import { LOOPS } from "../clock.js";

/** Key -> what it does; names as in KeyboardEvent.key, letters in lower case. */
function actions(player, { toolbar, help, screenshot }) {
  return {
    " ": () => player.toggle("playing"),
    arrowleft: (event) => player.step(event.shiftKey ? -10 : -1),
    arrowright: (event) => player.step(event.shiftKey ? 10 : 1),
    ",": () => player.step(-1),
    ".": () => player.step(1),
    home: () => player.step(-Infinity),
    end: () => player.step(Infinity),
    i: () => mark(player, "start"),
    o: () => mark(player, "end"),
    l: () => player.set("loop", LOOPS[(LOOPS.indexOf(player.options.loop) + 1) % LOOPS.length]),
    g: () => toolbar.toggleGhosts(),
    s: () => toolbar.cycleShow(),
    t: () => player.toggle("trail"),
    c: () => player.toggle("contacts"),
    v: () => player.actors.length > 1 && toolbar.toggleOverlay(),
    f: () => player.toggleFollow(),
    p: () => screenshot(),
    1: () => player.set("camera", "front"),
    2: () => player.set("camera", "back"),
    3: () => player.set("camera", "left"),
    4: () => player.set("camera", "right"),
    0: () => player.resetView(),
    "+": () => player.nudgeCamera(0, 0, 0.85),
    "=": () => player.nudgeCamera(0, 0, 0.85),
    "-": () => player.nudgeCamera(0, 0, 1.18),
    "?": () => help.show(!help.open),
    escape: () => (help.open ? help.show(false) : player.set("tool", "none")),
  };
}

const ORBIT = { arrowleft: [-10, 0], arrowright: [10, 0], arrowup: [0, 6], arrowdown: [0, -6] };

/** Start or end of the selection at the playhead. */
function mark(player, edge) {
  const [start, end] = player.clock.selection ?? [0, player.clock.frames];
  const here = player.frame;
  const range = edge === "start" ? [here, end > here ? end : player.clock.frames] : [start <= here ? start : 0, here + 1];
  player.set("selection", range);
  player.set("loop", "selection");
}

/**
 * Listens on `host`, or on the whole page while the option `global_keys` is on (then not while someone types).
 * Returns a function that stops listening.
 */
export function listenToKeys(host, player, parts) {
  const table = actions(player, parts);
  const onKey = (event) => {
    const inside = event.composedPath().includes(host);
    if (event.defaultPrevented || (!inside && !player.options.global_keys)) return;
    if (run(event, table, player, parts.help)) {
      event.preventDefault();
      event.stopPropagation(); // notebooks give keys such as these a meaning of their own
    }
  };
  host.addEventListener("keydown", onKey);
  document.addEventListener("keydown", onKey);
  return () => {
    host.removeEventListener("keydown", onKey);
    document.removeEventListener("keydown", onKey);
  };
}

function run(event, table, player, help) {
  const target = event.composedPath()[0];
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey || typesInto(target)) return false;
  if (help.open && key !== "escape" && key !== "?") return false;
  if (key === "escape" && !help.open && player.options.tool === "none") return false;
  if ((key === " " || key === "enter") && target.matches?.("button")) return false; // the button's own key
  if (event.altKey) {
    if (!ORBIT[key]) return false;
    player.nudgeCamera(...ORBIT[key]);
    return true;
  }
  const action = Object.hasOwn(table, key) ? table[key] : null;
  action?.(event);
  return action !== null;
}

function typesInto(target) {
  return Boolean(target.isContentEditable || target.matches?.("input, textarea, select, [role=textbox]"));
}
