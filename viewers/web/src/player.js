// MotionPlayer: figures on a stage, a clock, and options that any side may change.
import { MathUtils, Raycaster, Vector2, Vector3 } from "three";
import { Actor } from "./actor.js";
import { Cameraman } from "./cameraman.js";
import { Clock } from "./clock.js";
import { coverOf, floorWay, spreadOf } from "./ways.js";
import { OPTIONS, defaults, same } from "./options.js";
import { decodeBody, decodeTakes } from "./payload.js";
import { Pins } from "./pins.js";
import { BodyGeometry } from "./skin.js";
import { Stage } from "./stage.js";
import { resolveTheme } from "./theme.js";
import { Tools } from "./tools.js";

const DRIFT = 2; // metres figures may drift apart and still be followed as a group
const LONGEST_ROW = 8; // figures; more stand in two rows
const ROW_GAP = 1.9; // metres from the first row to the one behind
const CROWD = 4; // more figures than this are drawn with the coarser mesh

/**
 * Events (addEventListener): "option" {name, value} when an option changed by itself or by hand,
 * "tick" for every picture, "settle" when a still frame was reached (pause, step, end of scrubbing), "takes",
 * "pins" when what is pinned changed, "drawn" {kind: "path" | "joint", ...} when the tool in hand drew something,
 * "sequence" when the blocks to arrange changed, "arranged" {do, id, ...} when a person did something to them, "strips"
 * when what stands under the timeline changed.
 */
export class MotionPlayer extends EventTarget {
  constructor(canvas) {
    super();
    this.options = defaults();
    this.clock = new Clock();
    this.actors = [];
    this.sequence = {};
    this.strips = {};
    this.body = null;
    this.geometry = null;
    this.hovered = -1;
    this.framed = false;
    this.jumped = false; // sought since the last picture
    this.stage = new Stage(canvas, (elapsed) => this.#advance(elapsed));
    this.pins = new Pins();
    this.tools = new Tools(this, canvas); // before the camera, so that it hears the pointer first
    this.stage.scene.add(this.pins.object, this.tools.dots);
    this.cameraman = new Cameraman(this.stage.camera, canvas, {
      changed: () => this.stage.invalidate(),
      taken: () => this.#handOnCamera(),
    });
    this.setTheme();
  }

  // ---- what is shown ------------------------------------------------------------------------------

  setBody(data) {
    this.body = decodeBody(data);
    this.geometry?.dispose();
    this.geometry = this.body && new BodyGeometry(this.body, () => this.stage.invalidate());
    if (this.actors.length) this.#stageTakes(this.actors.map((actor) => actor.take));
  }

  /**
   * New takes: from the first frame on and framed anew, unless they are as many and as long as those before. Then
   * they are another version of the same, and the place in time, the selection and the camera stay.
   */
  setTakes(data) {
    const takes = decodeTakes(data);
    const fps = takes[0]?.fps ?? 20;
    const frames = Math.round(Math.max(0, ...takes.map((take) => take.frames / take.fps)) * fps);
    const version = takes.length === this.actors.length && frames === this.clock.frames && fps === this.clock.fps;
    this.#stageTakes(takes);
    if (!version) {
      this.clock.at = 0;
      this.clock.cover(fps, frames);
      this.#option("selection", []);
      this.#option("selected", Math.min(this.options.selected, takes.length - 1));
    }
    this.#pose();
    if (this.framed && takes.length && !version) {
      if (this.cameraman.tooLong) this.#followInstead();
      this.#reframe();
    } else if (this.stage.size && !this.framed) this.#firstLook();
    this.stage.invalidate();
    if (this.pins.data.poses.length) this.setPins(this.pins.data); // their ghosts wear what the takes wear
    this.#announce("takes");
    this.#announce("settle");
  }

  /** What is pinned of the motion to come; see `Pins`. */
  setPins(data) {
    const skeleton = this.body?.skeleton ?? this.actors[0]?.take.skeleton ?? null;
    this.pins.theme = this.stage.theme;
    this.pins.set(data ?? {}, skeleton, this.geometry);
    this.stage.invalidate();
    this.#announce("pins");
  }

  /** Blocks to arrange in place of the timeline: see `sequence` in controls.py; none where it is empty. */
  setSequence(data) {
    this.sequence = data ?? {};
    this.#announce("sequence");
  }

  /** What stands under the timeline of the picked figure: see `strips` in controls.py; nothing where it is empty. */
  setStrips(data) {
    this.strips = data ?? {};
    this.#announce("strips");
  }

  /** New size of the stage, in CSS pixels; the first one also frames what there is. */
  resize(width, height) {
    if (!width || !height) return;
    this.stage.resize(width, height);
    if (!this.framed) this.#firstLook();
    this.#advance(0);
    this.stage.draw();
  }

  #firstLook() {
    if (!this.actors.length) return;
    this.framed = true;
    if (this.cameraman.tooLong) this.#followInstead();
    this.#reframe({ glide: false, home: true });
    this.#pose();
  }

  // A way too long to be framed whole with figures of a decent size.
  #followInstead() {
    this.cameraman.tracking = true;
    if (this.options.camera === "orbit") this.#option("camera", "follow");
  }

  #stageTakes(takes) {
    for (const actor of this.actors) {
      this.stage.scene.remove(actor.object);
      actor.dispose();
    }
    const crowd = takes.length > CROWD;
    this.actors = takes.map((take) => new Actor(take, this.#fits(take) ? this.geometry : null, crowd));
    this.actors.forEach((actor) => this.stage.scene.add(actor.object));
    this.#arrange();
    this.#restyle();
  }

  #fits(take) {
    return this.body !== null && String(this.body.skeleton.joints) === String(take.skeleton.joints);
  }

  /**
   * Side by side along x, the first on the viewer's left, many in two rows; or all in one place. Each take's own offset
   * comes on top.
   */
  #arrange() {
    const { arrangement, spacing, mirror, in_place: inPlace } = this.options;
    const ways = this.actors.map(({ take }) => floorWay(take, { mirror, inPlace }));
    const count = this.actors.length;
    const aside = arrangement === "side" && count > 1;
    const columns = count > LONGEST_ROW ? Math.ceil(count / 2) : count;
    this.actors.forEach((actor, i) => {
      const row = Math.floor(i / columns);
      const x = aside ? ((i % columns) - (columns - 1) / 2 + row / 2) * spacing - ways[i][0] : 0;
      const z = aside ? -row * ROW_GAP : 0;
      const [dx, dy, dz] = actor.take.offset;
      actor.object.position.set(x + dx, dy, z + dz);
    });
    if (!ways.length) return;
    const places = this.actors.map((actor) => actor.object.position);
    const { bounds, reach, start } = coverOf(ways, this.actors.map(({ take }) => take.fps), places);
    this.together = reach <= start + DRIFT;
    this.begun = start;
    this.cameraman.cover(bounds, this.together ? reach : start);
  }

  // ---- options ------------------------------------------------------------------------------------

  /** Sets an option to a value from any side; what is not accepted is left alone. Returns whether it changed. */
  set(name, value) {
    if (name === "frame") return this.seek(value);
    const clean = OPTIONS[name]?.clean(value);
    return clean !== undefined && this.#option(name, clean);
  }

  toggle(name) {
    return this.set(name, !this.options[name]);
  }

  #option(name, value) {
    if (same(this.options[name], value)) return false;
    this.options[name] = value;
    this.#apply(name);
    this.dispatchEvent(new CustomEvent("option", { detail: { name, value } }));
    return true;
  }

  #apply(name) {
    const { options, clock } = this;
    if (name === "tool") this.#takeInHand();
    if (name === "playing") this.#playOrPause();
    else if (name === "speed" || name === "loop") clock[name] = options[name];
    else if (name === "selection") this.#select();
    else if (name === "camera") this.#aim();
    else if (name === "theme") this.setTheme();
    else if (["in_place", "mirror", "arrangement", "spacing"].includes(name)) {
      this.#arrange();
      this.#pose();
      if (name !== "mirror") this.#reframe();
    }
    this.#restyle();
    this.stage.invalidate();
  }

  // What is drawn lies where the motion is: nothing may be shown elsewhere or move meanwhile.
  #takeInHand() {
    if (this.options.tool === "none") return;
    for (const name of ["playing", "mirror", "in_place"]) this.#option(name, false);
  }

  #select() {
    const [start, end] = this.options.selection;
    this.clock.selection = end === undefined ? null : [Math.min(start, this.clock.frames - 1), Math.min(end, this.clock.frames)];
  }

  setTheme() {
    this.themeName = resolveTheme(this.options.theme);
    this.stage.paint(this.themeName);
    this.#restyle();
  }

  #restyle() {
    const { options } = this;
    const several = this.actors.length > 1;
    const overlaid = several && options.arrangement === "overlay";
    this.actors.forEach((actor, i) => {
      const state = { ...this.#poseOptions(), selected: i === options.selected, hovered: i === this.hovered, several, overlaid };
      actor.style({ ...state, trail: options.trail, contacts: options.contacts }, this.stage.theme);
    });
    this.pins.paint(this.stage.theme);
    this.tools.refresh();
    this.stage.floor.object.visible = options.floor;
    this.restyled = true;
    this.stage.invalidate();
  }

  #poseOptions() {
    const { show, ghosts, mirror, in_place: inPlace } = this.options;
    return { show, ghosts, mirror, inPlace };
  }

  // ---- time ---------------------------------------------------------------------------------------

  get frame() {
    return this.clock.frame;
  }

  /** Goes to a frame. `settled` is false while a hand still drags the playhead. */
  seek(frame, { settled = true } = {}) {
    const before = this.clock.at;
    this.clock.seek(frame);
    this.jumped = true;
    this.stage.invalidate();
    if (settled) this.#announce("settle");
    return before !== this.clock.at;
  }

  /** Steps by whole frames and stays there. */
  step(by) {
    this.set("playing", false);
    this.seek(this.frame + by);
  }

  #playOrPause() {
    const { clock, options } = this;
    if (options.playing) clock.rewindIfDone();
    else clock.seek(clock.frame);
    clock.playing = options.playing;
    if (!options.playing) this.#announce("settle");
  }

  #advance(elapsed) {
    const { clock } = this;
    if (clock.playing && clock.advance(elapsed)) this.#option("playing", false);
    this.#pose();
    const subject = this.subject;
    const gliding = this.cameraman.update(this.jumped && !clock.playing ? 0 : elapsed || 1 / 60, subject);
    this.jumped = false;
    this.stage.lightAround(...spreadOf(this.actors.map(({ root }) => root)));
    if (this.geometry) this.geometry.rough = this.stage.rough;
    this.dispatchEvent(new CustomEvent("tick"));
    return clock.playing || gliding;
  }

  #pose() {
    const seconds = this.clock.shown / this.clock.fps;
    const pixels = this.stage.canvas.height / (2 * Math.tan((this.stage.camera.fov * Math.PI) / 360));
    for (const actor of this.actors) {
      actor.update(seconds, this.#poseOptions(), this.stage.camera, this.stage.theme, pixels);
    }
    const picked = this.actors[this.options.selected] ?? this.actors[0];
    if (picked) this.pins.object.position.copy(picked.object.position);
    this.pins.order(this.stage.camera);
    this.tools.update();
  }

  /** What the camera follows: the middle of the figures while they stay together, the picked one as they part. */
  get subject() {
    const roots = this.actors.map(({ root }) => root);
    if (!roots.length) return new Vector3(0, 0.9, 0);
    const middle = roots.reduce((sum, root) => sum.add(root), new Vector3()).divideScalar(roots.length);
    if (this.together) return middle;
    const spread = Math.max(...roots.map(({ x, z }) => Math.hypot(x - middle.x, z - middle.z)));
    return middle.lerp(roots[this.options.selected] ?? roots[0], MathUtils.smoothstep(spread - this.begun, 0, DRIFT));
  }

  // ---- camera and picking -------------------------------------------------------------------------

  // After the option `camera` changed: orbit leaves the picture as it is, follow turns to the subject.
  #aim() {
    const { camera } = this.options;
    if (camera === "follow") this.cameraman.tracking = true;
    if (camera === "orbit") this.cameraman.tracking = false;
    this.cameraman.subject.copy(this.subject);
    if (!this.cameraman.bounds) return;
    if (camera === "follow") this.cameraman.turnToSubject();
    else if (camera !== "orbit") this.cameraman.look(camera);
  }

  // After what there is to see changed.
  #reframe({ glide = true, home = false } = {}) {
    const { camera } = this.options;
    this.cameraman.subject.copy(this.subject);
    if (!this.cameraman.bounds) return;
    if (camera !== "orbit" && camera !== "follow") this.cameraman.look(camera, { glide });
    else if (home) this.cameraman.home(glide);
    else this.cameraman.frame(null, null, { glide });
  }

  // A fixed view that is turned by hand is an orbit (or a follow) from then on, wherever it was left.
  #handOnCamera() {
    const { camera } = this.options;
    if (camera === "orbit" || camera === "follow") return;
    this.options.camera = this.cameraman.tracking ? "follow" : "orbit";
    this.dispatchEvent(new CustomEvent("option", { detail: { name: "camera", value: this.options.camera } }));
  }

  /** Following on or off, whatever the view. */
  toggleFollow() {
    const { cameraman, options } = this;
    if (options.camera === "orbit" || options.camera === "follow") {
      this.set("camera", options.camera === "follow" ? "orbit" : "follow");
      return;
    }
    cameraman.tracking = !cameraman.tracking;
    this.#reframe();
    this.dispatchEvent(new CustomEvent("option", { detail: { name: "camera", value: options.camera } }));
  }

  /** The three-quarter view of everything. */
  resetView() {
    this.#option("camera", this.cameraman.tracking ? "follow" : "orbit");
    this.cameraman.home();
  }

  nudgeCamera(around, up, zoom) {
    this.#handOnCamera();
    this.cameraman.nudge(around, up, zoom);
  }

  /** Index of the figure at a point of the canvas (0..1 from its top left), or -1. */
  figureAt(x, y) {
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(x * 2 - 1, 1 - y * 2), this.stage.camera);
    let best = -1;
    let nearest = Infinity;
    this.actors.forEach((actor, i) => {
      const away = actor.hit(caster.ray);
      if (away !== null && away < nearest) [best, nearest] = [i, away];
    });
    return best;
  }

  hover(index) {
    if (index === this.hovered) return;
    this.hovered = index;
    this.#restyle();
  }

  // ---- the rest -----------------------------------------------------------------------------------

  #announce(type) {
    this.dispatchEvent(new CustomEvent(type));
  }

  /** The picture as it is now, as a PNG blob. */
  async picture() {
    await this.geometry?.arrived;
    this.stage.refine();
    if (this.geometry) this.geometry.rough = false;
    this.#pose();
    return this.stage.picture();
  }

  dispose() {
    this.actors.forEach((actor) => actor.dispose());
    this.geometry?.dispose();
    this.pins.dispose();
    this.tools.dispose();
    this.cameraman.dispose();
    this.stage.dispose();
  }
}
