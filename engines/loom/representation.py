"""How Loom sees a Motion: local rotations and root velocity, and where the body is and faces as seen from its start.

Velocity makes for smooth steps and feet that stand; place and facing make a path on the floor, or a pose at a place,
plain things to be told. Both are predicted, and `decode` brings them together. A window's first frame is its start:
above the origin, facing +Z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from scipy.linalg import solveh_banded
from torch import Tensor

from engines.action2motion.representation import encode as encode_house
from engines.action2motion.representation import root_yaw
from engines.features.layout import Layout, Part
from engines.geometry import planes, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

JOINTS = len(SMPL22)
LAYOUT = Layout((
    Part("height", (1,)),  # of the root, metres
    Part("turns", (JOINTS, 6)),  # first two columns of parent-relative rotations, the root's without its yaw
    Part("velocity", (3,)),  # sideways, forward (metres a frame, as the frame before faces) and turning (radians)
    Part("contacts", (4,)),  # left ankle, left toe, right ankle, right toe stand: 0 or 1
    Part("ground", (2,)),  # x and z of the root as seen from the start, metres
    Part("facing", (2,)),  # cosine and sine of the yaw as seen from the start
))  # fmt: skip
"""What is generated of a frame."""
KNOWN = Layout((
    Part("turns", (JOINTS, 6)), Part("height", (1,)), Part("ground", (2,)), Part("facing", (2,)),
    Part("joints", (JOINTS - 1, 3)),  # of all joints but the root, as seen from the start, metres
    Part("turns_known", (JOINTS,)), Part("height_known", (1,)), Part("ground_known", (1,)), Part("facing_known", (1,)),
    Part("joints_known", (JOINTS - 1,)),
))  # fmt: skip
"""What may be known of a frame beforehand: values, zero where unknown, and which are known, 0 or 1."""
TOLD = ("turns", "height", "ground", "facing", "joints")
"""Parts of `KNOWN` that hold values; each has its mask."""

FREE, ALONG, HELD = 1e-4, 0.15, 1e6
"""How much place counts against velocity when both are brought together: where nothing is known it only stops drift
(over some 100 frames), for places are less steady than velocities and feet would slide; along a path a body sways to
either side, over some 3 frames; kept frames are kept."""


@dataclass(frozen=True)
class Frames:
    """A Motion as arrays, anywhere in the world; T frames."""

    height: np.ndarray
    """(T, 1)."""
    turns: np.ndarray
    """(T, J, 6)."""
    velocity: np.ndarray
    """(T, 3), zero in the first frame."""
    contacts: np.ndarray
    """(T, 4)."""
    ground: np.ndarray
    """(T, 2) x and z in the world."""
    yaw: np.ndarray
    """(T,) radians, unwrapped."""
    joints: np.ndarray
    """(T, J, 3) in the heading frame, above the origin."""


def frames_of(motion: Motion) -> Frames:
    """A Motion on smpl22 as arrays, at its own rate, float32."""
    found = encode_house(motion)
    columns = found.matrices[..., :2].swapaxes(-1, -2).reshape(len(motion), JOINTS, 6)
    yaw = root_yaw(motion.global_rotations[:, 0])
    ground = motion.positions[:, 0, [0, 2]]
    return Frames(
        found.height, columns, found.velocity, found.contacts, ground.astype(np.float32), yaw.astype(np.float32),
        found.positions,
    )  # fmt: skip


def from_start(
    ground: Float[Tensor, "B T 2"], yaw: Float[Tensor, "B T"]
) -> tuple[Float[Tensor, "B T 2"], Float[Tensor, "B T 2"]]:
    """World places (x, z) and yaw as seen from the first frame: ground (B, T, 2) and facing (B, T, 2)."""
    first = yaw[:, :1]
    cos, sin = torch.cos(first), torch.sin(first)
    x, z = (ground - ground[:, :1]).unbind(-1)
    turned = yaw - first
    return torch.stack([cos * x - sin * z, sin * x + cos * z], -1), torch.stack([turned.cos(), turned.sin()], -1)


def joints_from_start(
    joints: Float[Tensor, "B T J 3"], ground: Float[Tensor, "B T 2"], facing: Float[Tensor, "B T 2"]
) -> Float[Tensor, "B T J 3"]:
    """Joints in the heading frame -> as seen from the start, metres."""
    cos, sin = facing[..., None, 0], facing[..., None, 1]
    x, y, z = joints.unbind(-1)
    return torch.stack([cos * x + sin * z + ground[..., None, 0], y, cos * z - sin * x + ground[..., None, 1]], dim=-1)


def kinematics(turns: Float[Tensor, "*batch J 6"], height: Float[Tensor, "*batch 1"]) -> Float[Tensor, "*batch J 3"]:
    """Joints in the heading frame, above the origin, metres, from rotations' columns and root height."""
    shape = turns.shape[:-2]
    flat = turns.reshape(-1, JOINTS, 6).permute(2, 1, 0).contiguous()  # (N, J, 6) -> (6, J, N)
    offsets = torch.tensor(SMPL22.offsets, dtype=turns.dtype, device=turns.device)
    places = planes.joints(planes.from_rot6d(flat), offsets, SMPL22.parents).permute(2, 1, 0)  # (3, J, N) -> (N, J, 3)
    return places.reshape(*shape, JOINTS, 3) + torch.nn.functional.pad(height, (1, 1))[..., None, :]


def decode(
    features: Float[np.ndarray, "T D"], held: Float[np.ndarray, "T 2"] | None = None
) -> tuple[Float[np.ndarray, "T J 4"], Float[np.ndarray, "T 3"]]:
    """Quaternions and root path (as seen from the start) of features (T, D), not normalised.

    Args:
        features: as `LAYOUT` has it.
        held: as in `travelled`.
    """
    parts = LAYOUT.split(np.asarray(features, dtype=np.float64))
    yaw, ground = travelled(features, held)
    turns = rotations.matrix_to_quaternion(rotations.rot6d_to_matrix(parts["turns"]))
    turns[:, 0] = rotations.multiply(rotations.yaw_quaternion(yaw), turns[:, 0])
    return rotations.continuous(turns), np.stack([ground[:, 0], parts["height"][:, 0], ground[:, 1]], axis=-1)


def travelled(
    features: Float[np.ndarray, "T D"], held: Float[np.ndarray, "T 2"] | None = None
) -> tuple[Float[np.ndarray, " T"], Float[np.ndarray, "T 2"]]:
    """Yaw (T,) and places on the ground (T, 2), as seen from the start, that velocities and places agree on.

    Args:
        features: (T, D), not normalised; the first frame is the start, whatever it says.
        held: (T, 2) how much place and how much facing count: `FREE`, `ALONG` or `HELD`; free if not given.
    """
    parts = {name: np.array(part) for name, part in LAYOUT.split(np.asarray(features, dtype=np.float64)).items()}
    parts["ground"][0], parts["facing"][0] = 0.0, (1.0, 0.0)
    weight = np.full((len(features), 2), FREE) if held is None else np.array(held, dtype=np.float64)
    weight[0] = HELD
    turning = np.cumsum(np.concatenate([[0.0], parts["velocity"][1:, 2]]))
    seen = np.arctan2(parts["facing"][:, 1], parts["facing"][:, 0])
    # the turn nearest to what the velocities add up to, so that whole turns are counted
    target = turning + np.angle(np.exp(1j * (seen - turning)))
    yaw = follow(parts["velocity"][1:, 2:3], target[:, None], weight[:, 1])[:, 0]
    cos, sin = np.cos(yaw[:-1]), np.sin(yaw[:-1])
    x, z = parts["velocity"][1:, 0], parts["velocity"][1:, 1]
    step = np.stack([cos * x + sin * z, cos * z - sin * x], axis=-1)
    return yaw, follow(step, parts["ground"], weight[:, 0])


def follow(
    steps: Float[np.ndarray, "S D"], places: Float[np.ndarray, "T D"], weight: Float[np.ndarray, " T"]
) -> Float[np.ndarray, "T D"]:
    """The path p that makes |p[t+1] - p[t] - steps[t]|^2 + weight[t] |p[t] - places[t]|^2 least.

    Args:
        steps: (T - 1, D) wanted from each frame to the next.
        places: (T, D) wanted.
        weight: (T,) positive.
    """
    count = len(places)
    if count == 1:
        return np.array(places)
    diagonal = np.full(count, 2.0)
    diagonal[[0, -1]] = 1.0
    bands = np.zeros((2, count))
    bands[1], bands[0, 1:] = diagonal + weight, -1.0
    right = weight[:, None] * places
    right[1:] += steps
    right[:-1] -= steps
    return solveh_banded(bands, right)
