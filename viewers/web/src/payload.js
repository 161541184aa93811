// Reads the bytes that payload.py writes; the layout is described there and nowhere else.

const READERS = {
  uint8: Uint8Array,
  uint16: Uint16Array,
  uint32: Uint32Array,
  int16: Int16Array,
  float32: Float32Array,
};
const UNIT_STEPS = 32767;
const POSITION_STEPS = 65535;

/** Splits a payload (DataView, ArrayBuffer or typed array) into its header and its arrays. */
export function unpack(data) {
  const bytes = alignedBytes(data);
  if (String.fromCharCode(...bytes.subarray(0, 4)) !== "MLP1") {
    throw new Error("These bytes are not a motionloom payload.");
  }
  const start = 8 + new DataView(bytes.buffer).getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(8, start)));
  const arrays = {};
  for (const [name, [type, shape, offset]] of Object.entries(header.arrays)) {
    const count = shape.reduce((product, size) => product * size, 1);
    arrays[name] = new READERS[type](bytes.buffer, start + offset, count);
  }
  return { header, arrays };
}

// Typed arrays must start at a multiple of their item size, which a view into a message does not promise.
function alignedBytes(data) {
  const source = data instanceof ArrayBuffer ? new Uint8Array(data) : new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  return source.slice();
}

export function isEmpty(data) {
  return !data || data.byteLength === 0;
}

/** The body's mesh and the rest pose it is bound to; null when there is no body. */
export function decodeBody(data) {
  if (isEmpty(data)) return null;
  const { header, arrays } = unpack(data);
  const { low, high } = header;
  const vertices = Float32Array.from(arrays.vertices, (step, i) => low[i % 3] + ((high[i % 3] - low[i % 3]) * step) / POSITION_STEPS);
  const normals = Float32Array.from(arrays.normals, (step) => step / UNIT_STEPS);
  return {
    vertices,
    normals,
    levels: Object.keys(arrays).filter((name) => /^(faces|coarse\d+)$/.test(name)).map((name) => arrays[name]), // fine first
    skinIndices: arrays.skin_indices,
    skinWeights: arrays.skin_weights,
    colours: arrays.colours,
    tint: arrays.tint,
    uv: arrays.uv, // undefined without a texture
    texture: arrays.texture && new Blob([arrays.texture], { type: header.texture }),
    skeleton: header.skeleton,
  };
}

/** The takes, ready to be sampled: rotations as unit quaternions xyzw (three.js order), paths in metres. */
export function decodeTakes(data) {
  if (isEmpty(data)) return [];
  const { header, arrays } = unpack(data);
  return header.actors.map((actor, i) => {
    const contacts = arrays[`contacts${i}`];
    return {
      ...actor,
      labels: actor.labels.map(([start, end, kind, value]) => ({ start, end, kind, value })),
      skeleton: header.skeletons[actor.skeleton],
      rotations: toUnitXyzw(arrays[`rotations${i}`]),
      path: arrays[`path${i}`],
      contacts,
      contactBytes: contacts.length / actor.frames,
    };
  });
}

function toUnitXyzw(steps) {
  const out = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i += 4) {
    const w = steps[i], x = steps[i + 1], y = steps[i + 2], z = steps[i + 3];
    const scale = 1 / Math.sqrt(w * w + x * x + y * y + z * z);
    out[i] = x * scale;
    out[i + 1] = y * scale;
    out[i + 2] = z * scale;
    out[i + 3] = w * scale;
  }
  return out;
}

/** Is foot joint `index` (order of skeleton.feet) in contact at `frame`? */
export function inContact(take, frame, index) {
  return ((take.contacts[frame * take.contactBytes + (index >> 3)] ?? 0) >> (index & 7)) & 1;
}
