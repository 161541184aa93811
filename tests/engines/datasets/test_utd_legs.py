"""Legs of the depth camera: a squat it sees from the front comes out as deep as the hips have come down."""

from __future__ import annotations

import numpy as np
import pytest

from engines.datasets.utd_mhad import bent_leg

THIGH, SHIN = 0.43, 0.40


def seen_from_the_front(drop: np.ndarray, lost: float) -> dict[str, np.ndarray]:
    """Hips that come down by `drop` (T,); of the knees' way forward the camera sees only the share `1 - lost`."""
    points = {}
    for side, x in (("left", 0.1), ("right", -0.1)):
        span = THIGH + SHIN - drop
        along = (THIGH**2 - SHIN**2 + span**2) / (2 * span)
        ahead = np.sqrt(np.maximum(0, THIGH**2 - along**2))
        zero = np.zeros_like(drop)
        points[f"{side}_ankle"] = np.stack([zero + x, zero + 0.08, zero], axis=-1)
        points[f"{side}_hip"] = np.stack([zero + x, 0.08 + span, zero], axis=-1)
        points[f"{side}_knee"] = np.stack([zero + x, 0.08 + span - along, (1 - lost) * ahead], axis=-1)
    return points


def drops() -> np.ndarray:
    return np.concatenate([np.zeros(30), np.linspace(0, 0.4, 10), np.zeros(10)])


@pytest.mark.parametrize("lost", [0.0, 0.6, 1.0])
def test_a_squat_keeps_its_depth(lost: float) -> None:
    drop = drops()
    points = seen_from_the_front(drop, lost)
    for side in ("left", "right"):
        made = bent_leg(points, side)
        hip, knee, ankle = points[f"{side}_hip"], made[f"{side}_knee"], made[f"{side}_ankle"]
        assert np.ptp(np.linalg.norm(knee - hip, axis=-1)) < 1e-9
        assert np.ptp(np.linalg.norm(ankle - knee, axis=-1)) < 1e-9
        span = np.linalg.norm(ankle - hip, axis=-1)
        np.testing.assert_allclose(span, THIGH + SHIN - drop, atol=0.02)
        deep = drop > 0.2
        assert (knee[deep, 2] > 0.15).all(), "knees bend to the front"
        np.testing.assert_allclose(knee[deep, 0], hip[deep, 0], atol=1e-6)


def test_a_leg_that_is_straight_but_for_noise_stays_straight() -> None:
    rng = np.random.default_rng(0)
    points = seen_from_the_front(np.abs(rng.normal(scale=0.003, size=60)), lost=0.5)
    made = bent_leg(points, "left")
    middle = (points["left_hip"] + made["left_ankle"]) / 2
    assert np.abs(made["left_knee"][:, 2] - middle[:, 2]).max() < 0.02


def test_the_knee_keeps_to_the_side_it_was_seen_on() -> None:
    points = seen_from_the_front(drops(), lost=0.0)
    for joint in ("left_knee", "right_knee"):
        points[joint] = points[joint] + np.array([0.15, 0.0, 0.0]) * (drops() > 0)[:, None]
    made = bent_leg(points, "left")
    deep = drops() > 0.2
    assert (made["left_knee"][deep, 0] > points["left_hip"][deep, 0] + 0.05).all()
