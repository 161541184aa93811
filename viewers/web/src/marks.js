// What an actor leaves on the floor: contact shadows, contact rings, the trail of its root.
import {
  BufferAttribute, BufferGeometry, Color, InstancedBufferAttribute, InstancedMesh, Matrix4, PlaneGeometry, Points, ShaderMaterial,
} from "three";
import { setRaw } from "./backdrop.js";
import { inContact } from "./payload.js";

const flat = () => new PlaneGeometry(2, 2).rotateX(-Math.PI / 2);

const DISC_VERTEX = `
  attribute float strength; varying float vStrength; varying vec2 spot;
  void main() {
    vStrength = strength; spot = position.xz;
    gl_Position = projectionMatrix * modelViewMatrix * instanceMatrix * vec4(position, 1.0);
  }`;

function discs(count, fragment, colour, renderOrder) {
  const material = new ShaderMaterial({
    transparent: true, depthWrite: false, toneMapped: false,
    uniforms: { colour: { value: colour } },
    vertexShader: DISC_VERTEX,
    fragmentShader: `uniform vec3 colour; varying float vStrength; varying vec2 spot; void main() { ${fragment} }`,
  });
  const geometry = flat();
  geometry.setAttribute("strength", new InstancedBufferAttribute(new Float32Array(count), 1));
  const mesh = new InstancedMesh(geometry, material, count);
  mesh.frustumCulled = false;
  mesh.renderOrder = renderOrder;
  return mesh;
}

function place(mesh, i, x, y, z, size, strength, matrix) {
  mesh.setMatrixAt(i, matrix.makeScale(size, 1, size).setPosition(x, y, z));
  mesh.geometry.attributes.strength.array[i] = strength;
}

function changed(mesh) {
  mesh.instanceMatrix.needsUpdate = true;
  mesh.geometry.attributes.strength.needsUpdate = true;
}

function disposeMesh(mesh) {
  mesh.geometry.dispose();
  mesh.material.dispose();
  mesh.dispose?.();
}

/** Soft dark spots that ground the figure: small ones under the feet, a wide one under the hips. */
export class ContactShadows {
  constructor(skeleton) {
    this.joints = [...skeleton.feet, 0];
    this.object = discs(this.joints.length, "float a = exp(-dot(spot, spot) * 4.0) - 0.0183; gl_FragColor = vec4(colour, max(a, 0.0) * vStrength);", new Color(0, 0, 0), -30);
    this.matrix = new Matrix4();
  }

  wear(pose) {
    this.joints.forEach((joint, i) => {
      const hips = i === this.joints.length - 1;
      const [x, y, z] = pose.places.subarray(joint * 3, joint * 3 + 3);
      const near = Math.exp(-Math.max(y - (hips ? 0.9 : 0.08), 0) * (hips ? 1.2 : 6));
      place(this.object, i, x, 0.003, z, (hips ? 0.62 : 0.2) * (1.3 - 0.3 * near), (hips ? 0.34 : 0.42) * near, this.matrix);
    });
    changed(this.object);
  }

  dispose() {
    disposeMesh(this.object);
  }
}

/** Rings under the foot joints that are in contact with the ground. */
export class ContactRings {
  constructor(skeleton) {
    this.joints = skeleton.feet;
    const ring = `
      float r = length(spot);
      float ring = smoothstep(0.52, 0.6, r) * (1.0 - smoothstep(0.7, 0.78, r));
      float glow = exp(-r * r * 5.0) * 0.5;
      gl_FragColor = vec4(colour, max(ring, glow) * vStrength);`;
    this.object = discs(Math.max(this.joints.length, 1), ring, new Color(), 5);
    this.matrix = new Matrix4();
  }

  wear(pose, take, frame, mirror) {
    const at = Math.min(frame, take.frames - 1);
    this.joints.forEach((joint, i) => {
      const source = mirror ? this.joints.indexOf(take.skeleton.mirror[joint]) : i;
      const on = source >= 0 && inContact(take, at, source) ? 1 : 0;
      place(this.object, i, pose.places[joint * 3], 0.008, pose.places[joint * 3 + 2], i % 2 ? 0.1 : 0.13, on, this.matrix);
    });
    changed(this.object);
  }

  paint(css) {
    setRaw(this.object.material.uniforms.colour.value, css);
  }

  dispose() {
    disposeMesh(this.object);
  }
}

/** The root's way over the floor, one dot a frame: bright behind the playhead, faint ahead of it. */
export class Trail {
  constructor(take) {
    const geometry = new BufferGeometry();
    const [x, , z] = take.skeleton.offsets[0];
    const spots = new Float32Array(take.frames * 3);
    const order = new Float32Array(take.frames);
    for (let i = 0; i < take.frames; i++) {
      spots.set([take.path[i * 3] + x, 0.012, take.path[i * 3 + 2] + z], i * 3);
      order[i] = i;
    }
    geometry.setAttribute("position", new BufferAttribute(spots, 3));
    geometry.setAttribute("order", new BufferAttribute(order, 1));
    this.object = new Points(geometry, trailMaterial());
    this.object.frustumCulled = false;
    this.object.renderOrder = -10;
  }

  update(frame, pixels, mirror) {
    const { now, scale } = this.object.material.uniforms;
    now.value = frame;
    scale.value = pixels;
    this.object.scale.x = mirror ? -1 : 1;
  }

  paint(css) {
    setRaw(this.object.material.uniforms.colour.value, css);
  }

  dispose() {
    disposeMesh(this.object);
  }
}

function trailMaterial() {
  return new ShaderMaterial({
    transparent: true, depthWrite: false, toneMapped: false,
    uniforms: { colour: { value: new Color() }, now: { value: 0 }, scale: { value: 500 } },
    vertexShader: `
      attribute float order; uniform float now; uniform float scale; varying float alpha;
      void main() {
        vec4 seen = modelViewMatrix * vec4(position, 1.0);
        gl_Position = projectionMatrix * seen;
        float head = 1.0 - smoothstep(0.0, 0.8, abs(order - now));
        alpha = order <= now + 0.5 ? 1.0 : 0.38;
        gl_PointSize = clamp(scale * (0.017 + 0.014 * head) / -seen.z, 3.2, 30.0);
      }`,
    fragmentShader: `
      uniform vec3 colour; varying float alpha;
      void main() {
        float r = length(gl_PointCoord - 0.5) * 2.0;
        float a = (1.0 - smoothstep(0.7, 1.0, r)) * alpha;
        if (a < 0.01) discard;
        gl_FragColor = vec4(colour, a);
      }`,
  });
}
