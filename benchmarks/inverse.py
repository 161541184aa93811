"""What positions -> rotations costs for a 10 s clip, beside the forward kinematics it undoes.

Run: python benchmarks/inverse.py [clip.bvh]. Without a file, the clip is made up.
"""

from __future__ import annotations

import sys

import numpy as np
from clock import best

from engines.formats import bvh
from engines.geometry import inverse, kinematics, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

SECONDS = 10.0
REPEATS = 7


def made_up(fps: float) -> Motion:
    """Every joint swings at its own pace."""
    rng = np.random.default_rng(0)
    times = np.arange(int(SECONDS * fps))[:, None, None] / fps
    swing = rng.normal(size=(22, 3)) * 0.5 * np.sin(times * rng.uniform(1, 6, (22, 1)))
    return Motion(SMPL22, rotations.rotvec_to_quaternion(swing), np.zeros((len(times), 3)), fps)


def row(name: str, motion: Motion) -> None:
    positions, skeleton = motion.positions, motion.skeleton
    local = rotations.quaternion_to_matrix(motion.rotations)
    forward = best(
        lambda: kinematics.forward_kinematics(local, motion.translation, skeleton.offsets, skeleton.parents), REPEATS
    )
    back = best(lambda: inverse.inverse(positions, skeleton), REPEATS)
    error = np.abs(Motion.from_positions(positions, skeleton, motion.fps).positions - positions).max()
    print(
        f"{name:<24}{len(motion):>7}{len(skeleton):>8}{forward:>13.2f}{back:>13.2f}{back / forward:>9.1f}"
        f"{motion.duration * 1e3 / back:>15.0f}{error * 1e3:>13.1e}"
    )


def main() -> None:
    print(
        f"{'clip':<24}{'frames':>7}{'joints':>8}{'forward, ms':>13}{'inverse, ms':>13}{'ratio':>9}"
        f"{'x real time':>15}{'error, mm':>13}"
    )
    for fps in (20.0, 60.0, 120.0):
        row(f"{SECONDS:g} s made up, {fps:g} fps", made_up(fps))
    for path in sys.argv[1:]:
        motion = bvh.read(path)
        row(path.rsplit("/", 1)[-1], motion[1 : 1 + int(SECONDS * motion.fps)])


if __name__ == "__main__":
    main()
