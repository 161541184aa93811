"""Motion tokens and Motions: there, back, and what each token alone looks like (thesis 6.3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as nnf

from engines.features.humanml3d import HUMANML3D
from engines.geometry.canonical import floor_height
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.tm2t.model import TM2T
from engines.tm2t.vocabulary import FRAMES_A_TOKEN

FPS = HUMANML3D.fps
_NEAR_FLOOR = 0.1
"""Metres; a motion whose feet stay this near the floor stands on it, any other is up somewhere on purpose."""


@dataclass(frozen=True, eq=False)
class TokenFigures:
    """What each motion token looks like when it is decoded alone."""

    codes: np.ndarray
    """(K,) their numbers."""
    positions: np.ndarray
    """(K, 4, J, 3) float32 joints of its four frames, metres, on the floor, facing +Z at first."""
    uses: np.ndarray
    """(K,) float32 shares of the training frames they stand for; NaN where that was not kept."""


@torch.no_grad()
def features_of(rows: Sequence[Tensor], model: TM2T) -> list[np.ndarray]:
    """Features (4 t, D) of motions given by their codes (t,); decoded together where they are as long."""
    made: list[np.ndarray] = [np.zeros((0, 0))] * len(rows)
    by_length: dict[int, list[int]] = {}
    for place, row in enumerate(rows):
        by_length.setdefault(len(row), []).append(place)
    for places in by_length.values():
        decoded = model.denormalised(model.tokenizer.decode(torch.stack([rows[place] for place in places])))
        for place, features in zip(places, decoded.cpu().numpy(), strict=True):
            made[place] = features
    return made


def to_motions(rows: Sequence[Tensor], model: TM2T, frames: int | None = None) -> list[Motion]:
    """Motions on `smpl22` from codes (t,) each, on the floor, facing +Z; cut to so many frames if told."""
    made = []
    for features in features_of(rows, model):
        motion = HUMANML3D.decode(features[:frames], source="rotations")
        near = abs(floor_height(motion.positions, SMPL22)) < _NEAR_FLOOR
        made.append(motion.on_ground() if near else motion)
    return made


@torch.no_grad()
def to_tokens(motion: Motion, model: TM2T) -> Tensor:
    """(t,) codes of a motion of any skeleton and rate; one shorter than four frames stands still to its end."""
    features = torch.from_numpy(HUMANML3D.encode(motion))
    if len(features) < FRAMES_A_TOKEN:
        features = nnf.pad(features.T[None], (0, FRAMES_A_TOKEN - len(features)), mode="replicate")[0].T
    return model.tokenizer.encode(model.normalised(features)[None])[0]


@torch.no_grad()
def figures(model: TM2T, codes: Sequence[int] | None = None) -> TokenFigures:
    """The gallery: every token, or some, decoded by itself."""
    chosen = torch.arange(model.config.codes) if codes is None else torch.tensor(list(codes), dtype=torch.long)
    features = model.denormalised(model.tokenizer.decode(chosen[:, None])).cpu().numpy()
    turns, path, _ = HUMANML3D.decode_arrays(features, source="rotations")
    joints = np.stack([Motion(SMPL22, t, p, FPS).positions for t, p in zip(turns, path, strict=True)])
    joints[..., 1] -= joints[..., 1].min(axis=(1, 2), keepdims=True)
    uses = getattr(model.tokenizer.codebook, "uses", None)
    share = np.full(len(chosen), np.nan) if uses is None else (uses / uses.sum().clamp_min(1e-9))[chosen].cpu().numpy()
    return TokenFigures(chosen.numpy(), joints.astype(np.float32), share.astype(np.float32))
