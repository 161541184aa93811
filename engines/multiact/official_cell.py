"""The authors' checkpoint as a cell of the engine: what the release does in a recurrent step, Motions in and out.

The checkpoint (.pth, .pt, .tar or .safetensors) tells no names of its labels. A file `labels.json` beside it may, as
{"walk": 2, "sit": 17, ...} into the table of labels; without it they are "action 0", "action 1", ... Lengths were
means over the release's data, which it does not contain: a transition takes 8 frames if it is not said, an action 40.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from engines.errors import CheckpointError
from engines.features import official_smplh
from engines.features.official_smplh import SMPLH_OFFICIAL
from engines.geometry import canonical, rotations
from engines.motion import Motion
from engines.multiact import official
from engines.multiact.official import JOINTS, SEEN, SLOTS, TRANSITION, OfficialMACVAE, Slots
from engines.text2motion.official_weights import read_states

_DROPPED = 2
"""Frames at the end of a step that empty slots have reached into."""
_USUAL: tuple[int, int, int] = (20, 48, 60)
_USUAL_TRANSITION = 8


class OfficialCell:
    """The released networks.

    Args:
        model: of `official.build`.
        labels: name -> place in the table of labels; "action i" if none.
    """

    sees = 48
    longest = SLOTS - sees - _DROPPED - SEEN

    def __init__(self, model: OfficialMACVAE, labels: Mapping[str, int] | None = None) -> None:
        self.model = model.requires_grad_(False)
        count = model.encoder.action_embed.num_embeddings
        told = labels or {f"action {label}": label for label in range(count) if label != TRANSITION}
        if wrong := [name for name, label in told.items() if not 0 <= label < count]:
            raise CheckpointError(f"labels {', '.join(wrong[:3])} lie outside the checkpoint's table of {count}.")
        self.names = tuple(told)
        self.usual = (_USUAL,) * len(told)
        self._labels = tuple(told.values())

    def advance(
        self, previous: Motion, action: int, frames: int, transition: int | None, rng: np.random.Generator
    ) -> tuple[Motion, int]:
        """See `Cell.advance`. Heights are those of the previous motion's end, as the release takes them out."""
        transition = min(_USUAL_TRANSITION if transition is None else transition, frames // 2)
        features = SMPLH_OFFICIAL.encode(previous)
        slopes = features[:, :-3].reshape(len(features), JOINTS, 6)
        matrices, place = official_smplh.unwrite_rot6d(slopes), features[:, -3:].astype(np.float64)
        lengths = (len(previous), transition, frames - transition + _DROPPED)
        labels = (self._labels[action], TRANSITION, self._labels[action])
        noise = rng.standard_normal((1, 2, self.model.encoder.bn.num_features), dtype=np.float32)
        made = recur(self.model, matrices, place, lengths, labels, torch.from_numpy(noise))
        new = made[len(previous) : len(previous) + frames].numpy()
        front = SMPLH_OFFICIAL.decode(new, source="rotations").face_front()
        placement = canonical.face_front(previous, len(previous) - 1)[1]
        set_down = placement.restore(front)
        gap = previous.translation[-1, 1] - set_down.translation[0, 1]
        return set_down.moved((0.0, float(gap), 0.0)), transition


@torch.inference_mode()
def recur(  # noqa: PLR0913, PLR0917 - a step of the release
    model: OfficialMACVAE, matrices: np.ndarray, place: np.ndarray, lengths: tuple[int, int, int],
    labels: tuple[int, int, int], noise: Tensor,
) -> Tensor:  # fmt: skip
    """All 120 slots (120, 315), as the networks give them, of a step of long-term generation.

    Args:
        model: of `official.build`.
        matrices: (T, 52, 3, 3) rotations of the previous motion, Z up.
        place: (T, 3).
        lengths: frames of the previous motion, the transition and the action.
        labels: of the three.
        noise: (1, 2, H).
    """
    root, place = official_smplh.face_front_align(matrices[:, 0], place, len(matrices) - 1)
    turned = np.concatenate([root[:, None], matrices[:, 1:]], axis=1)
    count = len(turned)
    pose, rows, where = torch.zeros(1, SLOTS, 3 * JOINTS), torch.zeros(1, SLOTS, 6 * JOINTS), torch.zeros(1, SLOTS, 3)
    rows[..., :] = torch.tensor([1.0, 0, 0, 0, 1, 0]).repeat(JOINTS)
    # the root's angle comes from the canonicalisation, the joints' from the networks' 6-D: half a turn at most
    angles = np.concatenate([whole_angle(root)[:, None], rotations.matrix_to_rotvec(matrices[:, 1:])], axis=1)
    pose[0, :count] = torch.from_numpy(angles).float().flatten(1)
    rows[0, :count] = torch.from_numpy(official_smplh.write_rot6d(turned)).float().flatten(1)
    where[0, :count] = torch.from_numpy(place).float()
    slots = Slots(torch.tensor([lengths]), torch.tensor([labels]))
    z = model.priornet(pose, where, slots).sample(noise)
    whole = model.whole(rows, where, model.decoder(z, slots), slots)
    # here the release fills empty slots with the pose of rest at the origin, not with a decoded one
    empty = (slots.part == 3)[..., None]
    return model.postprocessor(torch.where(empty, torch.cat([rows, where], dim=-1), whole))[0]


def whole_angle(matrices: np.ndarray) -> np.ndarray:
    """(..., 3, 3) -> (..., 3) with PyTorch3D's choice of sign: angles up to a whole turn, not half of one."""
    quaternion = rotations.matrix_to_quaternion(matrices)
    largest = np.take_along_axis(quaternion, np.abs(quaternion).argmax(-1)[..., None], axis=-1)
    w, xyz = np.split(np.where(largest < 0, -quaternion, quaternion), [1], axis=-1)
    size = np.linalg.norm(xyz, axis=-1, keepdims=True)
    angle = 2 * np.arctan2(size, w)
    return xyz * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 2.0)


def load(path: Path) -> OfficialCell:
    """The cell of an authors' checkpoint.

    Raises:
        CheckpointError: it is missing, damaged or of another architecture; or its `labels.json` cannot be read.
    """
    named, sections = read_states(path)
    held = next((state for state in sections if "encoder.action_embed.weight" in state), named)
    held = {name.removeprefix("module."): value for name, value in held.items()}
    try:
        return OfficialCell(official.build(held).eval(), _labels(path.parent / "labels.json"))
    except CheckpointError as error:
        raise CheckpointError(f"{path}: {error}") from error


def _labels(path: Path) -> dict[str, int] | None:
    if not path.is_file():
        return None
    try:
        return {" ".join(name.lower().split()): int(label) for name, label in json.loads(path.read_text()).items()}
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise CheckpointError(f'{path}: cannot be read ({error}); accepted: {{"walk": 2, ...}}.') from error
