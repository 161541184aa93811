// From a take and a time to joint positions, joint rotations and skinning matrices.
import { Quaternion } from "three";

/** Pose of one body: global rotations xyzw and joint positions, both flat and reused from call to call. */
export class Pose {
  constructor(skeleton) {
    this.skeleton = skeleton;
    const joints = skeleton.joints.length;
    this.local = new Float32Array(joints * 4);
    this.turns = new Float32Array(joints * 4);
    this.places = new Float32Array(joints * 3);
    this.offsets = Float32Array.from(skeleton.offsets.flat());
    this.root = new Float32Array(3);
  }

  /**
   * Samples a take at a frame number that may lie between frames: slerp for rotations, linear for the root.
   * `mirror` trades left and right about x = 0; `inPlace` keeps the root above its first place.
   */
  sample(take, frame, { mirror = false, inPlace = false } = {}) {
    const last = take.frames - 1;
    const at = Math.min(Math.max(frame, 0), last);
    const from = Math.floor(at);
    const to = Math.min(from + 1, last);
    this.#rotations(take, from, to, at - from, mirror);
    this.#root(take, from, to, at - from, mirror, inPlace);
    this.#chain();
    return this;
  }

  #rotations(take, from, to, amount, mirror) {
    const { local, skeleton } = this;
    const joints = skeleton.joints.length;
    for (let j = 0; j < joints; j++) {
      const source = mirror ? skeleton.mirror[j] : j;
      const a = (from * joints + source) * 4;
      const b = (to * joints + source) * 4;
      Quaternion.slerpFlat(local, j * 4, take.rotations, a, take.rotations, b, amount);
      if (mirror) {
        local[j * 4 + 1] *= -1;
        local[j * 4 + 2] *= -1;
      }
    }
  }

  #root(take, from, to, amount, mirror, inPlace) {
    const { root } = this;
    const { path } = take;
    for (let axis = 0; axis < 3; axis++) {
      const pinned = inPlace && axis !== 1;
      const a = path[(pinned ? 0 : from) * 3 + axis];
      const b = path[(pinned ? 0 : to) * 3 + axis];
      root[axis] = a + (b - a) * amount;
    }
    if (mirror) root[0] *= -1;
  }

  #chain() {
    const { local, turns, places, offsets, root } = this;
    const { parents } = this.skeleton;
    for (let j = 0; j < parents.length; j++) {
      const parent = parents[j];
      if (parent < 0) {
        turns.set(local.subarray(j * 4, j * 4 + 4), j * 4);
        for (let axis = 0; axis < 3; axis++) places[j * 3 + axis] = root[axis] + offsets[j * 3 + axis];
      } else {
        multiply(turns, j * 4, turns, parent * 4, local, j * 4);
        rotate(places, j * 3, turns, parent * 4, offsets, j * 3);
        for (let axis = 0; axis < 3; axis++) places[j * 3 + axis] += places[parent * 3 + axis];
      }
    }
  }

  /** Writes the position of the tip `end` (3,) of joint `joint` into `out`. */
  tip(joint, end, out) {
    rotate(out, 0, this.turns, joint * 4, end, 0);
    for (let axis = 0; axis < 3; axis++) out[axis] += this.places[joint * 3 + axis];
    return out;
  }
}

function multiply(out, o, a, i, b, k) {
  const ax = a[i], ay = a[i + 1], az = a[i + 2], aw = a[i + 3];
  const bx = b[k], by = b[k + 1], bz = b[k + 2], bw = b[k + 3];
  out[o] = aw * bx + ax * bw + ay * bz - az * by;
  out[o + 1] = aw * by - ax * bz + ay * bw + az * bx;
  out[o + 2] = aw * bz + ax * by - ay * bx + az * bw;
  out[o + 3] = aw * bw - ax * bx - ay * by - az * bz;
}

function rotate(out, o, q, i, v, k) {
  const x = q[i], y = q[i + 1], z = q[i + 2], w = q[i + 3];
  const vx = v[k], vy = v[k + 1], vz = v[k + 2];
  const tx = 2 * (y * vz - z * vy), ty = 2 * (z * vx - x * vz), tz = 2 * (x * vy - y * vx);
  out[o] = vx + w * tx + y * tz - z * ty;
  out[o + 1] = vy + w * ty + z * tx - x * tz;
  out[o + 2] = vz + w * tz + x * ty - y * tx;
}

/** Skinning matrices that carry a body's rest pose to a pose, stretching limbs where bone lengths differ. */
export class Binding {
  constructor(bodySkeleton, poseSkeleton) {
    this.rest = restPositions(bodySkeleton);
    this.stretch = boneStretch(bodySkeleton, poseSkeleton);
    this.joints = bodySkeleton.joints.length;
  }

  /** Column-major 4x4 matrices, one after the other, into `out`. */
  matrices(pose, out) {
    const m = new Float32Array(9);
    for (let j = 0; j < this.joints; j++) {
      rotationMatrix(m, pose.turns, j * 4);
      if (this.stretch[j]) multiply3(m, this.stretch[j]);
      const [x, y, z] = this.rest.subarray(j * 3, j * 3 + 3);
      const o = j * 16;
      for (let column = 0; column < 3; column++) {
        out[o + column * 4] = m[column];
        out[o + column * 4 + 1] = m[3 + column];
        out[o + column * 4 + 2] = m[6 + column];
        out[o + column * 4 + 3] = 0;
      }
      for (let row = 0; row < 3; row++) {
        out[o + 12 + row] = pose.places[j * 3 + row] - (m[row * 3] * x + m[row * 3 + 1] * y + m[row * 3 + 2] * z);
      }
      out[o + 15] = 1;
    }
    return out;
  }
}

export function restPositions(skeleton) {
  const places = Float32Array.from(skeleton.offsets.flat());
  skeleton.parents.forEach((parent, j) => {
    for (let axis = 0; axis < 3 && parent >= 0; axis++) places[j * 3 + axis] += places[parent * 3 + axis];
  });
  return places;
}

// As Body.fitted does it: along the bone to each joint's main child, thickness kept; null where lengths agree.
function boneStretch(body, pose) {
  const children = body.joints.map((_, j) => body.parents.flatMap((p, c) => (p === j ? [c] : [])));
  return children.map((own, j) => {
    if (!own.length) return null;
    const child = j === 0 ? own.reduce((a, b) => (Math.abs(body.offsets[b][1]) > Math.abs(body.offsets[a][1]) ? b : a)) : own[0];
    const length = Math.hypot(...body.offsets[child]);
    const factor = length > 1e-6 ? Math.hypot(...pose.offsets[child]) / length : 1;
    if (Math.abs(factor - 1) < 1e-5) return null;
    const along = body.offsets[child].map((value) => value / length);
    return along.flatMap((a, row) => along.map((b, column) => (row === column ? 1 : 0) + (factor - 1) * a * b));
  });
}

function rotationMatrix(m, q, i) {
  const x = q[i], y = q[i + 1], z = q[i + 2], w = q[i + 3];
  m[0] = 1 - 2 * (y * y + z * z); m[1] = 2 * (x * y - z * w); m[2] = 2 * (x * z + y * w);
  m[3] = 2 * (x * y + z * w); m[4] = 1 - 2 * (x * x + z * z); m[5] = 2 * (y * z - x * w);
  m[6] = 2 * (x * z - y * w); m[7] = 2 * (y * z + x * w); m[8] = 1 - 2 * (x * x + y * y);
}

function multiply3(m, s) {
  for (let row = 0; row < 3; row++) {
    const a = m[row * 3], b = m[row * 3 + 1], c = m[row * 3 + 2];
    for (let column = 0; column < 3; column++) m[row * 3 + column] = a * s[column] + b * s[3 + column] + c * s[6 + column];
  }
}
