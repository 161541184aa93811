// What is pinned of the motion to come: a line on the floor, poses, places of joints.
import { BufferAttribute, BufferGeometry, Group, Mesh, MeshBasicMaterial, RingGeometry, SphereGeometry } from "three";
import { Ghost } from "./ghosts.js";
import { Pose } from "./pose.js";

const WIDTH = 0.045; // metres, of the line
const LIFT = 0.014; // metres above the floor
const BALL = 0.034;
const OPACITY = 0.5;

/** The line, flat on the floor, with a dot where it starts and an arrow head where it ends. */
class Line {
  constructor() {
    this.material = new MeshBasicMaterial({ transparent: true, opacity: 0.95, depthWrite: false, toneMapped: false, side: 2 });
    this.object = new Mesh(new BufferGeometry(), this.material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -5;
    this.points = [];
  }

  set(points) {
    this.points = points;
    this.object.geometry.dispose();
    this.object.geometry = new BufferGeometry();
    this.object.visible = points.length > 1;
    if (!this.object.visible) return;
    const spots = ribbon(points);
    this.object.geometry.setAttribute("position", new BufferAttribute(new Float32Array(spots.flat()), 3));
  }

  dispose() {
    this.object.geometry.dispose();
    this.material.dispose();
  }
}

/** Triangles (corner after corner) of a line over [x, z] points. */
function ribbon(points) {
  const sides = points.map((_, i) => {
    const [ax, az] = points[Math.max(i - 1, 0)];
    const [bx, bz] = points[Math.min(i + 1, points.length - 1)];
    const length = Math.hypot(bx - ax, bz - az) || 1;
    return [-(bz - az) / length, (bx - ax) / length];
  });
  const at = (i, by) => [points[i][0] + sides[i][0] * by, LIFT, points[i][1] + sides[i][1] * by];
  const out = [];
  for (let i = 0; i + 1 < points.length; i++) {
    out.push(at(i, -WIDTH / 2), at(i, WIDTH / 2), at(i + 1, WIDTH / 2), at(i, -WIDTH / 2), at(i + 1, WIDTH / 2), at(i + 1, -WIDTH / 2));
  }
  const last = points.length - 1;
  const [sx, sz] = sides[last];
  const tip = [points[last][0] + sz * 0.16, LIFT, points[last][1] - sx * 0.16];
  out.push(at(last, -0.08), at(last, 0.08), tip);
  const [x, z] = points[0];
  for (let k = 0; k < 20; k++) {
    const [a, b] = [k, k + 1].map((step) => (step / 20) * Math.PI * 2);
    out.push([x, LIFT, z], [x + 0.07 * Math.cos(a), LIFT, z + 0.07 * Math.sin(a)], [x + 0.07 * Math.cos(b), LIFT, z + 0.07 * Math.sin(b)]);
  }
  return out;
}

/** A joint's place: a ball, a thin stalk down to the floor and a ring where it stands. */
class Ball {
  constructor() {
    this.material = new MeshBasicMaterial({ transparent: true, toneMapped: false });
    this.faint = new MeshBasicMaterial({ transparent: true, opacity: 0.55, toneMapped: false, side: 2 });
    this.ball = new Mesh(new SphereGeometry(BALL, 20, 14), this.material);
    this.stalk = new Mesh(new BufferGeometry(), this.faint);
    this.ring = new Mesh(new RingGeometry(0.03, 0.045, 24).rotateX(-Math.PI / 2), this.faint);
    this.object = new Group();
    this.object.add(this.ball, this.stalk, this.ring);
    this.stalk.frustumCulled = false;
  }

  set([x, y, z]) {
    this.ball.position.set(x, y, z);
    this.ring.position.set(x, LIFT, z);
    const w = 0.004;
    const corners = [[-w, 0], [w, 0], [0, -w], [0, w]].map(([dx, dz]) => [x + dx, z + dz]);
    const spots = [];
    for (const [[ax, az], [bx, bz]] of [[corners[0], corners[1]], [corners[2], corners[3]]]) {
      spots.push(ax, 0, az, bx, 0, bz, bx, y, bz, ax, 0, az, bx, y, bz, ax, y, az);
    }
    this.stalk.geometry.setAttribute("position", new BufferAttribute(new Float32Array(spots), 3));
    this.object.visible = true;
  }

  paint(css) {
    for (const material of [this.material, this.faint]) material.color.set(css);
  }

  dispose() {
    for (const mesh of [this.ball, this.stalk, this.ring]) mesh.geometry.dispose();
    this.material.dispose();
    this.faint.dispose();
  }
}

/** Everything pinned, drawn in the place of the picked figure. */
export class Pins {
  constructor() {
    this.object = new Group();
    this.line = new Line();
    this.draft = new Line(); // while the mouse draws it
    this.handle = new Ball(); // while the mouse holds it
    this.handle.object.visible = this.draft.object.visible = false;
    this.balls = [];
    this.ghosts = [];
    this.rings = [];
    this.object.add(this.line.object, this.draft.object, this.handle.object);
    this.data = { path: [], poses: [], joints: [], stretches: [], fps: 20 };
  }

  /** What Python sends: path [[x, z]], poses [{frame, rotations wxyz, root}], joints [{joint, frame, place}]. */
  set(data, skeleton, body) {
    this.data = { path: [], poses: [], joints: [], stretches: [], fps: 20, ...data };
    this.#takeDown();
    this.line.set(this.data.path.map(([x, z]) => [x, z]));
    for (const { place } of this.data.joints) {
      const ball = new Ball();
      ball.set(place);
      this.balls.push(ball);
      this.object.add(ball.object);
    }
    for (const pose of this.data.poses) this.#pose(pose, skeleton, body);
    this.paint(this.theme);
  }

  #pose({ rotations, root }, skeleton, body) {
    if (!skeleton || rotations.length !== skeleton.joints.length * 4) return;
    const turns = Float32Array.from(rotations, (_, i) => rotations[i - (i % 4) + ((i + 1) % 4)]); // wxyz -> xyzw
    const take = { skeleton, rotations: turns, path: Float32Array.from(root), frames: 1, colour: "#888888" };
    const ghost = new Ghost(take, body);
    ghost.pinned = new Pose(skeleton).sample(take, 0);
    // a figure in that very pose is seen, not its ghost
    for (const mesh of ghost.skin ? [ghost.depth, ghost.colour] : []) {
      Object.assign(mesh.material, { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 });
    }
    const ring = new Mesh(new RingGeometry(0.3, 0.33, 48).rotateX(-Math.PI / 2), new MeshBasicMaterial({ transparent: true, opacity: 0.9, depthWrite: false, toneMapped: false }));
    ring.position.set(root[0], LIFT, root[2]);
    ring.renderOrder = -6;
    this.ghosts.push(ghost);
    this.rings.push(ring);
    this.object.add(ghost.object, ring);
  }

  paint(theme) {
    if (!theme) return;
    this.theme = theme;
    for (const part of [this.handle, ...this.balls]) part.paint(theme.pin);
    for (const { material } of [this.line, this.draft, ...this.rings]) material.color.set(theme.pin);
    for (const ghost of this.ghosts) {
      ghost.show(ghost.pinned, ghost.skin ? "body" : "skeleton", theme.pin, { ...theme, ghost: theme.pin });
      ghost.fade(OPACITY);
    }
  }

  /** Far ghosts first, as each writes depth. */
  order(camera) {
    const here = this.object.worldToLocal(camera.position.clone());
    [...this.ghosts].sort((a, b) => b.root.distanceToSquared(here) - a.root.distanceToSquared(here)).forEach((ghost, i) => ghost.order(40 + 2 * i));
  }

  #takeDown() {
    for (const part of [...this.balls, ...this.ghosts]) {
      this.object.remove(part.object);
      part.dispose();
    }
    for (const ring of this.rings) {
      this.object.remove(ring);
      ring.geometry.dispose();
      ring.material.dispose();
    }
    this.balls = [];
    this.ghosts = [];
    this.rings = [];
  }

  dispose() {
    this.#takeDown();
    for (const part of [this.line, this.draft, this.handle]) part.dispose();
  }
}
