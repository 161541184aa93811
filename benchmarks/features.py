"""What a Motion costs on its way to features and back, one clip of 200 frames and 32 of them at once.

Run: python benchmarks/features.py. Wall and processor time of the fastest of several runs: where the machine is busy
with other things, the processor's is the one to read. "of one" is how many times as many clips a second a batch has as
one clip by itself; "of release" the same against the released code's single clip, timed elsewhere: read it as a scale.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from engines import features
from engines.features import Codec, Source
from engines.features.official_humanml3d import HUMANML3D as RELEASED
from engines.geometry import inverse, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

FRAMES, CLIPS = 200, 32
RELEASE_MS = {"encode": 14.76, "positions": 0.24, "rotations": 1.68}
"""The released code's 200 frames to 263 numbers, back to positions, and back to positions by its rotations."""


def made_up(fps: float) -> Motion:
    """Every joint swings at its own pace, the body walks and turns."""
    rng = np.random.default_rng(0)
    times = np.arange(FRAMES)[:, None, None] / fps
    turns = rotations.rotvec_to_quaternion(rng.normal(size=(22, 3)) * 0.4 * np.sin(times * rng.uniform(1, 6, (22, 1))))
    turns[:, 0] = rotations.multiply(rotations.yaw_quaternion(times[:, 0, 0]), turns[:, 0])
    path = np.stack([times[:, 0, 0], np.full(FRAMES, 0.9), np.sin(times[:, 0, 0])], axis=-1)
    return Motion(SMPL22, turns, path, fps)


def best(work: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Milliseconds of the fastest of several runs: wall and processor time, each its own fastest."""
    wall, busy = [], []
    for _ in range(repeats):
        began, used = time.perf_counter(), time.process_time()
        work()
        wall.append(time.perf_counter() - began)
        busy.append(time.process_time() - used)
    return min(wall) * 1e3, min(busy) * 1e3


def row(name: str, one: Callable[[], object], many: Callable[[], object] | None, release: float | None = None) -> None:
    """One line: a clip by itself, a batch, and the ratios, all of processor time."""
    wall, busy = best(one, 25)
    line = f"{name:<40}{wall:>10.2f}{busy:>10.2f}"
    if many is not None:
        all_wall, all_busy = best(many, 5)
        line += f"{all_wall:>11.1f}{all_busy:>10.1f}{CLIPS * busy / all_busy:>9.1f}"
        line += f"{CLIPS * release / all_busy:>12.1f}" if release else f"{'':12}"
    print(line + (f"{release / busy:>12.1f}" if release else ""))


def rows(codec: Codec, released: bool) -> None:
    motion = codec.fitted(made_up(codec.fps))
    turns, path = motion.rotations, motion.translation
    made = codec.encode(motion)
    turns32, path32, made32 = (np.repeat(value[None], CLIPS, axis=0) for value in (turns, path, made))
    against: dict[str, float] = RELEASE_MS if released else {}
    name = codec.name
    encode = lambda: codec.encode_arrays(turns32, path32)  # noqa: E731
    row(f"{name}: Motion to features", lambda: codec.encode(motion), encode, against.get("encode"))
    source: Source
    for source in codec.sources:
        many = (lambda: codec.decode_arrays(made32, source="rotations")) if source == "rotations" else None
        release = against.get("rotations") if source == "rotations" else None
        row(f"{name}: to a Motion, by {source}", lambda s=source: codec.decode(made, source=s), many, release)
    row(
        f"{name}: to positions",
        lambda: codec.positions(made),
        lambda: codec.positions(made32),
        against.get("positions"),
    )


def main() -> None:
    print(
        f"{FRAMES} frames, ms{'':<27}{'one wall':>10}{'one cpu':>10}{'32 wall':>11}{'32 cpu':>10}{'of one':>9}"
        f"{'of release':>12}{'one/release':>12}"
    )
    for name in ("humanml3d", "style", "smplh", "lie"):
        rows(features.get(name), name == "humanml3d")
    joints = made_up(20.0).positions.astype(np.float32)
    joints32 = np.repeat(joints[None], CLIPS, axis=0)

    def dialect(values: np.ndarray) -> np.ndarray:
        return RELEASED.features_of(RELEASED.uniform(values, RELEASED.offsets))

    made = dialect(joints)
    made32 = np.repeat(made[None], CLIPS, axis=0)
    row(
        "released dialect: joints to features", lambda: dialect(joints), lambda: dialect(joints32), RELEASE_MS["encode"]
    )
    row(
        "released dialect: to positions",
        lambda: RELEASED.recover_positions(made),
        lambda: RELEASED.recover_positions(made32),
        RELEASE_MS["positions"],
    )
    row("inverse kinematics alone, for scale", lambda: inverse.inverse(joints, SMPL22), None)


if __name__ == "__main__":
    main()
