// Ties a player to a model of traits: anywidget's in Jupyter, Panel's adapter, or the plain one in index.js.
import { OPTIONS, same } from "./options.js";

const SEND_EVERY = 200; // milliseconds between frames sent while playing
const ECHO = 0.4; // seconds: a frame this near to where playing is, is an echo or a twin view, not a wish

/** Options and frame both ways, payloads one way. Returns a function that unties them. */
export function bind(model, player) {
  const guard = { busy: false };
  const undo = [];
  const on = (name, react) => {
    const callback = () => { if (!guard.busy) react(); };
    model.on(`change:${name}`, callback);
    undo.push(() => model.off(`change:${name}`, callback));
  };
  const send = (values) => {
    guard.busy = true; // models call back while they are being set
    try {
      for (const [name, value] of Object.entries(values)) model.set(name, value);
      model.save_changes();
    } finally {
      guard.busy = false;
    }
  };

  receiveAll(model, player);
  if (player.options.playing && player.cameraman.calm) player.set("playing", false); // no auto-play for who asked for calm
  sendCorrections(model, player, send);
  for (const name of Object.keys(OPTIONS)) on(name, () => player.set(name, model.get(name)));
  on("frame", () => receiveFrame(player, model.get("frame")));
  on("body_data", () => player.setBody(model.get("body_data")));
  on("pinned", () => player.setPins(model.get("pinned")));
  on("strips", () => player.setStrips(model.get("strips")));
  on("sequence", () => player.setSequence(model.get("sequence")));
  on("take_data", () => player.setTakes(model.get("take_data")));
  undo.push(sendBack(model, player, send));
  return () => undo.forEach((step) => step());
}

function receiveAll(model, player) {
  player.setBody(model.get("body_data"));
  for (const name of Object.keys(OPTIONS)) {
    const value = model.get(name);
    if (value !== undefined && name !== "playing" && name !== "selection") player.set(name, value);
  }
  player.setTakes(model.get("take_data"));
  player.setPins(model.get("pinned"));
  player.setStrips(model.get("strips"));
  player.setSequence(model.get("sequence"));
  player.set("selection", model.get("selection") ?? []);
  player.seek(model.get("frame") ?? 0);
  player.set("playing", model.get("playing") ?? false);
}

// What the player itself decided on the way in (another camera for a long walk, no auto-play).
function sendCorrections(model, player, send) {
  const corrected = Object.entries(player.options).filter(([name, value]) => !same(model.get(name), value));
  if (corrected.length) send(Object.fromEntries(corrected));
}

function receiveFrame(player, frame) {
  if (!Number.isFinite(frame)) return;
  const { clock } = player;
  const gap = Math.abs(frame - clock.at);
  const around = Math.min(gap, clock.frames - gap) / clock.fps; // a loop's end and start are neighbours
  if (clock.playing ? around > ECHO * clock.speed : frame !== clock.at) player.seek(frame);
}

function sendBack(model, player, send) {
  let last = 0;
  const sendFrame = () => {
    last = performance.now();
    if (player.frame !== model.get("frame")) send({ frame: player.frame });
  };
  const onTick = () => { if (performance.now() - last >= SEND_EVERY) sendFrame(); };
  const onOption = ({ detail: { name, value } }) => send({ [name]: value });
  // told apart by their time, or the same line drawn twice would be no change
  const onDrawn = ({ detail }) => send({ drawn: { ...detail, time: Date.now() } });
  const onArranged = ({ detail }) => send({ arranged: { ...detail, time: performance.now() } });
  player.addEventListener("drawn", onDrawn);
  player.addEventListener("arranged", onArranged);
  player.addEventListener("tick", onTick);
  player.addEventListener("settle", sendFrame);
  player.addEventListener("option", onOption);
  return () => {
    player.removeEventListener("drawn", onDrawn);
    player.removeEventListener("arranged", onArranged);
    player.removeEventListener("tick", onTick);
    player.removeEventListener("settle", sendFrame);
    player.removeEventListener("option", onOption);
  };
}
