"""Motion -> features -> Motion on every prepared clip: a table per corpus, the worst clips named.

features_round_trip.py [--every N] [--slow-every N]: three tables, in millimetres.

1. Every representation of ours from every source: how far joints come back from where they were.
2. The released dialects: how far the joints their own inverse gives are from those they were made of.
3. Decoding from "rotations" and from "positions" when features are off by a tenth of each part's deviation, as network
   output is: what to choose the source by.

Needs the prepared data (motionloom data prepare). What goes through `geometry.retarget` or `inverse` takes ten times
as long as the rest: `--slow-every 10` (the default) does that on every tenth clip, but for humanml3d, done on all.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator

import numpy as np

from engines import datasets, features
from engines.datasets import Clip
from engines.features import Source, Statistics
from engines.features.official_codec import OfficialCodec
from engines.features.official_humanml3d import OfficialHumanML3D
from engines.geometry import rotations
from engines.motion import Motion

SLOW: set[tuple[str, Source | None]] = {
    ("kit", "rotations"),
    ("kit", "positions"),
    ("style", "positions"),
    ("kit-official", None),
    ("style-official", None),
}
"""Representations and sources that `--slow-every` thins out."""
OURS = ("humanml3d", "kit", "style", "smplh", "lie")
RELEASED = ("humanml3d-official", "kit-official", "style-official")
NOISE = 0.1
"""Share of each part's standard deviation."""
SPREAD = 64
"""Clips are taken in this many rounds over all of them."""
NOISY = 60
"""How many clips are decoded with noise."""
BROKEN = 10.0
"""Millimetres of mean error from which a released clip counts as broken."""


def say(line: str = "") -> None:
    """A line on standard output."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def apart(found: np.ndarray, wanted: np.ndarray) -> float:
    """Mean distance of joints (T, J, 3), millimetres."""
    return float(np.linalg.norm(found - wanted, axis=-1).mean()) * 1e3


def turned(found: Motion, wanted: Motion) -> float:
    """Mean angle between joints' rotations, degrees."""
    off = rotations.multiply(rotations.invert(found.rotations), wanted.rotations)
    return float(np.degrees(rotations.angle(off).mean()))


class Table:
    """Errors of clips, gathered under a row's name and a corpus."""

    def __init__(self) -> None:
        self.errors: dict[tuple[str, str], list[tuple[float, str, float]]] = defaultdict(list)

    def add(self, row: str, clip: Clip, error: float, angle: float = float("nan")) -> None:
        """One clip's error in millimetres and degrees."""
        self.errors[row, clip.corpus].append((error, clip.name, angle))

    def rows(self) -> Iterator[tuple[str, str, np.ndarray, str, float]]:
        """Row, corpus, all errors, the worst clip, mean angle."""
        for (row, corpus), found in self.errors.items():
            yield row, corpus, np.array([f[0] for f in found]), max(found)[1], float(np.mean([f[2] for f in found]))


def round_trips(table: Table, clip: Clip, slow: bool) -> None:
    """One clip through every representation of ours and back, leaving out the slow ways or not."""
    for codec in map(features.get, OURS):
        sources: list[Source] = [source for source in codec.sources if slow or (codec.name, source) not in SLOW]
        if not sources:
            continue
        wanted = codec.fitted(clip.motion)
        made, start = codec.encode(wanted), codec.start(wanted)
        for source in sources:
            found = codec.decode(made, source=source, start=start)
            table.add(f"{codec.name} / {source}", clip, apart(found.positions, wanted.positions), turned(found, wanted))


def released(table: Table, clip: Clip, slow: bool) -> None:
    """One clip through the released dialects: their own inverse against the joints that were encoded."""
    for codec in map(features.get, RELEASED):
        if not isinstance(codec, OfficialCodec) or (not slow and (codec.name, None) in SLOW):
            continue
        wanted = codec.fitted(clip.motion)
        found = codec.positions(codec.encode(wanted))
        true = codec.fitted_joints(wanted.positions / codec.unit) * codec.unit
        if isinstance(codec, OfficialHumanML3D):
            true = codec.canonical(true)
        table.add(codec.name, clip, apart(*_placed_alike(found, true[:-1])))


def _placed_alike(found: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both with the first frame's root at the origin and its hips in line: where a clip starts is no error."""
    alike = []
    for placed in (found, wanted):
        joints = placed - placed[:1, :1]
        across = joints[0, 1] - joints[0, 2]
        yaw = np.arctan2(-across[2], across[0])
        alike.append(rotations.rotate(rotations.yaw_quaternion(-yaw), joints))
    return alike[0], alike[1]


def noisy(table: Table, clips: list[Clip], names: Iterable[str]) -> None:
    """Decoding features with noise in every part but the contacts, from either source."""
    rng = np.random.default_rng(0)
    for name in names:
        codec = features.get(name)
        feet = [codec.skeleton.index(joint) for foot in codec.skeleton.feet for joint in foot]
        made = [codec.encode(clip.motion) for clip in clips]
        spread = Statistics.measure(made, codec.layout).std * NOISE
        for clip, values in zip(clips, made, strict=True):
            clean = codec.decode(values, source="rotations")
            off = values + rng.normal(size=values.shape).astype(np.float32) * spread
            # the way over the ground is the same for both: what differs is the pose
            for part in ("yaw_velocity", "root_velocity"):
                off[:, codec.layout[part]] = values[:, codec.layout[part]]
            for source in codec.sources:
                found = codec.decode(off, source=source)
                table.add(f"{name} / {source}", clip, apart(found.positions, clean.positions), turned(found, clean))
                error = apart(found.positions[:, feet], clean.positions[:, feet])
                table.add(f"{name} / {source}, feet", clip, error)


def show(title: str, table: Table) -> None:
    """Print one table."""
    say(f"\n{title}")
    say(f"{'representation':<30}{'corpus':<14}{'clips':>6}{'mean mm':>11}{'worst mm':>11}{'degrees':>9}  worst clip")
    for row, corpus, errors, worst, angle in table.rows():
        shown = f"{'':9}" if np.isnan(angle) else f"{angle:9.3f}"
        say(f"{row:<30}{corpus:<14}{len(errors):>6}{errors.mean():>11.4f}{errors.max():>11.4f}{shown}  {worst}")


def measure(tables: tuple[Table, Table, Table], clips: list[Clip], slow_every: int) -> None:
    """Fill all three tables."""
    noisy(tables[2], clips[:NOISY], ("humanml3d", "style"))
    for done, clip in enumerate(clips):
        slow = done % slow_every == 0
        round_trips(tables[0], clip, slow)
        released(tables[1], clip, slow)
        if done % 250 == 0:
            sys.stderr.write(f"{done} of {len(clips)} clips\n")


def main() -> None:
    """Run all three."""
    parser = argparse.ArgumentParser(description="Motion -> features -> Motion on every prepared clip")
    parser.add_argument("--every", type=int, default=1, help="take every Nth clip")
    parser.add_argument("--slow-every", type=int, default=10, help="of those, the slow ways on every Nth")
    options = parser.parse_args()
    clips = datasets.load()[:: options.every]
    # spread over the corpora, so that a run that is stopped (Ctrl-C) has seen something of each
    clips = [clip for first in range(SPREAD) for clip in clips[first::SPREAD]]
    tables = Table(), Table(), Table()
    try:
        measure(tables, clips, options.slow_every)
    except KeyboardInterrupt:
        say("stopped before the end; what there is:")
    show("Motion -> features -> Motion", tables[0])
    show("the released dialects, their own inverse against what they were made of", tables[1])
    for row, corpus, errors, _, _ in tables[1].rows():
        say(f"  {row}, {corpus}: {int((errors > BROKEN).sum())} of {len(errors)} clips off by more than {BROKEN:g} mm")
    show(f"decoding with {NOISE:g} of each part's deviation as noise", tables[2])


if __name__ == "__main__":
    main()
