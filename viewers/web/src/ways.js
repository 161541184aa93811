// Where the figures go on the floor, for arranging and framing them.
import { Vector3 } from "three";

const SAMPLES = 48;
const ARM = 1.7; // metres around a figure that belong to it

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
 * Where all the figures go: `bounds` is the floor rectangle they walk over; `reach` the farthest any of them gets from
 * their middle at one time, `start` the same at the start alone.
 * `rates` are the takes' frames a second, `places` where they stand.
 */
export function coverOf(ways, rates, places) {
  const bounds = { minX: Infinity, maxX: -Infinity, minZ: Infinity, maxZ: -Infinity };
  const longest = Math.max(...ways.map((way, i) => (way.length / 2 - 1) / rates[i]));
  const reaches = [];
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
    }
    reaches.push(Math.max(...spots.map(([x, z]) => Math.hypot(x - middle[0], z - middle[1]))));
  }
  return { bounds, reach: Math.max(...reaches), start: reaches[0] };
}

/** The middle of some places on the floor, and how far from it what stands there reaches. */
export function spreadOf(places) {
  const centre = places.reduce((sum, place) => sum.add(place), new Vector3()).divideScalar(Math.max(places.length, 1)).setY(0);
  return [centre, ARM + Math.max(0, ...places.map(({ x, z }) => Math.hypot(x - centre.x, z - centre.z)))];
}
