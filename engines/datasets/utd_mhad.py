"""UTD-MHAD skeletons (Chen, Jafari, Kehtarnavaz 2015): 27 actions, 8 subjects, Kinect v1. Research use; cite.

The depth camera is noisy: joints jump and limbs stretch. Clips are smoothed, and rejected where that cannot help.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from engines.datasets.corpus import ClipInfo, to_house
from engines.errors import FormatError
from engines.formats import utd_mat
from engines.geometry import canonical, retarget, rotations
from engines.motion import Motion, Segment
from engines.skeletons import roles

_ACTIONS = (
    "swipe left", "swipe right", "wave right hand", "clap", "throw", "cross arms", "basketball shot", "draw x",
    "draw circle clockwise", "draw circle counterclockwise", "draw triangle", "bowling", "boxing", "baseball swing",
    "tennis swing", "arm curl", "tennis serve", "push", "knock", "catch", "pick up and throw", "jog in place",
    "walk in place", "stand up", "sit down", "lunge", "squat",
)  # fmt: skip
_FILE = re.compile(r"a(\d+)_s(\d+)_t(\d+)_skeleton\.mat")
_SMOOTHING = 1.2
"""Gaussian standard deviation in frames of 30 Hz."""
_STRETCH_LIMIT = 0.35
"""Largest accepted standard deviation of a limb's length, as a share of it."""


_REACH_NOISE = 0.02
"""Share of a leg's length that its measured span varies by while it is straight."""
_KNEE_AHEAD = 0.1
"""Pull of the knee to the front, in leg lengths: decides where the measured knee lies on the line."""


class UTDMHAD:
    """861 sequences in the full set, each one action from start to end."""

    name = "utd-mhad"
    archive = "utd-mhad-skeletons.tar.xz"
    licence = "research use; cite Chen, Jafari, Kehtarnavaz 2015"
    download = "https://personal.utdallas.edu/~kehtar/UTD-MHAD.html"
    layout = "the archive, or a folder with aA_sS_tT_skeleton.mat"

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every `a{action}_s{subject}_t{trial}_skeleton.mat` under the folder."""
        for path in sorted(folder.rglob("a*_s*_t*_skeleton.mat")):
            match = _FILE.fullmatch(path.name)
            if match and 1 <= int(match[1]) <= len(_ACTIONS):
                yield ClipInfo(
                    self.name, path.stem.removesuffix("_skeleton"), path, _ACTIONS[int(match[1]) - 1], subject=match[2]
                )

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`, smoothed; a broken one is an error that says what is wrong with it."""
        points, fps = utd_mat.read_points(clip.path)
        points = {role: points[joint] for role, joint in _roles(points).items()}
        if len(points["pelvis"]) < 10:
            raise FormatError(clip.path, "fewer than 10 frames")
        _check_limbs(clip.path, points)
        smooth = {
            role: gaussian_filter1d(_without_spikes(value), _SMOOTHING, axis=0, mode="nearest")
            for role, value in points.items()
        }
        for side in ("left", "right"):
            smooth |= bent_leg(smooth, side)
        motion = _grounded(retarget.from_points(smooth, fps))
        labels = (Segment(0, len(motion), "action", clip.action),) if clip.action else ()
        return to_house(motion.replaced(labels=labels))


def bent_leg(points: dict[str, np.ndarray], side: str) -> dict[str, np.ndarray]:
    """Knee and ankle (T, 3) of a leg, bent as far as the hip has come down to the ankle.

    Seen from the front, the camera takes a bent knee for one too near the line from hip to ankle, and both bones for
    shorter than they are: their directions alone make a deep squat a shallow one. How near hip and ankle have come is
    measured well, so with bones of fixed length that says how far the knee bends, and the measured knee only where to.
    """
    hip, knee, ankle = (points[f"{side}_{joint}"] for joint in ("hip", "knee", "ankle"))
    down = ankle - hip
    reach = np.linalg.norm(down, axis=-1, keepdims=True)
    straight = np.quantile(reach, 0.8)
    thigh, shin = (np.quantile(np.linalg.norm(b - a, axis=-1), 0.8) for a, b in ((hip, knee), (knee, ankle)))
    thigh, shin = straight * thigh / (thigh + shin), straight * shin / (thigh + shin)
    # what differs from a straight leg by no more than noise stays straight
    bent = np.maximum(0.0, 1 - reach / straight - _REACH_NOISE)
    span = straight * np.clip(1 - bent, 0.25, 1.0)
    axis = down / reach
    ahead = np.cross(points["left_hip"] - points["right_hip"], [0.0, 1.0, 0.0])
    lean = _across(knee - hip, axis) + _KNEE_AHEAD * straight * _across(rotations.normalise(ahead), axis)
    along = (thigh**2 - shin**2 + span**2) / (2 * span)
    out = np.sqrt(np.maximum(thigh**2 - along**2, 0.0))
    return {
        f"{side}_knee": hip + along * axis + out * rotations.normalise(lean),
        f"{side}_ankle": hip + span * axis,
    }


def _across(vectors: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """What of vectors (T, 3) is at right angles to unit vectors."""
    return vectors - (vectors * axis).sum(-1, keepdims=True) * axis


def _without_spikes(path: np.ndarray) -> np.ndarray:
    """A joint's path (T, 3) without single frames that jump."""
    return median_filter(path, size=(3, 1), mode="nearest")


def _grounded(motion: Motion) -> Motion:
    """Every frame set down on its lowest foot: nobody leaves the ground in these actions for long, and the camera's
    tilt and noise lift people who step towards it by tens of centimetres."""
    feet = [motion.skeleton.index(name) for foot in motion.skeleton.feet for name in foot]
    lowest = motion.positions[:, feet, 1].min(axis=1) - canonical.toe_clearance(motion.skeleton)
    path = np.array(motion.translation)
    path[:, 1] -= gaussian_filter1d(lowest, 2.0, mode="nearest")
    return motion.replaced(translation=path)


def _roles(joints: Iterable[str]) -> dict[str, str]:
    """Roles of Kinect joints. Its spine lies a few centimetres above the hips, too near to tell a direction."""
    known = roles.recognise(tuple(joints))
    return {**{role: joint for role, joint in known.items() if joint != "spine"}, "neck": "shoulder_center"}


def _check_limbs(path: Path, points: dict[str, np.ndarray]) -> None:
    """Refuse a clip whose limbs change length more than Kinect noise explains."""
    for side in ("left", "right"):
        for near, far in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")):
            length = np.linalg.norm(points[f"{side}_{near}"] - points[f"{side}_{far}"], axis=-1)
            stretch = float(length.std() / max(float(length.mean()), 1e-6))
            if stretch > _STRETCH_LIMIT:
                limit = f"(limit {_STRETCH_LIMIT:.0%})"
                raise FormatError(path, f"{side} {near}-{far} changes length by {stretch:.0%} {limit}")
