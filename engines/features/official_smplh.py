"""MultiAct's 315 numbers and its face-front canonicalisation as the released code has them, slips included.

Kept for the authors' checkpoint; everything else uses `smplh`. Source: the transforms of the release, as described by
its reference numbers. What departs from the paper and from ours:

- the world is Z up (AMASS), the root of a body about SMPL's own origin;
- canonicalisation takes the heading out as the first of three ZYX Euler angles, tilts everything by 1e-5 radians about
  x on top, and sets the anchor's place to zero, its height included: the paper keeps "the ground geometry";
- 6-D goes in as the first two ROWS of a matrix, one after the other, and comes out as two interleaved COLUMNS: what
  goes in does not come out the same (`read_rot6d(write_rot6d(R))` is not R).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from engines.features.codec import Source, Start
from engines.features.skeletons import SMPLH52
from engines.features.smplh import SMPLH
from engines.geometry import rotations

TILT = 1e-5
"""Radians about x that come with every canonicalisation."""
_Z_UP = rotations.rotvec_to_quaternion(np.array([np.pi / 2, 0.0, 0.0]))
"""Turns Y up to Z up."""


def euler_zyx(matrices: np.ndarray) -> np.ndarray:
    """Intrinsic ZYX angles (..., 3), radians, of rotations (..., 3, 3): the first is the heading of a Z up body."""
    return rotations.quaternion_to_euler(rotations.matrix_to_quaternion(matrices), "ZYX")


def face_front_align(matrices: np.ndarray, translation: np.ndarray, anchor: int) -> tuple[np.ndarray, np.ndarray]:
    """A motion as the release canonicalises it: global rotations and translations, Z up.

    Args:
        matrices: (..., T, 3, 3) global rotations.
        translation: (..., T, 3).
        anchor: the frame that faces front, at zero.

    Returns:
        The same, turned and shifted. Joint rotations do not change.
    """
    heading = euler_zyx(matrices[..., anchor, :, :])[..., 0]
    turn = Rotation.from_rotvec([TILT, 0.0, 0.0]).as_matrix() @ _about_z(-heading)
    shifted = translation - translation[..., anchor, None, :]
    return turn[..., None, :, :] @ matrices, shifted @ np.swapaxes(turn, -1, -2)


def to_front_view(matrices: np.ndarray) -> np.ndarray:
    """Global rotations (..., 3, 3), each with its own heading taken out."""
    return _about_z(-euler_zyx(matrices)[..., 0]) @ matrices


def to_right_view(matrices: np.ndarray) -> np.ndarray:
    """Global rotations (..., 3, 3), all turned a quarter to the left."""
    return _about_z(np.array(np.pi / 2)) @ matrices


def _about_z(angle: np.ndarray) -> np.ndarray:
    """(...) radians -> (..., 3, 3)."""
    return rotations.rotvec_to_matrix(np.asarray(angle)[..., None] * np.array([0.0, 0.0, 1.0]))


def write_rot6d(matrices: np.ndarray) -> np.ndarray:
    """(..., 3, 3) -> (..., 6) as networks are fed: the first two rows, one after the other."""
    return np.concatenate([matrices[..., 0, :], matrices[..., 1, :]], axis=-1)


def read_rot6d(rot6d: np.ndarray) -> np.ndarray:
    """(..., 6) of a network -> (..., 3, 3): elements 0, 2, 4 are the first column and 1, 3, 5 the second."""
    return rotations.rot6d_to_matrix(np.concatenate([rot6d[..., 0::2], rot6d[..., 1::2]], axis=-1))


def unwrite_rot6d(rot6d: np.ndarray) -> np.ndarray:
    """(..., 6) of `write_rot6d` -> (..., 3, 3): what the release never does."""
    return np.swapaxes(rotations.rot6d_to_matrix(rot6d), -1, -2)


@dataclass(frozen=True, eq=False)
class OfficialSMPLH(SMPLH):
    """What the authors' network is fed, and what it gives: two layouts of the same 315 numbers.

    `encode` writes rows and `decode` reads interleaved columns, as the network's input and output are; `decode` of what
    `encode` gave is another motion. `decode_input` is the way back from `encode`.
    """

    name: str = "smplh-official"

    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """See `Codec.encode_arrays`: Z up, rows."""
        matrices = np.broadcast_to(np.eye(3), (*turns.shape[:-2], len(SMPLH52), 3, 3)).copy()
        held = [SMPLH52.index(name) for name in self.skeleton.joints]
        turns = np.array(turns)
        turns[..., 0, :] = rotations.multiply(_Z_UP, turns[..., 0, :])
        matrices[..., held, :, :] = rotations.quaternion_to_matrix(turns)
        slopes = write_rot6d(matrices)
        place = rotations.rotate(_Z_UP, np.asarray(path) + self.skeleton.offsets[0])
        return self.layout.join(root_rotation=slopes[..., 0, :], rotations=slopes[..., 1:, :], translation=place)

    def decode_arrays(
        self, features: np.ndarray, *, source: Source, start: Start | None = None
    ) -> tuple[np.ndarray, np.ndarray, Start]:
        """See `Codec.decode_arrays`: Z up, interleaved columns."""
        return self._decode(features, read_rot6d, source, start)

    def decode_input(self, features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Quaternions (..., T, J, 4) and path (..., T, 3) of what `encode` wrote."""
        turns, path, _ = self._decode(features, unwrite_rot6d, "rotations", None)
        return turns, path

    def _decode(self, features, reader, source: Source, start: Start | None) -> tuple[np.ndarray, np.ndarray, Start]:
        parts = self.layout.split(np.array(features, dtype=np.float64))
        matrices = reader(np.concatenate([parts["root_rotation"][..., None, :], parts["rotations"]], axis=-2))
        back = rotations.quaternion_to_matrix(rotations.invert(_Z_UP))
        matrices[..., 0, :, :] = back @ matrices[..., 0, :, :]
        slopes = rotations.matrix_to_rot6d(matrices)
        upright = self.layout.join(
            root_rotation=slopes[..., 0, :],
            rotations=slopes[..., 1:, :],
            translation=rotations.rotate(rotations.invert(_Z_UP), parts["translation"]),
        )
        return super().decode_arrays(upright, source=source, start=start)


SMPLH_OFFICIAL = OfficialSMPLH()
"""315 numbers a frame on the house skeleton, 20 frames a second."""
