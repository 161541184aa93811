// The skinned body: one geometry shared by every figure and ghost, one small set of bone matrices each.
import {
  BackSide, Bone, BufferAttribute, BufferGeometry, Color, DetachedBindMode, MeshStandardMaterial, NotEqualStencilFunc,
  AlwaysStencilFunc, ReplaceStencilOp, ShaderMaterial, Skeleton, SkinnedMesh,
} from "three";
import { Binding } from "./pose.js";
import { setRaw } from "./backdrop.js";

/** Buffers of the body for the graphics card: one set of vertices, a fine and maybe a coarse set of triangles. */
export class BodyGeometry {
  constructor(body) {
    this.skeleton = body.skeleton;
    const attributes = {
      position: new BufferAttribute(body.vertices, 3),
      normal: new BufferAttribute(body.normals, 3),
      skinIndex: new BufferAttribute(body.skinIndices, 4),
      skinWeight: new BufferAttribute(body.skinWeights, 4, true),
      paint: new BufferAttribute(withTint(body), 4, true),
    };
    this.fine = withTriangles(attributes, body.faces);
    this.coarse = body.coarse ? withTriangles(attributes, body.coarse) : this.fine;
  }

  dispose() {
    this.fine.dispose();
    this.coarse.dispose();
  }
}

function withTriangles(attributes, faces) {
  const geometry = new BufferGeometry();
  for (const [name, attribute] of Object.entries(attributes)) geometry.setAttribute(name, attribute);
  return geometry.setIndex(new BufferAttribute(faces, 1));
}

function withTint({ colours, tint }) {
  const paint = new Uint8Array(tint.length * 4);
  for (let v = 0; v < tint.length; v++) {
    paint.set(colours.subarray(v * 3, v * 3 + 3), v * 4);
    paint[v * 4 + 3] = tint[v];
  }
  return paint;
}

/** Bone matrices that we compute ourselves: three.js only carries them to the shader. */
class Matrices extends Skeleton {
  constructor(joints) {
    super(Array.from({ length: joints }, () => new Bone()));
    this.computeBoneTexture();
  }

  update() {} // called by the renderer for every picture; `wear` has done the work
}

/** One skinned figure in one pose; the passes (solid, depth only, outline) share its bone matrices. */
export class Skin {
  constructor(body, poseSkeleton, coarse = false) {
    this.geometry = coarse ? body.coarse : body.fine;
    this.binding = new Binding(body.skeleton, poseSkeleton);
    this.matrices = new Matrices(body.skeleton.joints.length);
    this.meshes = [];
  }

  /** A mesh of this figure drawn with `material`. */
  mesh(material, renderOrder = 0) {
    const mesh = new SkinnedMesh(this.geometry, material);
    mesh.bindMode = DetachedBindMode;
    mesh.bind(this.matrices, mesh.matrixWorld.clone());
    mesh.frustumCulled = false; // bounds of a skinned mesh are those of its rest pose
    mesh.renderOrder = renderOrder;
    this.meshes.push(mesh);
    return mesh;
  }

  wear(pose) {
    this.binding.matrices(pose, this.matrices.boneMatrices);
    this.matrices.boneTexture.needsUpdate = true;
  }

  dispose() {
    this.matrices.dispose();
    for (const mesh of this.meshes) mesh.material.dispose();
  }
}

/** Lit material in the body's own colours, dyed by the actor's where the body allows it, with a soft edge light. */
export function bodyMaterial({ dye = 1, wash = 0 } = {}) {
  const material = new MeshStandardMaterial({ roughness: 0.68, metalness: 0 });
  const extra = {
    dyeColour: { value: new Color() }, dye: { value: dye }, wash: { value: wash },
    edgeColour: { value: new Color("#ffffff") }, edgeGlow: { value: 0.2 }, lift: { value: 0 },
  };
  material.userData.extra = extra;
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, extra);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute vec4 paint;\nvarying vec4 vPaint;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvPaint = paint;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\n${DYE_PARS}`)
      .replace("#include <color_fragment>", DYE)
      .replace("#include <opaque_fragment>", `${EDGE_LIGHT}\n#include <opaque_fragment>`);
  };
  return material;
}

const DYE_PARS = `
varying vec4 vPaint;
uniform vec3 dyeColour; uniform vec3 edgeColour;
uniform float dye; uniform float wash; uniform float edgeGlow; uniform float lift;`;
// colours are mixed as they are seen (sRGB), as Body.painted does, then made linear for the light
const DYE = `
vec3 seen = mix(vPaint.rgb, dyeColour, max(vPaint.a * dye, wash));
diffuseColor.rgb = sRGBTransferEOTF(vec4(seen, 1.0)).rgb;`;
const EDGE_LIGHT = `
float facing = saturate(dot(normal, normalize(vViewPosition)));
outgoingLight += edgeColour * pow(1.0 - facing, 3.0) * edgeGlow + diffuseColor.rgb * lift;`;

export function dyeBody(material, css, theme) {
  const { dyeColour, edgeColour, edgeGlow } = material.userData.extra;
  setRaw(dyeColour.value, css);
  edgeColour.value.set(theme.rim);
  edgeGlow.value = theme.edgeGlow;
}

/** Writes depth only, so that a translucent figure shows its outside and not its inner walls. */
export function depthMaterial() {
  return new MeshStandardMaterial({ colorWrite: false });
}

/** Marks the figure's pixels in the stencil, for the outline to stay outside of. */
export function markStencil(material, on) {
  material.stencilWrite = on;
  material.stencilRef = 1;
  material.stencilFunc = AlwaysStencilFunc;
  material.stencilZPass = ReplaceStencilOp;
}

/** A line of constant width on the screen around the figure. */
export function outlineMaterial() {
  return new ShaderMaterial({
    side: BackSide,
    transparent: true, // drawn after the figure, which marks the stencil
    toneMapped: false,
    stencilWrite: true,
    stencilRef: 1,
    stencilFunc: NotEqualStencilFunc,
    uniforms: { colour: { value: new Color() }, width: { value: 0.004 }, aspect: { value: 1 } },
    vertexShader: `
      #include <common>
      #include <skinning_pars_vertex>
      uniform float width; uniform float aspect;
      void main() {
        #include <beginnormal_vertex>
        #include <skinbase_vertex>
        #include <skinnormal_vertex>
        #include <begin_vertex>
        #include <skinning_vertex>
        #include <project_vertex>
        vec2 out_ = (projectionMatrix * vec4(normalMatrix * objectNormal, 0.0)).xy;
        out_.x *= aspect;
        vec2 way = length(out_) > 1e-6 ? normalize(out_) : vec2(0.0);
        way.x /= aspect;
        gl_Position.xy += way * width * gl_Position.w;
      }`,
    fragmentShader: `uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }`,
  });
}
