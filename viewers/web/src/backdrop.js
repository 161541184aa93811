// What lies behind and under the figures: gradient, floor grid fading out, the shadows' catcher.
import { CircleGeometry, Color, Group, Mesh, PlaneGeometry, ShaderMaterial, ShadowMaterial, Vector3 } from "three";

const FADE = 9;
const SHADOW_FALL = 1.15; // the light comes at a slant: shadows reach a little past what casts them

/*
 * The gradient lies behind the transparent canvas as a style, which costs nothing to draw; only pictures that leave
 * the page have it painted in. Both are ellipses around the same point.
 */
const GRADIENT = { x: 0.5, y: 0.4, wide: 0.72, tall: 0.95, stops: [["centre", 0], ["middle", 0.45], ["edge", 1]] };

/** The gradient as a style. */
export function gradientStyle(theme) {
  const { x, y, wide, tall, stops } = GRADIENT;
  const listed = stops.map(([name, at]) => `${theme[name]} ${at * 100}%`).join(", ");
  return `radial-gradient(${wide * 100}% ${tall * 100}% at ${x * 100}% ${y * 100}%, ${listed})`;
}

/** The gradient painted over a 2D canvas. */
export function paintGradient(context, theme) {
  const { width, height } = context.canvas;
  const { x, y, wide, tall, stops } = GRADIENT;
  const gradient = context.createRadialGradient(0, 0, 0, 0, 0, 1);
  for (const [name, at] of stops) gradient.addColorStop(at, theme[name]);
  context.save();
  context.fillStyle = theme.edge;
  context.fillRect(0, 0, width, height);
  context.translate(x * width, y * height);
  context.scale(wide * width, tall * height);
  context.fillStyle = gradient;
  context.fillRect(-2, -2, 4, 4);
  context.restore();
}

/** Floor y = 0: a grid of metres that fades with distance from `focus`, a pool of light, and the shadow catcher. */
export class Floor {
  constructor() {
    this.grid = new Mesh(new CircleGeometry(1, 48).rotateX(-Math.PI / 2), gridMaterial());
    this.grid.renderOrder = -50;
    this.grid.frustumCulled = false;
    this.shadow = new Mesh(new PlaneGeometry(2, 2).rotateX(-Math.PI / 2), new ShadowMaterial({ depthWrite: false, toneMapped: false }));
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = -40;
    this.object = new Group();
    this.object.add(this.grid, this.shadow);
  }

  /** Neither reaches farther than it shows: every pixel of them costs. `reach` is how far shadows are cast. */
  focus(point, reach) {
    const fade = FADE + reach;
    this.grid.material.uniforms.focus.value.set(point.x, 0, point.z);
    this.grid.material.uniforms.fade.value = fade;
    this.grid.position.set(point.x, 0, point.z);
    this.grid.scale.setScalar(fade);
    this.shadow.position.set(point.x, 0, point.z);
    this.shadow.scale.setScalar(reach * SHADOW_FALL);
  }

  paint(theme) {
    const { line, pool, lineStrength, poolStrength } = this.grid.material.uniforms;
    setRaw(line.value, theme.grid);
    setRaw(pool.value, theme.pool);
    lineStrength.value = theme.gridStrength;
    poolStrength.value = theme.poolStrength;
    this.shadow.material.opacity = theme.shadow;
  }

  dispose() {
    for (const mesh of [this.grid, this.shadow]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
  }
}

function gridMaterial() {
  return new ShaderMaterial({
    transparent: true,
    depthWrite: false,
    toneMapped: false,
    uniforms: {
      focus: { value: new Vector3() },
      fade: { value: FADE },
      line: { value: new Color() },
      pool: { value: new Color() },
      lineStrength: { value: 0.1 },
      poolStrength: { value: 0.1 },
    },
    vertexShader: `
      varying vec3 place;
      void main() { vec4 world = modelMatrix * vec4(position, 1.0); place = world.xyz; gl_Position = projectionMatrix * viewMatrix * world; }`,
    fragmentShader: `
      uniform vec3 focus; uniform vec3 line; uniform vec3 pool;
      uniform float fade; uniform float lineStrength; uniform float poolStrength;
      varying vec3 place;
      float lines(vec2 p, float width) {
        vec2 size = fwidth(p);
        vec2 near = abs(fract(p - 0.5) - 0.5) / max(size, vec2(1e-5));
        vec2 ink = (1.0 - smoothstep(width - 0.5, width + 0.5, near)) * clamp(0.6 / max(size, vec2(1e-5)) / 4.0, 0.0, 1.0);
        return max(ink.x, ink.y);
      }
      void main() {
        float away = distance(place.xz, focus.xz);
        float visible = pow(clamp(1.0 - away / fade, 0.0, 1.0), 1.6);
        float half_metre = lines(place.xz * 2.0, 0.6) * 0.22 * clamp(1.2 - away / 5.0, 0.0, 1.0);
        float metre = lines(place.xz, 0.8);
        float ink = max(half_metre, metre) * lineStrength * visible;
        float glow = poolStrength * exp(-away * away / 5.0);
        float alpha = ink + glow * (1.0 - ink);
        gl_FragColor = vec4(mix(pool, line, ink / max(alpha, 1e-4)), alpha);
      }`,
  });
}

/** A colour whose numbers reach the screen unchanged, for shaders that write sRGB themselves. */
export function setRaw(color, css) {
  return color.set(css).convertLinearToSRGB();
}
