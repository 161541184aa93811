// Time of the player: where it is, how fast it runs, what it does at the end.

export const LOOPS = ["off", "all", "selection"];
export const SPEED = { min: 0.1, max: 4 };

export class Clock {
  constructor() {
    this.fps = 20;
    this.frames = 1;
    this.at = 0; // frames, may lie between two
    this.playing = false;
    this.speed = 1;
    this.loop = "all";
    this.selection = null; // [start, end) in frames
  }

  /** Frame rate and number of frames of what is shown; the position is kept where it still exists. */
  cover(fps, frames) {
    this.fps = fps;
    this.frames = Math.max(1, frames);
    this.selection = null;
    this.seek(this.at);
  }

  get frame() {
    return Math.min(Math.round(this.at), this.frames - 1);
  }

  get seconds() {
    return this.at / this.fps;
  }

  get duration() {
    return this.frames / this.fps;
  }

  seek(frame) {
    this.at = Math.min(Math.max(Number.isNaN(frame) ? 0 : frame, 0), this.frames - 1);
  }

  /** The frames that playing runs through: [first, one past the last). */
  get range() {
    return this.loop === "selection" && this.selection ? this.selection : [0, this.frames];
  }

  /** At the end, or outside a looped selection, playing starts over. */
  rewindIfDone() {
    const [start, end] = this.range;
    if (this.at >= end - 1 || this.at < start) this.at = start;
  }

  /** Moves on by real `elapsed` seconds; true when the end was reached and playing stopped. */
  advance(elapsed) {
    const [start, end] = this.range;
    this.at += elapsed * this.speed * this.fps;
    if (this.at < end - 1) return false;
    if (this.loop === "off") {
      this.at = end - 1;
      this.playing = false;
      return true;
    }
    // each frame lasts 1 / fps, the last one too, so a loop of n frames takes n / fps seconds
    if (this.at >= end) this.at = start + ((this.at - start) % (end - start));
    return false;
  }

  /** What to draw: never past the last frame of the range. */
  get shown() {
    return Math.min(this.at, this.range[1] - 1);
  }
}

/** "0:02.60" */
export function readable(seconds) {
  const hundredths = Math.round(seconds * 100);
  const rest = String(hundredths % 6000).padStart(4, "0");
  return `${Math.floor(hundredths / 6000)}:${rest.slice(0, 2)}.${rest.slice(2)}`;
}
