"""What the evaluators see of a motion, and the convolutions they look at it with.

They see bone directions in the body's own heading: neither where the body stands nor which way it faces nor how long
its bones are. Hands are no bones of smpl22, but wrists turn: some people wave with the hand alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from engines.action2motion.representation import root_yaw
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

FPS = 20.0
BONES = 3 * (len(SMPL22) - 1)
CHANNELS = 2 * BONES + 4
"""Bone directions, how they change from frame to frame, root height and root velocity."""
HANDS = 2 * 3
"""Directions of both hands, and as many again for how they change: only the recognisers see them."""
STRIDES = (2, 1, 2, 1, 1)
"""Of the convolutions over time: half and quarter rate."""
_GAP = 2 * 4
"""Frames between two motions in a row: what the last convolutions, at quarter rate, see beyond a frame."""
LONGEST = 160
"""Frames looked at, 8 seconds; of a longer motion the middle."""


class InRow(NamedTuple):
    """Motions one behind the other, with gaps between them."""

    frames: Tensor
    """(T, C)."""
    owner: Tensor
    """(T,) which motion a frame is of; -1 in a gap."""
    count: int
    """B, how many motions there are."""


class Trunk(nn.Module):
    """Convolutions over time at half and quarter rate, pooled over the frames there are.

    Args:
        width: channels.
        dropout: share of values left out between the convolutions while training.
        channels: of a frame.
    """

    mean: Tensor
    std: Tensor

    def __init__(self, width: int, dropout: float, channels: int = CHANNELS) -> None:
        super().__init__()
        sizes = [channels, *[width] * (len(STRIDES) - 1)]
        self.convolutions = nn.ModuleList(
            nn.Conv1d(size, width, 5, stride=stride, padding=2) for size, stride in zip(sizes, STRIDES, strict=True)
        )
        self.norms = nn.ModuleList(nn.BatchNorm1d(width) for _ in STRIDES)
        self.dropout = dropout
        self.register_buffer("mean", torch.zeros(channels))
        self.register_buffer("std", torch.ones(channels))

    def scale_to(self, rows: Sequence[np.ndarray]) -> None:
        """See frames relative to the mean and deviation of these descriptions (T, C)."""
        frames = np.concatenate(rows)
        self.mean.copy_(torch.from_numpy(frames.mean(0)))
        self.std.copy_(torch.from_numpy(np.maximum(frames.std(0), 0.05)))

    def pooled(self, frames: Tensor, mask: Tensor) -> Tensor:
        """Frames (B, T, C), those that are there (B, T) -> mean, maximum and deviation over time (B, 3 * width).

        A hand that is waved differs from one that is held up in how much it moves about its mean.
        """
        x, there = self._convolved(frames, mask)
        count = there.sum(-1)
        mean = x.sum(-1) / count
        top = x.masked_fill(there == 0, -1e4).amax(-1)
        spread = ((x - mean[..., None]).square() * there).sum(-1) / count
        return torch.cat([mean, top, (spread + 1e-4).sqrt()], dim=-1)

    def pooled_in_row(self, row: InRow) -> Tensor:
        """Mean and maximum of motions one behind the other: (B, 2 * width). Several times faster: nothing is padded."""
        x, there = self._convolved(row.frames[None], row.owner[None] >= 0)
        x = x[0].mT[there[0, 0] > 0]  # (frames, width)
        owner = row.owner[:: math.prod(STRIDES)]
        owner = owner[owner >= 0]
        count = torch.bincount(owner, minlength=row.count)[:, None]
        mean = x.new_zeros(row.count, x.shape[1]).index_add(0, owner, x) / count
        top = x.new_full(mean.shape, -1e4).scatter_reduce(0, owner[:, None].expand_as(x), x, "amax")
        return torch.cat([mean, top], dim=-1)

    def _convolved(self, frames: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """(B, width, T / 4), and which of these frames are there (B, 1, T / 4): 0 or 1."""
        x = ((frames - self.mean) / self.std).mT
        there = mask[:, None].to(x)
        x = x * there
        for convolution, norm, stride in zip(self.convolutions, self.norms, STRIDES, strict=True):
            there = there[:, :, ::stride]
            made = nn.functional.gelu(norm(convolution(x))) * there
            x = made + x if made.shape == x.shape else made
            x = nn.functional.dropout(x, self.dropout, self.training)
        return x, there


def describe(motion: Motion, longest: int = LONGEST, hands: bool = False) -> np.ndarray:
    """(T, C) what the networks see of a motion, float32; brought to smpl22 and 20 fps where it is not.

    Args:
        motion: of any skeleton and rate.
        longest: frames looked at; of a longer motion the middle.
        hands: which way the hands point as well.
    """
    house = motion if motion.skeleton is SMPL22 else motion.retarget(SMPL22)
    house = house if house.fps == FPS else house.resample(FPS)
    if len(house) > longest:
        start = (len(house) - longest) // 2
        house = house[start : start + longest]
    yaw = root_yaw(house.global_rotations[:, 0])
    back = rotations.yaw_quaternion(-yaw)
    bones = house.positions[:, 1:] - house.positions[:, list(SMPL22.parents[1:])]
    bones = rotations.rotate(back[:, None], bones)
    flat = (bones / np.linalg.norm(bones, axis=-1, keepdims=True)).reshape(len(bones), -1)
    step = rotations.rotate(back[:-1], np.diff(house.positions[:, 0], axis=0))
    made = np.zeros((len(house), CHANNELS), dtype=np.float32)
    made[:, :BONES], made[1:, BONES : 2 * BONES] = flat, np.diff(flat, axis=0)
    made[:, -4] = house.positions[:, 0, 1]
    made[1:, -3:] = np.stack([step[:, 0], step[:, 2], np.diff(yaw)], axis=-1)
    return np.concatenate([made, _hands(house, back)], axis=1) if hands else made


def _hands(house: Motion, back: np.ndarray) -> np.ndarray:
    """(T, 2 * `HANDS`) where the hands point, on from the forearms at rest, and how that changes."""
    wrists = [SMPL22.index(f"{side}_wrist") for side in ("left", "right")]
    ahead = SMPL22.offsets[wrists] / np.linalg.norm(SMPL22.offsets[wrists], axis=-1, keepdims=True)
    way = np.einsum("tjab,jb->tja", house.global_rotations[:, wrists], ahead)
    way = rotations.rotate(back[:, None], way).reshape(len(house), -1)
    return np.concatenate([way, np.diff(way, axis=0, prepend=way[:1])], axis=1).astype(np.float32)


def pad(rows: Sequence[np.ndarray]) -> tuple[Tensor, Tensor]:
    """Descriptions of different lengths as one batch (B, T, C), the last frame held, and a mask (B, T)."""
    longest = max(len(row) for row in rows)
    frames = np.stack([row[np.minimum(np.arange(longest), len(row) - 1)] for row in rows])
    mask = np.arange(longest) < np.array([len(row) for row in rows])[:, None]
    return torch.from_numpy(frames), torch.from_numpy(mask)


def in_row(rows: Sequence[np.ndarray]) -> InRow:
    """Descriptions one behind the other, so far apart that no convolution sees two of them."""
    step = math.prod(STRIDES)
    starts = np.cumsum([0] + [step * -(-(len(row) + _GAP) // step) for row in rows])
    frames = np.zeros((starts[-1], CHANNELS), dtype=np.float32)
    owner = np.full(starts[-1], -1)
    for index, (start, row) in enumerate(zip(starts, rows, strict=False)):
        frames[start : start + len(row)] = row
        owner[start : start + len(row)] = index
    return InRow(torch.from_numpy(frames), torch.from_numpy(owner), len(rows))


def sampled(row: np.ndarray, at: np.ndarray, speed: float) -> np.ndarray:
    """A description (T, C) read between its frames at times `at` (S,), as if moving `speed` times as fast: (S, C)."""
    low = np.clip(at, 0, len(row) - 1).astype(int)
    share = (np.clip(at, 0, len(row) - 1) - low)[:, None].astype(np.float32)
    made = (1 - share) * row[low] + share * row[np.minimum(low + 1, len(row) - 1)]
    return quickened(made, speed)


def quickened(made: np.ndarray, speed: float) -> np.ndarray:
    """A description (T, C) whose changes are `speed` times as fast; changed in place."""
    made[:, BONES : 2 * BONES] *= speed
    made[:, CHANNELS - 3 : CHANNELS] *= speed
    made[:, CHANNELS + HANDS :] *= speed
    return made
