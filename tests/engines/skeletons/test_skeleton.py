"""The skeleton: its checks, its tree, its names."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from engines import skeletons
from engines.errors import OutOfRangeError, SkeletonError, UnknownLabelError
from engines.skeletons import SMPL22, Skeleton

OFFSETS = np.array([[0, 1.0, 0], [0.2, 0, 0], [-0.2, 0, 0], [0, -0.5, 0]])


def small(**changes) -> Skeleton:
    fields = {
        "name": "small",
        "joints": ("root", "left_leg", "right_leg", "left_toe"),
        "parents": (-1, 0, 0, 1),
        "offsets": OFFSETS,
        "mirror_pairs": (("left_leg", "right_leg"),),
    }
    return Skeleton(**{**fields, **changes})


def test_the_house_skeleton() -> None:
    assert len(SMPL22) == 22
    assert skeletons.get("smpl22") is SMPL22
    assert 1.4 < np.ptp(SMPL22.rest_positions[:, 1]) < 1.6
    assert {joint for pair in SMPL22.mirror_pairs for joint in pair} == {
        joint for joint in SMPL22.joints if joint.startswith(("left_", "right_"))
    }
    left = SMPL22.index("left_wrist")
    assert SMPL22.rest_positions[left, 0] > 0.5, "left is +X"
    assert SMPL22.offsets[SMPL22.index("left_foot"), 2] > 0.1, "facing +Z"
    with pytest.raises(UnknownLabelError, match="smpl22"):
        skeletons.get("smpl")


def test_names_are_indices() -> None:
    skeleton = small()
    assert [skeleton.index(joint) for joint in skeleton.joints] == [0, 1, 2, 3]
    assert "left_toe" in skeleton
    assert "toe" not in skeleton
    with pytest.raises(SkeletonError, match=r"no joint 'toe'; it has root, left_leg"):
        skeleton.index("toe")


def test_tree() -> None:
    skeleton = small()
    assert skeleton.children == ((1, 2), (3,), (), ())
    assert skeleton.chains == ((0, 1, 3), (0, 2))
    np.testing.assert_allclose(skeleton.rest_positions, [[0, 1, 0], [0.2, 1, 0], [-0.2, 1, 0], [0.2, 0.5, 0]])
    np.testing.assert_allclose(skeleton.bone_lengths, [1, 0.2, 0.2, 0.5])
    assert skeleton.mirror_index.tolist() == [0, 2, 1, 3]


def test_chains_of_the_house_skeleton_hold_every_bone_once() -> None:
    bones = [(a, b) for chain in SMPL22.chains for a, b in pairwise(chain)]
    assert sorted(b for _, b in bones) == list(range(1, 22))
    assert all(SMPL22.parents[b] == a for a, b in bones)
    assert len(SMPL22.chains) == 5


def test_equality_is_joints_tree_and_rest_pose() -> None:
    assert small() == small(name="other")
    assert hash(small()) == hash(small(name="other"))
    assert small() != small(offsets=OFFSETS * 2)
    assert small() != small(parents=(-1, 0, 1, 1))
    assert small() != small(joints=("root", "left_leg", "right_leg", "toe"))
    assert small() != "small"


def test_offsets_are_a_read_only_copy() -> None:
    mine = OFFSETS.copy()
    skeleton = small(offsets=mine)
    with pytest.raises(ValueError, match="read-only"):
        skeleton.offsets[0] = 1
    mine[0] = 7
    assert skeleton.offsets[0, 1] == 1.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joints": (), "parents": (), "offsets": np.zeros((0, 3))}, "at least one joint"),
        ({"parents": (-1, 0, 0)}, "4 joints, 3 parents"),
        ({"offsets": np.zeros((4, 2))}, r"shape \(4, 2\)"),
        ({"joints": ("root", "leg", "leg", "toe"), "mirror_pairs": ()}, "names joints twice: leg"),
        ({"parents": (0, 0, 0, 1)}, "root first"),
        ({"parents": (-1, 0, 3, 1)}, "parents before children"),
        ({"parents": (-1, -1, 0, 1)}, "root first"),
        ({"offsets": OFFSETS * np.nan}, "not finite"),
    ],
)
def test_malformed_skeletons_are_refused(changes: dict, message: str) -> None:
    with pytest.raises(SkeletonError, match=message):
        small(**changes)


def test_scaled() -> None:
    skeleton = small().scaled({"*": 2.0, "left_toe": 0.5})
    np.testing.assert_allclose(skeleton.bone_lengths, [2, 0.4, 0.4, 0.25])
    assert skeleton.mirror_pairs == small().mirror_pairs
    with pytest.raises(SkeletonError, match="no joint 'tail'"):
        small().scaled({"tail": 2.0})


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_bones_cannot_vanish_or_turn_inside_out(factor: float) -> None:
    with pytest.raises(OutOfRangeError, match=r"left_toe.*positive"):
        small().scaled({"left_toe": factor})


def test_hinges_stand_across_their_bones() -> None:
    for joint, axis in SMPL22.hinges.items():
        assert np.linalg.norm(axis) == pytest.approx(1)
        assert axis @ SMPL22.offsets[SMPL22.index(joint)] == pytest.approx(0, abs=1e-9)
