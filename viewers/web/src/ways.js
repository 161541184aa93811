// Where the figures go on the floor, for arranging and framing them.

const SAMPLES = 48;

/** The root's way on the floor as [x, z, x, z, ...] in the actor's own place. */
export function floorWay(take, { mirror, inPlace }) {
  const [x0, , z0] = take.skeleton.offsets[0];
  const count = inPlace ? 1 : take.frames;
  const way = new Float32Array(count * 2);
  for (let i = 0; i < count; i++) {
    way[i * 2] = (take.path[i * 3] + x0) * (mirror ? -1 : 1);
    way[i * 2 + 1] = take.path[i * 3 + 2] + z0;
  }
  return way;
}

/**
 * The floor rectangle that all ways lie in, and the farthest any figure gets from the middle of them at one time.
 * `rates` are the takes' frames a second, `places` where they stand.
 */
export function coverOf(ways, rates, places) {
  const bounds = { minX: Infinity, maxX: -Infinity, minZ: Infinity, maxZ: -Infinity };
  let spread = 0;
  const longest = Math.max(...ways.map((way, i) => (way.length / 2 - 1) / rates[i]));
  for (let sample = 0; sample <= SAMPLES; sample++) {
    const spots = ways.map((way, i) => {
      const frame = Math.min(Math.round((sample / SAMPLES) * longest * rates[i]), way.length / 2 - 1);
      return [way[frame * 2] + places[i].x, way[frame * 2 + 1] + places[i].z];
    });
    const middle = [0, 1].map((axis) => spots.reduce((sum, spot) => sum + spot[axis], 0) / spots.length);
    for (const [x, z] of spots) {
      bounds.minX = Math.min(bounds.minX, x);
      bounds.maxX = Math.max(bounds.maxX, x);
      bounds.minZ = Math.min(bounds.minZ, z);
      bounds.maxZ = Math.max(bounds.maxZ, z);
      spread = Math.max(spread, Math.hypot(x - middle[0], z - middle[1]));
    }
  }
  return { bounds, spread };
}
