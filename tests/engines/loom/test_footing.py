"""Bodies go by the feet that stand."""

from __future__ import annotations

import numpy as np
import pytest

from engines.loom.footing import on_feet
from engines.loom.representation import LAYOUT, decode
from engines.motion import Motion
from engines.skeletons import SMPL22

FRAMES = 40
LEFT, RIGHT = (SMPL22.index(f"{side}_ankle") for side in ("left", "right"))


def _features(contacts: tuple[float, float, float, float], velocity: tuple[float, float, float]) -> np.ndarray:
    """A body in its rest pose, turned a little, that goes at a velocity whatever its feet do."""
    turns = np.broadcast_to(np.eye(3)[:, :2].T.reshape(6), (FRAMES, len(SMPL22), 6))
    turned = np.cumsum(np.full(FRAMES, velocity[2])) - velocity[2]
    return LAYOUT.join(
        height=np.full((FRAMES, 1), 0.95), turns=turns, velocity=np.broadcast_to(velocity, (FRAMES, 3)),
        contacts=np.broadcast_to(contacts, (FRAMES, 4)), ground=np.zeros((FRAMES, 2)),
        facing=np.stack([np.cos(turned), np.sin(turned)], axis=-1),
    )  # fmt: skip


def _slid(features: np.ndarray, joint: int) -> float:
    """Metres between the first and the last place of a joint on the ground."""
    by_velocity_alone = np.full((FRAMES, 2), 1e-9)
    motion = Motion(SMPL22, *decode(features, by_velocity_alone), 20.0)
    return float(np.linalg.norm((motion.positions[-1, joint] - motion.positions[0, joint])[[0, 2]]))


@pytest.mark.parametrize("turning", [0.0, 0.02])
def test_a_foot_that_stands_stays_where_it_is(turning):
    features = _features((1.0, 0.0, 0.0, 0.0), (0.01, 0.03, turning))
    assert _slid(features, LEFT) > 0.3, "it would slide"
    assert _slid(on_feet(features), LEFT) < 0.01


def test_of_two_feet_the_one_that_stands_counts():
    features = on_feet(_features((0.1, 0.1, 1.0, 0.0), (0.0, 0.0, 0.02)))
    assert _slid(features, RIGHT) < 0.01
    assert _slid(features, LEFT) > 0.1, "it is carried round the other"


def test_in_the_air_a_body_keeps_its_velocity():
    features = _features((0.1, 0.2, 0.0, 0.3), (0.01, 0.1, 0.0))
    np.testing.assert_array_equal(on_feet(features), features)


def test_poses_and_contacts_are_left_alone():
    features = _features((1.0, 1.0, 1.0, 1.0), (0.0, 0.05, 0.0))
    moved = on_feet(features)
    for name in ("height", "turns", "contacts", "ground", "facing"):
        np.testing.assert_array_equal(LAYOUT.read(moved, name), LAYOUT.read(features, name))
    assert len(on_feet(features[:1])) == 1, "one frame goes nowhere"
