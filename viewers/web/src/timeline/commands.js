// What can be done to the picked block, for the buttons, the menu and the keyboard alike.

const tell = (what) => (sequencer, { block }) => sequencer.tell(what, { id: block.id });

/** Each: a word for people, the key, the icon, what it does; `open` ones are not for locked blocks, `drawn` not for clips. */
export const COMMANDS = [
  { label: "Edit", key: "Enter", symbol: "pen", act: (sequencer, { block }) => sequencer.editor.open(block.id) },
  { label: "Regenerate", key: "R", symbol: "again", open: true, drawn: true, act: tell("renew") },
  { label: "Split", key: "S", symbol: "split", open: true, act: split },
  { label: "Duplicate", key: "D", symbol: "copy", act: tell("duplicate") },
  { label: "Lock", key: "L", symbol: "lock", act: tell("lock") },
  { label: "Delete", key: "Delete", symbol: "trash", open: true, act: tell("remove") },
];

// At the playhead where it is within the block, else in its middle.
function split(sequencer, { block, start, end }) {
  const { now } = sequencer;
  sequencer.tell("split", { id: block.id, after: now > start && now < end ? now - start : block.seconds / 2 });
}

/** Can it be done to a block? */
export function fits({ open, drawn }, { block }) {
  return !(open && block.locked) && !(drawn && block.kind === "clip");
}

/** Its name, as it stands with a block. */
export function named({ label }, span) {
  return label === "Lock" && span?.block.locked ? "Unlock" : label;
}
