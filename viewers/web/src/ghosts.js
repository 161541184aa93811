// Onion skin: the same figure every k frames, fading with distance in time from the playhead.
import { Group, Vector3 } from "three";
import { Bones } from "./bones.js";
import { tintAt, tintsOf } from "./hues.js";
import { Pose } from "./pose.js";
import { Skin, depthMaterial, dyeBody, ghostMaterial } from "./skin.js";

const PAST = 6;
const OPACITY = 0.5;

/** Ghost frames before `frame`, nearest first: multiples of `every`, at most `PAST`. */
export function ghostFrames(frame, every, frames) {
  const found = [];
  if (every < 1) return found;
  const nearest = Math.ceil(Math.min(frame, frames - 1) / every) - 1;
  for (let n = nearest; n >= 0 && found.length < PAST; n--) found.push(n * every);
  return found;
}

export class Ghosts {
  constructor(take, body) {
    this.take = take;
    this.body = body;
    this.pose = new Pose(take.skeleton);
    this.tints = tintsOf(take);
    this.pool = [];
    this.object = new Group();
    this.shown = "";
    this.theme = null;
  }

  /** Shows the ghosts that belong to `frame`; cheap when they are the same as before. */
  update(frame, { every, show, mirror, inPlace }, camera, theme) {
    const frames = ghostFrames(frame, every, this.take.frames);
    const style = show === "skeleton" || !this.body ? "skeleton" : "body";
    const wanted = `${frames}|${style}|${mirror}|${inPlace}`;
    if (wanted !== this.shown || theme !== this.theme) {
      this.shown = wanted;
      this.theme = theme;
      this.pool.forEach((ghost) => ghost.hide());
      frames.forEach((at, i) => {
        const ghost = (this.pool[i] ??= this.#make());
        ghost.show(this.pose.sample(this.take, at, { mirror, inPlace }), style, this.take.colour, theme, tintAt(this.tints, at));
      });
    }
    frames.forEach((at, i) => this.pool[i].fade(fading(frame - at, every)));
    this.#order(camera, frames.length);
  }

  // Far ghosts first: each writes depth before colour, so a near one drawn first would cut out those behind.
  #order(camera, count) {
    const here = this.object.worldToLocal(camera.position.clone());
    this.pool.slice(0, count)
      .sort((a, b) => b.root.distanceToSquared(here) - a.root.distanceToSquared(here))
      .forEach((ghost, i) => ghost.order(10 + 2 * i));
  }

  #make() {
    const ghost = new Ghost(this.take, this.body);
    this.object.add(ghost.object);
    return ghost;
  }

  dispose() {
    this.pool.forEach((ghost) => ghost.dispose());
  }
}

function fading(age, every) {
  const steps = age / every;
  return OPACITY * Math.min(steps, 1) * Math.max(0.12, 1 - steps / (PAST + 1));
}

/** One figure standing still, translucent. */
export class Ghost {
  constructor(take, body) {
    this.object = new Group();
    this.root = new Vector3();
    this.take = take;
    if (body) {
      this.skin = new Skin(body, take.skeleton, 1);
      this.material = ghostMaterial();
      this.depth = this.skin.mesh(depthMaterial());
      this.depth.material.transparent = true; // in the same queue as the colour pass, just before it
      this.colour = this.skin.mesh(this.material);
      this.object.add(this.depth, this.colour);
    }
  }

  /** In a pose; `tint` is the colour of what is done there, if a take does several things. */
  show(pose, style, css, theme, tint = null) {
    this.object.visible = true;
    this.root.fromArray(pose.places);
    if (this.skin) this.depth.visible = this.colour.visible = style === "body";
    if (style === "body") {
      this.skin.wear(pose);
      dyeBody(this.material, tint ?? theme.ghost, theme);
    } else {
      if (!this.bones) this.object.add((this.bones = new Bones(this.take.skeleton)).object);
      this.bones.wear(pose);
      this.bones.paint(tint ?? css, theme.joint);
    }
    if (this.bones) this.bones.object.visible = style === "skeleton";
  }

  fade(opacity) {
    if (this.material) this.material.opacity = opacity;
    this.bones?.fade(opacity);
  }

  order(value) {
    if (this.skin) {
      this.depth.renderOrder = value;
      this.colour.renderOrder = value + 1;
    }
  }

  hide() {
    this.object.visible = false;
  }

  dispose() {
    this.skin?.dispose();
    this.bones?.dispose();
  }
}
