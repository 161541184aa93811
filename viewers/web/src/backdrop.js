// What lies behind and under the figures: gradient, floor grid fading out, the shadows' catcher.
import { Color, Group, Mesh, PlaneGeometry, ShaderMaterial, ShadowMaterial, Vector3 } from "three";

const FLOOR_SIZE = 120;
const FADE = 9;

/** A gradient over the whole picture, lighter behind the figures; dithered, or dark tones would show bands. */
export function makeGradient() {
  const material = new ShaderMaterial({
    depthTest: false,
    depthWrite: false,
    toneMapped: false,
    uniforms: {
      centre: { value: new Color() },
      middle: { value: new Color() },
      edge: { value: new Color() },
      aspect: { value: 1 },
    },
    vertexShader: `varying vec2 spot; void main() { spot = position.xy; gl_Position = vec4(position.xy, 1.0, 1.0); }`,
    fragmentShader: `
      uniform vec3 centre; uniform vec3 middle; uniform vec3 edge; uniform float aspect; varying vec2 spot;
      float noise(vec2 p) { return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453); }
      void main() {
        vec2 p = vec2(spot.x * mix(1.0, aspect, 0.35), spot.y - 0.18);
        float r = length(p * vec2(0.82, 0.95));
        vec3 tone = mix(centre, middle, smoothstep(0.0, 0.85, r));
        tone = mix(tone, edge, smoothstep(0.55, 1.75, r));
        gl_FragColor = vec4(tone + (noise(gl_FragCoord.xy) - 0.5) / 255.0, 1.0);
      }`,
  });
  const mesh = new Mesh(new PlaneGeometry(2, 2), material);
  mesh.frustumCulled = false;
  mesh.renderOrder = -100;
  return mesh;
}

/** Floor y = 0: a grid of metres that fades with distance from `focus`, a pool of light, and the shadow catcher. */
export class Floor {
  constructor() {
    const geometry = new PlaneGeometry(FLOOR_SIZE, FLOOR_SIZE).rotateX(-Math.PI / 2);
    this.grid = new Mesh(geometry, gridMaterial());
    this.grid.renderOrder = -50;
    this.shadow = new Mesh(geometry, new ShadowMaterial({ depthWrite: false, toneMapped: false }));
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = -40;
    this.object = new Group();
    this.object.add(this.grid, this.shadow);
  }

  focus(point, spread) {
    this.grid.material.uniforms.focus.value.set(point.x, 0, point.z);
    this.grid.material.uniforms.fade.value = FADE + spread;
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
    this.grid.geometry.dispose();
    this.grid.material.dispose();
    this.shadow.material.dispose();
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
