"""The template as torch sees it, and landmarks on it."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from engines.character import landmarks
from engines.character.marks import marks, trust
from engines.character.template import Puppet, posed_vertices
from engines.evaluation.characters import standing
from engines.geometry import rotations
from viewers import bodies

ROOT = np.array([0.1, 0.9, -0.2])


def test_a_puppet_is_the_shaped_body_posed() -> None:
    body, chosen = bodies.get("anny"), np.arange(0, 16160, 40)
    puppet = Puppet(body, chosen)
    values = torch.tensor([0.9, 0.4, 0.55, 0.7, 0.2], dtype=torch.float64)
    pose = standing(body, turn=0.7)
    shaped = body.shaped(**puppet.shape(values))
    arguments = values, torch.from_numpy(pose), torch.from_numpy(ROOT)
    vertices, joints, _ = puppet.posed(*arguments)
    assert vertices.numpy() == pytest.approx(posed_vertices(shaped, pose, ROOT)[chosen], abs=1e-5)
    assert joints[0].numpy() == pytest.approx(ROOT)
    few = torch.tensor([7, 3])
    assert puppet.only(few).posed(*arguments)[0].numpy() == pytest.approx(vertices[few].numpy())


def test_shapes_stay_within_their_bounds() -> None:
    shape = Puppet(bodies.get("anny"), np.arange(3)).shape(torch.tensor([9.0, -9.0, 0.5, 0.5, 0.5]))
    assert (shape["gender"], shape["age"]) == (1.0, 0.33)


def test_all_landmarks_lie_where_their_names_say() -> None:
    body = bodies.get("anny")
    found, skeleton = marks(body), body.skeleton
    arrays = body.vertices[found.vertices].astype(np.float64), skeleton.rest_positions, np.tile(np.eye(3), (22, 1, 1))
    places = found.placed(*(torch.from_numpy(np.array(array)) for array in arrays)).numpy()
    at = dict(zip(landmarks.NAMES, places, strict=True))
    for name, place in at.items():
        if name.startswith("left_"):  # the body is its own mirror image
            assert at[name.replace("left_", "right_")] * (-1, 1, 1) == pytest.approx(place, abs=0.012), name
            assert place[0] > 0, name
    assert at["nose"][2] > at["left_eye_middle"][2] > at["left_ear"][2]
    assert at["left_ear"][0] > at["left_eye_outer"][0] > at["left_eye_middle"][0] > at["left_eye_inner"][0] > 0
    assert at["left_toe"][2] > 0.1 > at["left_heel"][2] and at["left_heel"][1] < at["left_ankle"][1]
    assert at["left_index"][2] > at["left_pinky"][2] and at["left_index"][0] > at["left_wrist"][0]
    assert np.linalg.norm(at["left_shoulder"] - skeleton.rest_positions[skeleton.index("left_shoulder")]) < 0.03


def test_landmarks_turn_with_their_joints() -> None:
    body = bodies.get("anny")
    found = marks(body)
    turn = rotations.rotvec_to_matrix(np.array([0.0, 0.0, 1.0]))
    skin = torch.zeros(len(found.vertices), 3, dtype=torch.float64)
    joints = torch.zeros(22, 3, dtype=torch.float64)
    still = found.placed(skin, joints, torch.from_numpy(np.tile(np.eye(3), (22, 1, 1))))
    turned = found.placed(skin, joints, torch.from_numpy(np.tile(turn, (22, 1, 1))))
    assert still.abs().max() > 0.02
    assert turned.numpy() == pytest.approx(still.numpy() @ turn.T)
    assert trust()[landmarks.index("left_knee")] == 1 > trust()[landmarks.index("left_eye_inner")]
