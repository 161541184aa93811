"""HumanML3D's representation: 263 numbers a frame for 22 joints, 251 for KIT-ML's 21 (Guo et al. 2022, section 5).

A pose is (turning, step x and z, height of the root, positions, rotations, velocities, foot contacts), all of them in
the frame of the body's own heading, so that neither place nor direction matters.

**What ours says where the paper leaves it open or the released code slips** (`official_humanml3d` has the release):

- heading: across hips, collars and shoulders, of each frame by itself, so that features can be made of a stream. The
  release smooths it over 161 frames and subtracts the hips where it means to add them.
- `yaw_velocity` is the angle turned; the release keeps half of it and loses its sign where the heading passes -z.
- `root_velocity` is in the heading of its own frame, as `velocities` are; in the release, of the next.
- `rotations` are those of the Motion, parent-relative, one for each joint but the root; the joints that hang from
  the root are relative to the heading. So twists, hands and head come back as they were. In the release they turn fixed
  axes onto bones by the shortest way, which knows no twist, and hold the heading twice.
- contacts have a height as well as a speed, `geometry.contacts`.

**Which source to decode from.** `source="rotations"` takes the 6-D part and reads the root's own tilt from where hips
and lower spine are; `source="positions"` puts the positions through `geometry.inverse`. Measured on the prepared clips
by `scripts/features_round_trip.py`, and the time by `benchmarks/features.py`:

| | rotations | positions |
|---|---|---|
| joints, features as encoded, worst clip | 0.0007 mm | 0.0007 mm |
| turns of joints, features as encoded | 0.000 degrees | 5.4 degrees: twists are guessed, hands and feet follow |
| joints, noise of a tenth of each part's deviation | 11.3 mm | 11.7 mm |
| feet, the same noise | 16.2 mm | 13.8 mm |
| turns of joints, the same noise | 1.7 degrees | 8.9 degrees |
| processor time, 200 frames | 0.6 ms | 9.6 ms |

So "rotations" is the one to choose, for anything that is skinned above all. "positions" keeps feet a little closer, and
is for features whose rotations are not to be trusted: of a network not trained on them, or of the released dialect,
whose rotations know no twist.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engines.features import arrays, heading
from engines.features.heading import HeadingCodec
from engines.features.layout import EMPHASIS, Layout, Part
from engines.features.skeletons import KIT21
from engines.skeletons import SMPL22, Skeleton


def layout(joints: int) -> Layout:
    """The parts of a body of `joints` joints: 263 numbers for 22, 251 for 21."""
    return Layout(
        (
            Part("yaw_velocity", (1,), EMPHASIS),
            Part("root_velocity", (2,), EMPHASIS),
            Part("root_height", (1,), EMPHASIS),
            Part("positions", (joints - 1, 3)),
            Part("rotations", (joints - 1, 6)),
            Part("velocities", (joints, 3)),
            Part("contacts", (4,), EMPHASIS),
        )
    )


@dataclass(frozen=True, eq=False)
class HumanML3D(HeadingCodec):
    """Features of a body whose hips and lower spine hang from its root."""

    name: str
    skeleton: Skeleton
    fps: float

    @cached_property
    def layout(self) -> Layout:  # type: ignore[override]
        """As `layout(joints)`."""
        return layout(len(self.skeleton))

    def write_pose(self, body: heading.Bodies, features: np.ndarray) -> None:
        """See `HeadingCodec.write_pose`."""
        slopes = arrays.slopes(body.local[:, :, 1:])
        for child in self.skeleton.children[0]:
            for column in (0, 1):
                seen = arrays.unyaw(body.world[:, column, child], body.cosine, body.sine)
                slopes[3 * column : 3 * column + 3, child - 1] = seen
        planes = {
            "positions": heading.local_joints(body)[:, 1:],
            "rotations": slopes,
            "velocities": heading.world_steps(body),
        }
        for name, values in planes.items():
            part = self.layout.read(features, name)
            part[...] = values.transpose(2, 1, 0).reshape(part.shape)

    def pose_quaternions(self, features: np.ndarray) -> np.ndarray:
        """See `HeadingCodec.pose_quaternions`."""
        stored = arrays.planes(self.layout.read(features, "rotations"))
        quaternions = np.empty((4, len(self.skeleton), len(features)), np.float32)
        quaternions[:, 1:] = arrays.rotation_to_quaternion(*arrays.rot6d_to_columns(stored))
        quaternions[:, 0] = tilt = self._root_tilt(self.layout.read(features, "positions"))
        children = list(self.skeleton.children[0])
        quaternions[:, children] = arrays.multiply(arrays.invert(tilt)[:, None], quaternions[:, children])
        return quaternions

    def _root_tilt(self, joints: np.ndarray) -> np.ndarray:
        """(4, N) the root's rotation against the heading, told by where hips and spine are, joints (N, J - 1, 3)."""
        chosen = [self.skeleton.index(name) - 1 for name in ("left_hip", "right_hip", "spine1")]

        def frame(points: np.ndarray) -> np.ndarray:
            left, right, spine = points
            return np.stack(arrays.rot6d_to_columns(np.concatenate([left - right, spine - (left + right) / 2])), axis=1)

        seen = frame(np.ascontiguousarray(joints[:, chosen].transpose(1, 2, 0)))
        rest = frame(self.skeleton.offsets[1:][chosen].astype(np.float32)[..., None])
        turned = arrays.compose(seen, rest.swapaxes(0, 1))
        return arrays.rotation_to_quaternion(turned[:, 0], turned[:, 1], turned[:, 2])

    def local_positions(self, features: np.ndarray) -> np.ndarray:
        """See `HeadingCodec.local_positions`."""
        held = self.layout.read(features, "positions")
        places = np.zeros((*held.shape[:-2], len(self.skeleton), 3), np.float32)
        places[..., 0, 1] = features[..., self.layout["root_height"]][..., 0]
        places[..., 1:, :] = held
        return places


HUMANML3D = HumanML3D("humanml3d", SMPL22, 20.0)
"""263 numbers a frame on the house skeleton, 20 frames a second."""
KIT = HumanML3D("kit", KIT21, 12.5)
"""251 numbers a frame on KIT-ML's 21 joints, 12.5 frames a second."""
