"""An engine on the released Action2Motion: the authors' own checkpoint in, Motions out.

`official.OfficialModel` gives joint positions as the release would; here they become Motions on the house skeleton, at
the rate of the data the checkpoint was trained on. The released networks have no rotations of their own that could be
carried over (every chain of bones starts again from the root, twists mean nothing), so the way goes through positions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from engines.action2motion.official import OfficialModel
from engines.actions import Action
from engines.errors import Cancelled, CheckpointError, UnknownLabelError, demand_whole
from engines.geometry import canonical, inverse, retarget
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22

MAX_FRAMES = 12_000
MAX_COUNT = 1024
_BATCH_FRAMES = 64 * 300
"""Frames generated together: bounds memory, and lets progress and cancel be heard."""


@dataclass(frozen=True)
class _Data:
    """What is known of a data set that the release was trained on."""

    title: str
    fps: float
    roles: Mapping[str, str]
    """Joint of `smpl22` -> joint of the release, where their names differ."""


_DATA = {
    # the paper states no rate; 20 is that of the project's other data and of later work on this set
    "humanact12": _Data("HumanAct12", 20.0, {}),
    # Kinect v2 at 30 Hz (Shahroudy et al. 2016); the crown stands for the head, which the release has not
    "ntu_vibe": _Data("NTU-RGB+D, re-annotated", 30.0, {"head": "head_top"}),
    # "down-sampled to a frequency of 12 HZ" (Guo et al. 2020, section 4.1)
    "mocap": _Data("CMU MoCap", 12.0, {"spine3": "chest"}),
}


class OfficialEngine:
    """Generates motions with a released checkpoint. Load it with `engines.load("action2motion", checkpoint=path)`.

    Args:
        model: of `OfficialModel.load`.
        weights_hash: SHA-256 of its file.

    Raises:
        CheckpointError: joints of none of the released data sets, so that nobody knows which joint is which.
    """

    name = "action2motion"
    licence = "that of the checkpoint; the authors release theirs for research"
    max_frames = MAX_FRAMES
    capabilities = frozenset({"actions", "scale_bones"})
    """No interpolation, transition or outpainting: the release has none of them."""

    def __init__(self, model: OfficialModel, weights_hash: str) -> None:
        if model.skeleton is None:
            raise CheckpointError(
                f"the checkpoint has {model.config.joints} joints, as no released data set; accepted: 24 (HumanAct12), "
                "18 (NTU-RGB+D) or 20 (CMU MoCap)"
            )
        self.model, self.skeleton = model, model.skeleton
        self.weights_hash = weights_hash
        self.variant = "official-lie" if model.config.lie else "official-plain"
        self.variants = (self.variant,)
        data = _DATA[self.skeleton.name]
        self.fps = data.fps
        self.description = f"The authors' own Action2Motion, trained on {data.title} (Guo et al. 2020)."
        self._labels = {_plain_words(label): index for index, label in enumerate(model.actions)}
        self.actions: tuple[Action, ...] = tuple(
            Action(name, f"Label {name!r} of {data.title}.", data.title) for name in self._labels
        )

    def generate(self, action: str, frames: int = 60, seed: int = 0, **options) -> Motion:
        """One motion of an action; see `generate_many`."""
        return self.generate_many(action, count=1, frames=frames, seed=seed, **options)[0]

    def generate_many(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        action: str,
        count: int = 4,
        frames: int = 60,
        seed: int = 0,
        *,
        bone_scale: Mapping[str, float] | None = None,
        progress: Callable[[int, int], None] | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of one action, in batched passes.

        Args:
            action: a name of `actions`.
            count: 1 to 1024.
            frames: 1 to 12,000 at `fps`, the rate of the data set; the release was trained on 60 (CMU MoCap: 100).
            seed: 0 to 2^63 - 1; the same seed gives the same motions, and motion i does not depend on `count`
                beyond rounding.
            bone_scale: joint -> factor for the bone that leads to it, "*" for all.
            progress: called with (motions done, count).
            cancel: asked between batches; stops with `Cancelled`.

        Returns:
            Motions on `smpl22` that stand on the floor and face +Z at their first frame.

        Raises:
            UnknownLabelError: the action is not known; the message lists the nearest.
            OutOfRangeError: a number is outside its range.
        """
        name = _plain_words(action)
        if name not in self._labels:
            raise UnknownLabelError("action", action, self._labels)
        demand_whole("count", count, 1, MAX_COUNT)
        demand_whole("frames", frames, 1, MAX_FRAMES)
        demand_whole("seed", seed, 0, 2**63 - 1)
        parameters = {"variant": self.variant, "frames": int(frames)}
        if bone_scale:
            parameters["bone_scale"] = dict(bone_scale)
        made: list[Motion] = []
        size = max(1, min(64, _BATCH_FRAMES // frames))
        for start in range(0, count, size):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {count} motions; none was kept")
            indices = range(start, min(count, start + size))
            for index, joints in zip(indices, self.joints(name, frames, seed, indices), strict=True):
                origin = Provenance(self.name, self.weights_hash, name, seed, index, parameters)
                labels = (Segment(0, frames, "action", name),)
                motion = self.motion(joints).replaced(labels=labels, provenance=origin)
                made.append(motion.scale_bones(bone_scale) if bone_scale else motion)
            if progress:
                progress(len(made), count)
        return made

    def joints(self, action: str, frames: int, seed: int, indices: range) -> np.ndarray:
        """(B, T, J, 3) what the release gives for these motions of a seed, in the units and axes of its data set."""
        streams = [self.model.noise(1, frames, (seed * 1_000_003 + index) % 2**63) for index in indices]
        label = self._labels[_plain_words(action)]
        return self.model.sample([label] * len(streams), torch.cat(streams, dim=1)).joints.numpy()

    def motion(self, joints: np.ndarray) -> Motion:
        """Joint positions (T, J, 3) of the data set -> a Motion on `smpl22`, on the floor, facing +Z at first.

        Bones get the house skeleton's lengths and point the way the positions do; the path is scaled by the legs.
        """
        places = self.skeleton.house(torch.from_numpy(np.asarray(joints, dtype=np.float64))).numpy()
        if self.skeleton.joints[: len(SMPL22)] == SMPL22.joints:
            ratio = canonical.leg_length(SMPL22) / self._leg_length(places)
            turns, path = inverse.inverse(places[:, : len(SMPL22)] * ratio, SMPL22)
            motion = Motion(SMPL22, turns, path, self.fps)
        else:
            named = dict(zip(self.skeleton.joints, places.swapaxes(0, 1), strict=True))
            points = {role: named[joint] for role, joint in _DATA[self.skeleton.name].roles.items()}
            points |= {joint: named[joint] for joint in SMPL22.joints if joint in named}
            motion = retarget.from_points(points, self.fps)
        return motion.on_ground().face_front()

    def _leg_length(self, places: np.ndarray) -> float:
        """Root to ankle along the bones of a body (T, J, 3), metres: mean of both legs, median over time."""
        lengths = self.skeleton.bone_lengths(torch.from_numpy(places)).numpy()
        legs = [self.skeleton.joints.index(f"{side}_{part}") for side in _SIDES for part in _LEG]
        return max(float(np.median(lengths[:, legs].sum(-1))) / 2, 1e-3)


_SIDES, _LEG = ("left", "right"), ("hip", "knee", "ankle")


def load_official_engine(path: str | Path) -> OfficialEngine:
    """The engine of an authors' checkpoint.

    Args:
        path: see `official.load_official`.

    Raises:
        CheckpointError: the file is missing, damaged or of another architecture.
    """
    path = Path(path)
    model = OfficialModel.load(path)
    try:
        return OfficialEngine(model, hashlib.sha256(path.read_bytes()).hexdigest())
    except CheckpointError as error:
        raise CheckpointError(f"{path}: {error}") from error


def _plain_words(label: str) -> str:
    """ "Warm_up" -> "warm up": how the studio writes actions."""
    return " ".join(str(label).lower().replace("_", " ").split())
