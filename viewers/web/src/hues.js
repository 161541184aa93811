// Colours of labels and blocks: the same word has the same one on the timeline, in ghosts and seen from above.

export const HUES = ["#e8a33d", "#58b98b", "#b07be0", "#5b9dff", "#e4776d", "#3fb9c4", "#d6c150", "#dd7fb4"];

/** Map of word -> colour, in the order they come. */
export function huesOf(words) {
  const hues = new Map();
  for (const word of words) if (!hues.has(word)) hues.set(word, HUES[hues.size % HUES.length]);
  return hues;
}

/** The same of a take's labels: what is done first, then how. */
export function labelHues(labels) {
  const of = (...kinds) => labels.filter(({ kind }) => kinds.includes(kind)).map(({ value }) => value);
  return huesOf([...of("action", "text"), ...of("style")]);
}

/** What is done at each stretch of a take that does several things: [{start, end, hue}]; empty where it does one. */
export function tintsOf(take) {
  const done = take.labels.filter(({ kind }) => kind === "action" || kind === "text");
  if (done.length < 2) return [];
  const hues = labelHues(take.labels);
  return done.map(({ start, end, value }) => ({ start, end, hue: hues.get(value) }));
}

/** The colour at a frame: that of its stretch, or of the one before. */
export function tintAt(tints, frame) {
  let found = tints[0]?.hue ?? null;
  for (const { start, hue } of tints) if (start <= frame) found = hue;
  return found;
}
