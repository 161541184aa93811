// What the mouse draws on the stage: a path on the floor, a joint's place. The tool in hand is the option `tool`.
import { Group, Mesh, MeshBasicMaterial, Plane, Raycaster, SphereGeometry, Vector2, Vector3 } from "three";

const SHORTEST = 0.3; // metres; a shorter line is not meant
const STEP = 0.12; // metres between the points of a line
const FARTHEST = 25; // metres from the picked figure
const REACH = 18; // pixels from a joint within which it is taken hold of
const DOT = 0.016;

/** Listens on the canvas before the camera does; `player` gets "drawn" {kind, ...} and "say" {text}. */
export class Tools {
  constructor(player, canvas) {
    this.player = player;
    this.canvas = canvas;
    this.dots = new Group();
    this.dots.visible = false;
    this.material = new MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.9, toneMapped: false });
    this.ball = new SphereGeometry(DOT, 12, 8);
    this.held = null;
    this.over = -1;
    this.points = null;
    this.undo = [];
    for (const [name, react] of Object.entries({ pointerdown: this.#down, pointermove: this.#move, pointerup: this.#up, pointercancel: this.#drop })) {
      const listener = react.bind(this);
      canvas.addEventListener(name, listener, { capture: true });
      this.undo.push(() => canvas.removeEventListener(name, listener, { capture: true }));
    }
  }

  get tool() {
    return this.player.options.tool;
  }

  get figure() {
    const { actors, options } = this.player;
    return actors[options.selected] ?? actors[0] ?? null;
  }

  /** After another tool was taken in hand, or another figure picked. */
  refresh() {
    const inHand = `${this.tool} ${this.player.options.selected}`;
    if (inHand !== this.inHand) this.#drop();
    this.inHand = inHand;
    this.canvas.style.cursor = this.tool === "path" ? "crosshair" : "";
    this.dots.visible = this.tool === "joint" && this.figure !== null;
    const wanted = this.dots.visible ? this.figure.take.skeleton.joints.length : 0;
    while (this.dots.children.length < wanted) {
      const dot = new Mesh(this.ball, this.material);
      dot.renderOrder = 60;
      this.dots.add(dot);
    }
    this.dots.children.forEach((dot, j) => { dot.visible = j > 0 && j < wanted; }); // the root is led by the path
    this.material.color.set(this.player.stage.theme.pin);
  }

  /** Dots follow the joints. */
  update() {
    if (!this.dots.visible || !this.figure) return;
    const spot = new Vector3();
    this.dots.children.forEach((dot, j) => {
      if (!dot.visible) return;
      dot.position.copy(this.#joint(j, spot));
      dot.scale.setScalar(j === this.over || j === this.held?.joint ? 2 : 1);
    });
  }

  #joint(j, out) {
    return out.fromArray(this.figure.pose.places, j * 3).add(this.figure.object.position);
  }

  // ---- pointer ------------------------------------------------------------------------------------

  #down(event) {
    if (event.button !== 0 || this.tool === "none" || !this.figure) return;
    if (this.tool === "joint") {
      const joint = this.#near(event);
      if (joint < 0) return; // the camera's, or another figure's
      this.held = { joint, plane: this.#facing(this.#joint(joint, new Vector3())), spot: this.#joint(joint, new Vector3()) };
      this.#show();
    } else {
      const first = this.#floor(event);
      this.points = first ? [first] : [];
    }
    event.stopImmediatePropagation();
    event.preventDefault();
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
  }

  #move(event) {
    if (this.points) this.#extend(event);
    else if (this.held) this.#carry(event);
    else if (this.tool === "joint" && !event.buttons) {
      const over = this.#near(event);
      if (over !== this.over) this.#say(over >= 0 ? `${this.#nameOf(over)}: drag it to its place, or click to keep it here.` : null);
      this.over = over;
      this.canvas.style.cursor = this.over >= 0 ? "move" : "";
      this.player.stage.invalidate();
      if (this.over < 0) return;
    } else return;
    event.stopImmediatePropagation();
  }

  #up(event) {
    if (!this.points && !this.held) return;
    event.stopImmediatePropagation();
    const { points, held } = this;
    this.#drop();
    if (points) this.#finish(points);
    else {
      const at = this.#inPlace(held.spot);
      const joint = this.figure.take.skeleton.joints[held.joint];
      this.#tell({ kind: "joint", joint, place: at.map(rounded), frame: this.player.frame, fps: this.player.clock.fps });
    }
  }

  #drop() {
    this.points = this.held = null;
    this.over = -1;
    const { pins } = this.player;
    pins.draft.set([]);
    pins.handle.object.visible = false;
    this.player.stage.invalidate();
  }

  // ---- a path -------------------------------------------------------------------------------------

  #extend(event) {
    const next = this.#floor(event);
    const last = this.points.at(-1);
    if (!next || (last && Math.hypot(next[0] - last[0], next[1] - last[1]) < 0.02)) return;
    this.points.push(next);
    this.player.pins.draft.set(this.points);
    this.player.stage.invalidate();
  }

  #finish(points) {
    const line = evened(steadied(points));
    if (lengthOf(line) < SHORTEST) {
      this.#say("That was too short: press, drag along the floor, release.");
      return;
    }
    this.#tell({ kind: "path", points: line.map((point) => point.map(rounded)) });
    this.player.set("tool", "none");
  }

  // ---- geometry -----------------------------------------------------------------------------------

  #ray(event) {
    const box = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    const x = ((event.clientX - box.left) / box.width) * 2 - 1;
    caster.setFromCamera(new Vector2(x, 1 - ((event.clientY - box.top) / box.height) * 2), this.player.stage.camera);
    return caster.ray;
  }

  // [x, z] in the picked figure's place, or null above the horizon and far away.
  #floor(event) {
    const hit = this.#ray(event).intersectPlane(new Plane(new Vector3(0, 1, 0), 0), new Vector3());
    if (!hit) return null;
    const [x, , z] = this.#inPlace(hit);
    return Math.hypot(x, z) <= FARTHEST ? [x, z] : null;
  }

  #inPlace(world) {
    return world.clone().sub(this.figure.object.position).toArray();
  }

  #facing(point) {
    const away = this.player.stage.camera.getWorldDirection(new Vector3());
    return new Plane().setFromNormalAndCoplanarPoint(away, point);
  }

  #carry(event) {
    const hit = this.#ray(event).intersectPlane(this.held.plane, new Vector3());
    if (!hit) return;
    this.held.spot.copy(hit).setY(Math.max(hit.y, 0));
    this.#show();
  }

  #show() {
    this.player.pins.handle.set(this.#inPlace(this.held.spot));
    this.player.stage.invalidate();
  }

  #near(event) {
    const box = this.canvas.getBoundingClientRect();
    const spot = new Vector3();
    let best = -1;
    let nearest = REACH;
    for (let j = 1; j < (this.figure?.take.skeleton.joints.length ?? 0); j++) {
      this.#joint(j, spot).project(this.player.stage.camera);
      const x = box.left + ((spot.x + 1) / 2) * box.width;
      const y = box.top + ((1 - spot.y) / 2) * box.height;
      const away = Math.hypot(event.clientX - x, event.clientY - y);
      if (spot.z < 1 && away < nearest) [best, nearest] = [j, away];
    }
    return best;
  }

  #tell(detail) {
    this.player.dispatchEvent(new CustomEvent("drawn", { detail }));
  }

  #nameOf(j) {
    const name = this.figure.take.skeleton.joints[j].replaceAll("_", " ");
    return name[0].toUpperCase() + name.slice(1);
  }

  // A line over the stage; null: what it said at first.
  #say(text) {
    this.player.dispatchEvent(new CustomEvent("say", { detail: { text } }));
  }

  dispose() {
    this.undo.forEach((step) => step());
    this.material.dispose();
    this.ball.dispose();
  }
}

const rounded = (value) => Math.round(value * 1000) / 1000;

function lengthOf(points) {
  return points.slice(1).reduce((sum, [x, z], i) => sum + Math.hypot(x - points[i][0], z - points[i][1]), 0);
}

/** A hand's tremble taken out; the ends stay. */
function steadied(points) {
  return points.map((point, i) => {
    const reach = Math.min(2, i, points.length - 1 - i);
    const around = points.slice(i - reach, i + reach + 1);
    return [0, 1].map((axis) => around.reduce((sum, spot) => sum + spot[axis], 0) / around.length);
  });
}

/** Points at even steps along a line, its ends included. */
function evened(points) {
  const length = lengthOf(points);
  const count = Math.max(1, Math.ceil(length / STEP));
  const out = [];
  let walked = 0;
  for (let i = 0; i + 1 < points.length; i++) {
    const [[ax, az], [bx, bz]] = [points[i], points[i + 1]];
    const piece = Math.hypot(bx - ax, bz - az);
    while (piece > 0 && out.length <= count && (out.length * length) / count <= walked + piece + 1e-9) {
      const share = ((out.length * length) / count - walked) / piece;
      out.push([ax + (bx - ax) * share, az + (bz - az) * share]);
    }
    walked += piece;
  }
  return out;
}
