"""MultiAct's representation: 315 numbers a frame, SMPL-H's rotations and the root's place (Lee et al. 2023).

The global rotation and 51 joint rotations in 6-D (two columns, Zhou et al. 2019) and the root's translation, 20 frames
a second. Nothing is taken out but where the paper does: its motions are face-front canonicalised first, which is
`Motion.face_front(anchor)` (heights are kept: the paper's "share the ground geometry"), and so is `encode(anchor=...)`.

Ours is Y up as all of the project, and writes and reads its 6-D the same way. `official_smplh` has the release: Z up,
6-D written as rows and read as interleaved columns, heights taken out.

Fingers have rotations here and no joints in the house skeleton: they are written as straight, and read past. Bodies
that have them by SMPL-H's names keep theirs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from engines.features import arrays
from engines.features.codec import Codec, Source, Start, continuous, joints_of
from engines.features.layout import Layout, Part
from engines.features.skeletons import SMPLH52
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton

_STRAIGHT = np.array([1, 0, 0, 0, 1, 0], np.float32)
"""The 6-D of no rotation."""


@dataclass(frozen=True, eq=False)
class SMPLH(Codec):
    """Features of any body whose joints have SMPL-H's names, the house skeleton by default."""

    name: str = "smplh"
    skeleton: Skeleton = SMPL22
    fps: float = 20.0
    layout: ClassVar[Layout] = Layout(
        (
            Part("root_rotation", (6,)),
            Part("rotations", (len(SMPLH52) - 1, 6)),
            Part("translation", (3,)),
        )
    )
    sources: ClassVar[tuple[Source, ...]] = ("rotations",)

    def encode(self, motion: Motion, anchor: int | None = None) -> np.ndarray:
        """A Motion as features (T, 315) float32, brought to the codec's skeleton and rate first.

        Args:
            motion: any.
            anchor: a frame, of the codec's rate, at which the body is made to face +Z above the origin; by default it
                is left where it stands.

        Raises:
            SkeletonError: a skeleton that cannot be retargeted.
        """
        fitted = self.fitted(motion)
        if anchor is not None:
            fitted = fitted.face_front(anchor)
        return self.encode_arrays(fitted.rotations, fitted.translation)

    def start(self, motion: Motion) -> Start:
        """The origin: these features say where the body is."""
        return Start()

    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """See `Codec.encode_arrays`; there are no contacts among the features."""
        lead = turns.shape[:-2]
        matrices = arrays.quaternion_to_matrix(arrays.planes(turns))
        slopes = arrays.unplanes(arrays.slopes(matrices), lead)
        held = [name for name in SMPLH52 if name in self.skeleton]
        rotations = np.empty((*lead, len(SMPLH52), 6), np.float32)
        rotations[...] = _STRAIGHT
        rotations[..., [SMPLH52.index(name) for name in held], :] = slopes[..., list(map(self.skeleton.index, held)), :]
        place = np.asarray(path) + self.skeleton.offsets[0]
        return self.layout.join(root_rotation=rotations[..., 0, :], rotations=rotations[..., 1:, :], translation=place)

    def decode_arrays(
        self, features: np.ndarray, *, source: Source, start: Start | None = None
    ) -> tuple[np.ndarray, np.ndarray, Start]:
        """See `Codec.decode_arrays`."""
        self.check_source(source)
        start = start or Start()
        slopes = np.concatenate(
            [self.layout.read(features, "root_rotation")[..., None, :], self.layout.read(features, "rotations")],
            axis=-2,
        )
        held = [SMPLH52.index(name) for name in self.skeleton.joints]
        columns = arrays.rot6d_to_columns(arrays.planes(slopes[..., held, :]))
        turns = arrays.unplanes(arrays.rotation_to_quaternion(*columns), features.shape[:-1]).astype(np.float64)
        turn = rotations.yaw_quaternion(np.asarray(start.yaw))
        turns[..., 0, :] = rotations.multiply(turn[..., None, :], turns[..., 0, :])
        path = rotations.rotate(turn[..., None, :], self.layout.read(features, "translation"))
        path[..., [0, 2]] += np.asarray(start.ground)[..., None, :]
        return continuous(turns), path - self.skeleton.offsets[0], start

    def positions(self, features: np.ndarray, start: Start | None = None) -> np.ndarray:
        """Joint positions (..., T, J, 3) float32, metres, by forward kinematics."""
        turns, path, _ = self.decode_arrays(features, source="rotations", start=start)
        return joints_of(turns, path, self.skeleton)


SMPLH_HOUSE = SMPLH()
"""315 numbers a frame on the house skeleton, 20 frames a second."""
