// The camera: orbit by hand, fixed views, following the picked figure, framing what there is.
import { MathUtils, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export const VIEWS = ["orbit", "follow", "front", "back", "left", "right"];
const ANGLES = { front: 0, left: 90, back: 180, right: 270 };
const HOME = { azimuth: 24, polar: 80 };
const FIXED_POLAR = 85;
const GLIDE = 0.45; // seconds
const BODY_MIDDLE = 0.86;
const BODY_REACH = 1.2; // half the height that must fit, arms raised
const ARMS = 0.75; // half the width of a figure
const FARTHEST = 1.3; // times the distance for following; a way that needs more is followed instead
const FOLLOWING = 1.15; // times that distance while following, for the trail and the ghosts

export class Cameraman {
  /** `changed()` asks for a picture; `taken()` tells that a hand moved the camera. */
  constructor(camera, element, { changed, taken }) {
    this.camera = camera;
    this.controls = new OrbitControls(camera, element);
    Object.assign(this.controls, {
      enableDamping: false, minDistance: 0.7, maxDistance: 60, maxPolarAngle: Math.PI * 0.53, zoomSpeed: 0.8, rotateSpeed: 0.75,
    });
    this.element = element;
    this.controls.target.set(0, BODY_MIDDLE, 0);
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => { this.glide = null; taken(); });
    this.changed = changed;
    this.tracking = false;
    this.glide = null;
    this.calm = globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? false;
    this.subject = new Vector3();
    this.bounds = null;
    this.spread = 0;
    this.#place(new Vector3(0, BODY_MIDDLE, 0), spherical(HOME.azimuth, HOME.polar, 5));
  }

  /**
   * What must be in the picture: the floor rectangle that all figures walk over, and how far (metres) they are from
   * the subject while it is followed.
   */
  cover(bounds, spread) {
    this.bounds = bounds;
    this.spread = spread;
  }

  get tooLong() {
    return this.#staticFit(MathUtils.degToRad(this.#homeAzimuth)).distance > FARTHEST * this.#followFit().distance;
  }

  // A long row of figures is seen more from the front, or those at its near end would hide the others.
  get #homeAzimuth() {
    const row = this.bounds ? this.bounds.maxX - this.bounds.minX : 0;
    return HOME.azimuth * MathUtils.clamp(2 - row / 2.5, 0, 1);
  }

  /** Frames the whole way seen from `azimuth` (degrees from the front), or those followed. */
  frame(azimuth = null, polar = null, { glide = true } = {}) {
    const now = this.#arm();
    const theta = azimuth === null ? MathUtils.radToDeg(now.theta) : azimuth;
    const phi = polar === null ? MathUtils.radToDeg(now.phi) : polar;
    const { target, distance } = this.tracking ? this.#followFit() : this.#staticFit(MathUtils.degToRad(theta));
    this.#go(target, spherical(theta, phi, distance), glide && !this.calm);
  }

  /** Turns to the subject without changing angle or distance. */
  turnToSubject() {
    this.#go(this.#overSubject(), this.#arm(), !this.calm);
  }

  home(glide = true) {
    this.frame(this.#homeAzimuth, HOME.polar, { glide });
  }

  look(view, { glide = true } = {}) {
    if (view in ANGLES) this.frame(ANGLES[view], FIXED_POLAR, { glide });
  }

  #arm() {
    return new Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target));
  }

  #overSubject() {
    return new Vector3(this.subject.x, BODY_MIDDLE, this.subject.z);
  }

  // Half the picture's height and width at distance 1.
  get #half() {
    const tall = Math.tan(MathUtils.degToRad(this.camera.fov / 2));
    return { tall, wide: tall * this.camera.aspect };
  }

  // Distance at which one figure fills the picture.
  get #alone() {
    return Math.max(BODY_REACH / this.#half.tall, ARMS / this.#half.wide);
  }

  #followFit() {
    const distance = Math.max(this.#alone * FOLLOWING, (this.spread + ARMS) / this.#half.wide);
    return { target: this.#overSubject(), distance };
  }

  #staticFit(theta) {
    const { minX, maxX, minZ, maxZ } = this.bounds;
    const halfX = (maxX - minX) / 2;
    const halfZ = (maxZ - minZ) / 2;
    // extent of the floor rectangle across the view and towards it
    const across = Math.abs(halfX * Math.cos(theta)) + Math.abs(halfZ * Math.sin(theta));
    const towards = Math.abs(halfX * Math.sin(theta)) + Math.abs(halfZ * Math.cos(theta));
    const distance = Math.max(this.#alone, (across + ARMS) / this.#half.wide) + towards;
    return { target: new Vector3((minX + maxX) / 2, BODY_MIDDLE, (minZ + maxZ) / 2), distance };
  }

  #go(target, arm, glide) {
    if (!glide) {
      this.glide = null;
      this.#place(target, arm);
      return;
    }
    const from = this.#arm();
    const turn = ((arm.theta - from.theta + Math.PI * 3) % (Math.PI * 2)) - Math.PI; // the short way round
    this.glide = { time: 0, fromTarget: this.controls.target.clone(), target, from, arm, turn };
    this.changed();
  }

  #place(target, arm) {
    this.controls.target.copy(target);
    this.camera.position.setFromSpherical(arm).add(target);
    this.controls.update();
    this.changed();
  }

  /** Moves on by `elapsed` seconds (0: jump to where it should be); true while there is more to come. */
  update(elapsed, subject) {
    this.subject.copy(subject);
    if (this.glide) return this.#glideOn(elapsed);
    return this.tracking && this.#track(elapsed);
  }

  #glideOn(elapsed) {
    const { glide } = this;
    glide.time = Math.min(glide.time + (elapsed || 1 / 60) / GLIDE, 1);
    const s = glide.time * glide.time * (3 - 2 * glide.time);
    const target = glide.fromTarget.clone().lerp(glide.target, s);
    const arm = new Spherical(
      MathUtils.lerp(glide.from.radius, glide.arm.radius, s),
      MathUtils.lerp(glide.from.phi, glide.arm.phi, s),
      glide.from.theta + glide.turn * s,
    );
    if (this.tracking) glide.target.copy(this.#overSubject());
    if (glide.time >= 1) this.glide = null;
    this.#place(target, arm);
    return this.glide !== null;
  }

  // A little behind the figure, as a camera operator is: steps and sway do not shake the picture.
  #track(elapsed) {
    const gap = new Vector3(this.subject.x, 0, this.subject.z).sub(this.controls.target).setY(0);
    const share = elapsed ? 1 - Math.exp(-elapsed * 6) : 1;
    this.#carry(gap.clone().multiplyScalar(share));
    return gap.length() * (1 - share) > 1e-3;
  }

  #carry(by) {
    if (by.lengthSq() < 1e-12) return;
    this.controls.target.add(by);
    this.camera.position.add(by);
    this.controls.update();
  }

  /** Turns by hand from the keyboard: degrees around and up, and a zoom factor. */
  nudge(around, up, zoom = 1) {
    this.glide = null;
    const arm = this.#arm();
    arm.theta += MathUtils.degToRad(around);
    arm.phi = MathUtils.clamp(arm.phi - MathUtils.degToRad(up), 0.05, this.controls.maxPolarAngle);
    arm.radius = MathUtils.clamp(arm.radius * zoom, this.controls.minDistance, this.controls.maxDistance);
    this.#place(this.controls.target.clone(), arm);
  }

  dispose() {
    this.controls.dispose();
  }
}

function spherical(azimuth, polar, distance) {
  return new Spherical(distance, MathUtils.degToRad(polar), MathUtils.degToRad(azimuth));
}
