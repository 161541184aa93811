// The skinned body: one geometry shared by every figure and ghost, one small set of bone matrices each.
import {
  AlwaysStencilFunc, BackSide, Bone, BufferAttribute, BufferGeometry, Color, DetachedBindMode, MeshBasicMaterial, MeshLambertMaterial,
  LinearMipmapLinearFilter, MeshStandardMaterial, NotEqualStencilFunc, ReplaceStencilOp, ShaderMaterial, Skeleton, SkinnedMesh, Texture,
} from "three";
import { Binding } from "./pose.js";
import { setRaw } from "./backdrop.js";

/**
 * Buffers of the body for the graphics card. The levels of detail share the vertices and follow each other in one
 * index, so that a mesh chooses by its draw range, and may choose otherwise for its shadow.
 */
export class BodyGeometry {
  /** `changed` is called when a texture has arrived; until then the body has the colours of its vertices. */
  constructor(body, changed = () => {}) {
    this.skeleton = body.skeleton;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(body.vertices, 3));
    geometry.setAttribute("normal", new BufferAttribute(body.normals, 3));
    geometry.setAttribute("skinIndex", new BufferAttribute(body.skinIndices, 4));
    geometry.setAttribute("skinWeight", new BufferAttribute(body.skinWeights, 4, true));
    geometry.setAttribute("paint", new BufferAttribute(withTint(body), 4, true));
    const { levels } = body;
    const index = new levels[0].constructor(levels.reduce((total, level) => total + level.length, 0));
    let start = 0;
    this.ranges = levels.map((level) => {
      index.set(level, start);
      start += level.length;
      return [start - level.length, level.length];
    });
    geometry.setIndex(new BufferAttribute(index, 1));
    this.geometry = geometry;
    this.rough = false; // set while pictures have to come fast: everything one level coarser
    this.painting = null; // uniforms of the texture
    if (body.texture) {
      geometry.setAttribute("uv", new BufferAttribute(body.uv, 2, true));
      this.painting = { painting: { value: new Texture() }, arrived: { value: 0 } };
      this.arrived = this.#load(body.texture).then(changed, () => {}); // a picture that no browser reads: as it was
    }
  }

  // Its values are used as they are stored (sRGB), like the colours of vertices; its first row is at v = 0.
  async #load(file) {
    const picture = await createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    const { painting, arrived } = this.painting;
    Object.assign(painting.value, { image: picture, flipY: false, minFilter: LinearMipmapLinearFilter, needsUpdate: true });
    arrived.value = 1;
  }

  /** Chooses what the next mesh is drawn with: 0 is the finest, Infinity the coarsest. */
  use(level) {
    this.geometry.setDrawRange(...this.ranges[Math.min(level + (this.rough ? 1 : 0), this.ranges.length - 1)]);
  }

  dispose() {
    this.geometry.dispose();
    this.painting?.painting.value.dispose();
  }
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
  constructor(body, poseSkeleton, level = 0) {
    this.body = body;
    this.level = level;
    this.binding = new Binding(body.skeleton, poseSkeleton);
    this.matrices = new Matrices(body.skeleton.joints.length);
    this.meshes = [];
  }

  /** A mesh of this figure drawn with `material`. */
  mesh(material, renderOrder = 0) {
    const { body, level } = this;
    const mesh = new SkinnedMesh(body.geometry, material);
    mesh.onBeforeRender = () => body.use(level);
    mesh.onBeforeShadow = () => body.use(Infinity);
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
export function bodyMaterial(body) {
  return dyed(new MeshStandardMaterial({ roughness: 0.68, metalness: 0 }), 0, body.painting);
}

/** The same for ghosts: matt, and in one colour but for a trace of the body's own. */
export function ghostMaterial() {
  return dyed(new MeshLambertMaterial({ transparent: true }), 0.82);
}

function dyed(material, wash, painting = null) {
  const extra = {
    dyeColour: { value: new Color() }, wash: { value: wash }, edgeColour: { value: new Color() }, edgeGlow: { value: 0.2 },
    ...painting,
  };
  if (painting) material.defines = { ...material.defines, PAINTED: "" };
  material.userData.extra = extra;
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, extra);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute vec4 paint;\nvarying vec4 vPaint;\nvarying vec2 vPlace;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvPaint = paint;\nvPlace = uv;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\n${DYE_PARS}`)
      .replace("#include <color_fragment>", DYE)
      .replace("#include <opaque_fragment>", `${EDGE_LIGHT}\n#include <opaque_fragment>`);
  };
  return material;
}

const DYE_PARS = `
varying vec4 vPaint; varying vec2 vPlace;
uniform vec3 dyeColour; uniform vec3 edgeColour;
uniform float wash; uniform float edgeGlow;
#ifdef PAINTED
uniform sampler2D painting; uniform float arrived;
#endif`;
// colours are mixed as they are seen (sRGB), as Body.painted does, then made linear for the light
const DYE = `
vec3 own = vPaint.rgb;
#ifdef PAINTED
own = mix(own, texture2D(painting, vPlace).rgb, arrived);
#endif
vec3 seen = mix(own, dyeColour, max(vPaint.a, wash));
diffuseColor.rgb = sRGBTransferEOTF(vec4(seen, 1.0)).rgb;`;
const EDGE_LIGHT = `
float facing = saturate(dot(normal, normalize(vViewPosition)));
outgoingLight += edgeColour * pow(1.0 - facing, 3.0) * edgeGlow;`;

export function dyeBody(material, css, theme) {
  const { dyeColour, edgeColour, edgeGlow } = material.userData.extra;
  setRaw(dyeColour.value, css);
  edgeColour.value.set(theme.rim);
  edgeGlow.value = theme.edgeGlow;
}

/** Writes depth only, so that a translucent figure shows its outside and not its inner walls. */
export function depthMaterial() {
  return new MeshBasicMaterial({ colorWrite: false });
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
