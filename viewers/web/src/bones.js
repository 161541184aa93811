// The skeleton as tapered bones and balls, for any joint tree.
import {
  BufferAttribute, BufferGeometry, Color, Group, InstancedMesh, Matrix4, MeshStandardMaterial, Quaternion, SphereGeometry, Vector3,
} from "three";

const BALL = 0.02;
const UP = new Vector3(0, 1, 0);

export class Bones {
  constructor(skeleton) {
    this.skeleton = skeleton;
    this.segments = segmentsOf(skeleton);
    this.boneMaterial = new MeshStandardMaterial({ roughness: 0.55, flatShading: true });
    this.ballMaterial = new MeshStandardMaterial({ roughness: 0.4 });
    this.bones = new InstancedMesh(boneGeometry(), this.boneMaterial, this.segments.length);
    this.balls = new InstancedMesh(new SphereGeometry(1, 14, 10), this.ballMaterial, skeleton.joints.length);
    this.object = new Group();
    for (const mesh of [this.bones, this.balls]) {
      mesh.frustumCulled = false;
      mesh.castShadow = true;
      this.object.add(mesh);
    }
    this.scratch = { matrix: new Matrix4(), from: new Vector3(), to: new Vector3(), turn: new Quaternion(), size: new Vector3() };
  }

  wear(pose) {
    const { matrix, from, to, turn, size } = this.scratch;
    const tip = [0, 0, 0];
    this.segments.forEach(({ joint, child, end }, i) => {
      from.fromArray(pose.places, joint * 3);
      if (end) to.fromArray(pose.tip(joint, end, tip));
      else to.fromArray(pose.places, child * 3);
      to.sub(from);
      const length = Math.max(to.length(), 1e-4);
      turn.setFromUnitVectors(UP, to.divideScalar(length));
      const width = Math.min(Math.max(length * 0.13, 0.012), 0.036);
      this.bones.setMatrixAt(i, matrix.compose(from, turn, size.set(width, length, width)));
    });
    for (let j = 0; j < this.skeleton.joints.length; j++) {
      from.fromArray(pose.places, j * 3);
      this.balls.setMatrixAt(j, matrix.makeScale(BALL, BALL, BALL).setPosition(from));
    }
    this.bones.instanceMatrix.needsUpdate = true;
    this.balls.instanceMatrix.needsUpdate = true;
  }

  paint(css, jointCss, glow = 0) {
    this.boneMaterial.color.set(css);
    this.boneMaterial.emissive.set(css).multiplyScalar(glow);
    this.ballMaterial.color.set(new Color(jointCss));
  }

  fade(opacity) {
    for (const material of [this.boneMaterial, this.ballMaterial]) {
      material.transparent = opacity < 1;
      material.opacity = opacity;
    }
    this.bones.castShadow = this.balls.castShadow = opacity >= 1;
  }

  dispose() {
    for (const mesh of [this.bones, this.balls]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
      mesh.dispose();
    }
  }
}

/** Every bone as (joint, child joint) or (joint, end offset). */
function segmentsOf(skeleton) {
  const segments = [];
  skeleton.parents.forEach((parent, j) => {
    if (parent >= 0) segments.push({ joint: parent, child: j });
    if (skeleton.ends[j]) segments.push({ joint: j, end: skeleton.ends[j] });
  });
  return segments;
}

/** A long octahedron from the origin to (0, 1, 0), thickest near its start. */
function boneGeometry() {
  const ring = [[1, 0.16, 0], [0, 0.16, 1], [-1, 0.16, 0], [0, 0.16, -1]];
  const points = [[0, 0, 0], ...ring, [0, 1, 0]];
  const faces = [];
  for (let i = 0; i < 4; i++) {
    const a = 1 + i, b = 1 + ((i + 1) % 4);
    faces.push([0, a, b], [5, b, a]);
  }
  const geometry = new BufferGeometry();
  const flat = faces.flat().flatMap((index) => points[index]);
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(flat), 3));
  geometry.computeVertexNormals();
  return geometry;
}
