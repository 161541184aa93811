// One take on the stage: its body, its bones, its marks on the floor and its ghosts.
import { Group, Vector3 } from "three";
import { Bones } from "./bones.js";
import { Ghosts } from "./ghosts.js";
import { ContactRings, ContactShadows, Trail } from "./marks.js";
import { Pose } from "./pose.js";
import { setRaw } from "./backdrop.js";
import { Skin, bodyMaterial, depthMaterial, dyeBody, markStencil, outlineMaterial } from "./skin.js";

const XRAY = 0.32; // opacity of a body with its bones inside
const BEHIND = 0.42; // opacity of those not picked where figures stand in one place

export class Actor {
  /** `body` is the geometry to wear, or null for bones alone; a crowd wears it coarser. */
  constructor(take, body, crowd) {
    this.take = take;
    this.pose = new Pose(take.skeleton);
    this.object = new Group();
    this.bones = new Bones(take.skeleton);
    this.shadows = new ContactShadows(take.skeleton);
    this.rings = new ContactRings(take.skeleton);
    this.trail = new Trail(take);
    this.ghosts = new Ghosts(take, body);
    this.parts = [this.bones, this.shadows, this.rings, this.trail, this.ghosts];
    if (body) this.#dress(body, crowd);
    this.object.add(...this.parts.map((part) => part.object));
    this.root = new Vector3();
    this.centre = new Vector3();
  }

  #dress(body, crowd) {
    this.skin = new Skin(body, this.take.skeleton, crowd ? 1 : 0);
    this.material = bodyMaterial(body);
    this.solid = this.skin.mesh(this.material, 3);
    this.depth = this.skin.mesh(depthMaterial(), 2);
    this.depth.material.transparent = true;
    this.outline = this.skin.mesh(outlineMaterial(), 4);
    this.solid.castShadow = true;
    this.solid.receiveShadow = true;
    this.object.add(this.solid, this.depth, this.outline);
  }

  /** Body, skeleton or both; `both` makes the body translucent so that the bones inside are seen. */
  style({ show, selected, hovered, several, overlaid, trail, contacts, ghosts, inPlace }, theme) {
    const dressed = Boolean(this.skin) && show !== "skeleton";
    const xray = dressed && show === "both";
    const marked = several && (selected || hovered);
    const faint = overlaid && !selected;
    this.bones.object.visible = !dressed || xray;
    this.bones.paint(this.take.colour, theme.joint, several && selected ? 0.35 : 0.08);
    this.bones.fade(faint ? BEHIND : 1);
    if (this.skin) {
      this.solid.visible = dressed;
      this.solid.castShadow = !faint; // of figures in one place only the picked one's shadow is told apart
      this.depth.visible = dressed && (xray || faint);
      this.outline.visible = dressed && marked;
      this.material.transparent = xray || faint;
      this.material.opacity = xray ? XRAY : faint ? BEHIND : 1;
      // figures in one place: the picked one's surface wins where they coincide
      for (const material of [this.material, this.depth.material]) {
        Object.assign(material, { polygonOffset: faint, polygonOffsetFactor: 2, polygonOffsetUnits: 2 });
      }
      markStencil(this.material, marked);
      this.outline.material.uniforms.width.value = selected ? 0.0058 : 0.0035;
      setRaw(this.outline.material.uniforms.colour.value, theme.accent);
      dyeBody(this.material, this.take.colour, theme);
    }
    this.trail.object.visible = trail && !inPlace;
    this.trail.paint(selected || !several ? theme.accent : this.take.colour);
    this.shadows.object.visible = !faint;
    this.rings.object.visible = contacts && !faint;
    this.rings.paint(theme.contact);
    this.ghosts.object.visible = ghosts > 0 && (selected || !several);
  }

  /** Poses the figure at `seconds` of the common clock; a take that is over keeps its last pose. */
  update(seconds, options, camera, theme, pixels) {
    const frame = Math.min(seconds * this.take.fps, this.take.frames - 1);
    const { mirror, inPlace } = options;
    const pose = this.pose.sample(this.take, frame, options);
    this.root.fromArray(pose.places).add(this.object.position);
    if (this.bones.object.visible) this.bones.wear(pose);
    if (this.skin && this.solid.visible) this.skin.wear(pose);
    if (this.outline?.visible) this.outline.material.uniforms.aspect.value = camera.aspect;
    this.shadows.wear(pose);
    if (this.rings.object.visible) this.rings.wear(pose, this.take, Math.round(frame), mirror);
    if (this.trail.object.visible) this.trail.update(frame, pixels, mirror);
    if (this.ghosts.object.visible) {
      this.ghosts.update(frame, { every: options.ghosts, show: options.show, mirror, inPlace }, camera, theme);
    }
  }

  /** Distance along a ray at which it passes within reach of a bone, or null. */
  hit(ray, reach = 0.11) {
    let nearest = null;
    const a = new Vector3(), b = new Vector3(), onRay = new Vector3();
    for (const { joint, child, end } of this.bones.segments) {
      a.fromArray(this.pose.places, joint * 3).add(this.object.position);
      if (end) b.fromArray(this.pose.tip(joint, end, [0, 0, 0])).add(this.object.position);
      else b.fromArray(this.pose.places, child * 3).add(this.object.position);
      if (ray.distanceSqToSegment(a, b, onRay) > reach * reach) continue;
      const away = onRay.distanceTo(ray.origin);
      if (nearest === null || away < nearest) nearest = away;
    }
    return nearest;
  }

  /** Where the label goes: on the floor under the hips. */
  foot(out) {
    return out.set(this.root.x, 0, this.root.z);
  }

  dispose() {
    this.skin?.dispose();
    this.parts.forEach((part) => part.dispose());
  }
}
