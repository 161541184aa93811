// Renderer, scene, lights and the loop that draws only when something changed.
import {
  Color, DirectionalLight, HemisphereLight, NeutralToneMapping, PCFShadowMap, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "three";
import { Floor, gradientStyle, paintGradient } from "./backdrop.js";
import { THEMES } from "./theme.js";

const MAX_PIXEL_RATIO = 2;
const FINE_RATIO = 1.75; // pixels a CSS pixel of a picture at rest, drawn without antialiasing
const REST = 180; // milliseconds without change until it is drawn
const SHADOW_MAP = 1536;
const SUN = new Vector3(2.2, 5.2, 3.4);

export class WebGLMissing extends Error {}

export class Stage {
  /** Draws into `canvas`; `onFrame(elapsed seconds)` runs before each picture and says whether to go on. */
  constructor(canvas, onFrame) {
    this.canvas = canvas;
    this.onFrame = onFrame;
    this.thrifty = drawnInSoftware();
    this.rough = this.thrifty;
    this.rest = 0; // timer of the fine picture
    this.rested = false;
    this.renderer = makeRenderer(canvas, !this.thrifty);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.05, 200);
    this.floor = new Floor();
    this.scene.add(this.floor.object);
    this.#lights();
    this.theme = THEMES.dark;
    this.pictures = 0;
    this.visible = true;
    this.size = null;
    this.stopped = false;
    this.request = 0;
    this.last = 0;
    this.tick = this.tick.bind(this);
    this.onVisibility = () => this.invalidate();
    document.addEventListener("visibilitychange", this.onVisibility);
    this.onLost = (event) => { event.preventDefault(); this.lost = true; };
    this.onRestored = () => { this.lost = false; this.invalidate(); };
    canvas.addEventListener("webglcontextlost", this.onLost);
    canvas.addEventListener("webglcontextrestored", this.onRestored);
  }

  #lights() {
    this.sky = new HemisphereLight();
    this.key = new DirectionalLight("#fff4e4");
    this.key.castShadow = true;
    this.key.shadow.mapSize.set(SHADOW_MAP, SHADOW_MAP);
    this.rim = new DirectionalLight();
    this.rim.position.set(-3, 3.2, -4.5);
    this.fill = new DirectionalLight("#cfe0ff", 0.5);
    this.fill.position.set(-4, 1.6, 2.5);
    this.scene.add(this.sky, this.key, this.key.target, this.rim, this.rim.target, this.fill);
  }

  paint(name) {
    const theme = (this.theme = THEMES[name]);
    this.canvas.style.background = gradientStyle(theme);
    this.floor.paint(theme);
    this.sky.color.set(theme.sky);
    this.sky.groundColor = new Color(theme.ground);
    this.sky.intensity = theme.ambient;
    this.key.intensity = theme.key;
    this.rim.color.set(theme.rim);
    this.rim.intensity = theme.rimStrength;
    this.invalidate();
  }

  /** Keeps light and shadow where the figures are; the map moves in whole texels, or shadow edges would swim. */
  lightAround(centre, radius) {
    const reach = Math.ceil(radius * 2) / 2;
    const camera = this.key.shadow.camera;
    if (camera.right !== reach) {
      Object.assign(camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.5, far: 14 + reach * 2 });
      camera.updateProjectionMatrix();
      this.key.shadow.radius = Math.max(1.5, 11 / reach); // the same softness in metres whatever the reach
      this.key.shadow.normalBias = 0.016 + 0.006 * reach; // coarse texels need more, or bodies shade themselves in stripes
      this.key.shadow.bias = -0.0002 - 0.00008 * reach;
    }
    const texel = (2 * reach) / SHADOW_MAP;
    const snap = (value) => Math.round(value / texel) * texel;
    this.key.target.position.set(snap(centre.x), 0, snap(centre.z));
    this.key.position.copy(this.key.target.position).addScaledVector(SUN, 1 + reach / 6);
    this.floor.focus(centre, reach);
  }

  resize(width, height) {
    this.size = [width, height];
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.#fit();
    this.invalidate();
  }

  #fit() {
    if (!this.size) return;
    const ratio = this.thrifty ? (this.rough ? 1 : FINE_RATIO) : Math.min(globalThis.devicePixelRatio || 1, MAX_PIXEL_RATIO);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(...this.size, false);
  }

  /** Asks for a picture; a player out of sight waits until it is seen again. */
  invalidate() {
    clearTimeout(this.rest);
    this.rest = 0;
    this.#ask();
  }

  #ask() {
    if (!this.request && !this.stopped && this.visible && !document.hidden) {
      this.request = requestAnimationFrame(this.tick);
    }
  }

  show(visible) {
    this.visible = visible;
    this.last = 0;
    this.invalidate();
  }

  tick(now) {
    this.request = 0;
    if (this.stopped || !this.visible || document.hidden) {
      this.last = 0;
      return;
    }
    this.#detail(this.thrifty && !this.rested);
    this.rested = false;
    const elapsed = this.last ? Math.min((now - this.last) / 1000, 0.25) : 0;
    const goOn = this.onFrame(elapsed);
    this.draw();
    this.last = goOn ? now : 0;
    if (goOn) this.invalidate();
    else if (this.rough && !this.request) this.rest = setTimeout(() => this.#fine(), REST);
  }

  // Where the processor draws: rough pictures while things change, a fine one once they rest.
  #detail(rough) {
    if (rough === this.rough) return;
    this.rough = rough;
    this.#fit();
  }

  /** The next picture is a fine one, whatever moves. */
  refine() {
    this.#detail(false);
  }

  #fine() {
    this.rest = 0;
    this.rested = true;
    this.#ask();
  }

  draw() {
    if (this.stopped || this.lost) return;
    this.renderer.render(this.scene, this.camera);
    this.pictures += 1;
  }

  /** What the canvas shows now, background included, as a PNG blob. */
  picture() {
    this.draw(); // the drawing buffer is only valid within the task that drew it
    const copy = document.createElement("canvas");
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    const context = copy.getContext("2d");
    paintGradient(context, this.theme);
    context.drawImage(this.canvas, 0, 0);
    return new Promise((resolve) => copy.toBlob(resolve, "image/png"));
  }

  dispose() {
    this.stopped = true;
    cancelAnimationFrame(this.request);
    clearTimeout(this.rest);
    document.removeEventListener("visibilitychange", this.onVisibility);
    this.canvas.removeEventListener("webglcontextlost", this.onLost);
    this.canvas.removeEventListener("webglcontextrestored", this.onRestored);
    this.floor.dispose();
    this.key.shadow.map?.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss(); // browsers allow about 16 contexts a page
  }
}

/** Does the processor do the drawing? Then pictures of moving things are made with less. */
function drawnInSoftware() {
  const probe = document.createElement("canvas").getContext("webgl2");
  const names = probe?.getExtension("WEBGL_debug_renderer_info");
  const renderer = names ? probe.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer);
}

function makeRenderer(canvas, antialias) {
  const attributes = { antialias, alpha: true, stencil: true, depth: true, powerPreference: "high-performance" };
  // three.js logs an error of its own when there is no WebGL; asking first keeps the console clean
  const context = canvas.getContext("webgl2", attributes);
  if (!context) throw new WebGLMissing("This browser has no WebGL 2");
  const renderer = new WebGLRenderer({ canvas, context, ...attributes });
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  renderer.toneMapping = NeutralToneMapping;
  renderer.toneMappingExposure = 1.0;
  return renderer;
}
