// Where blocks lie in time, and time on the screen. Nothing here knows the page.

export const SHORTEST = 0.2; // seconds of a block
export const LONGEST_TRANSITION = 5;
const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300];

/** Blocks one after the other: [{block, index, start, end, gap}], the transition of `gap` seconds before each. */
export function layOut(blocks) {
  let at = 0;
  return blocks.map((block, index) => {
    const gap = index ? block.transition : 0;
    const start = at + gap;
    at = start + block.seconds;
    return { block, index, start, end: at, gap };
  });
}

export function lengthOf(spans) {
  return spans.at(-1)?.end ?? 0;
}

/** The spans of which something lies between two times, transitions included: [first, last). */
export function within(spans, from, to) {
  const first = lowest(spans.length, (i) => spans[i].end > from);
  const last = lowest(spans.length, (i) => spans[i].start - spans[i].gap >= to);
  return [first, Math.max(first, last)];
}

// The first index of which it is true; from there on it stays so.
function lowest(count, test) {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (test(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The span at a time, its transition included; the last one behind the end. */
export function spanAt(spans, time) {
  return spans[Math.min(lowest(spans.length, (i) => spans[i].end > time), spans.length - 1)];
}

/** Place among the spans for something dropped at a time: before the first block whose middle lies behind it. */
export function placeAt(spans, time) {
  return lowest(spans.length, (i) => (spans[i].start + spans[i].end) / 2 > time);
}

/** The time, or one of the points if one is as near as `reach` seconds. */
export function snapped(time, points, reach) {
  let best = time;
  let away = reach;
  for (const point of points) if (Math.abs(point - time) < away) [best, away] = [point, Math.abs(point - time)];
  return best;
}

/** Seconds between numbered ticks that stand at least `room` pixels apart. */
export function tickStep(scale, room = 64) {
  return STEPS.find((step) => step * scale >= room) ?? 600;
}

/** A time as numbers for people: "2.4 s", "4:23"; past a minute in tenths where whole seconds would be the same. */
export function clockText(seconds, { tenths = false } = {}) {
  if (seconds < 60) return `${round(seconds)} s`;
  const rest = Math.round((seconds % 60) * 10) / 10;
  return `${Math.floor(seconds / 60)}:${tenths ? rest.toFixed(1).padStart(4, "0") : String(Math.floor(rest)).padStart(2, "0")}`;
}

export function round(seconds) {
  return Math.round(seconds * 100) / 100;
}
