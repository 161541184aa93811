"""The released 260 numbers against their own (golden/stylization_latent, feature part)."""

from __future__ import annotations

import numpy as np
import pytest

from engines.features.official_style import CONTACT_LIMIT, CONTACT_LIMIT_HALVED, STYLE
from engines.skeletons import Skeleton
from tests.engines.features.golden import cases, close, load

pytestmark = pytest.mark.golden

FILES = cases("stylization_latent", "features_ds1", "local_quat_wxyz")
TOLERANCE = 1e-4


def same_turn(found: np.ndarray, wanted: np.ndarray) -> None:
    """Quaternions of either sign."""
    close(found * np.sign((found * wanted).sum(-1, keepdims=True)), wanted, TOLERANCE)


@pytest.mark.parametrize("path", FILES)
@pytest.mark.parametrize(
    ("key", "step", "limit"), [("features_ds1", 1, CONTACT_LIMIT), ("features_ds2", 2, CONTACT_LIMIT_HALVED)]
)
def test_golden_features(path, key: str, step: int, limit: float) -> None:
    held = load(path)
    parents = tuple(held["parents31"].tolist())
    tree = Skeleton("tree", tuple(f"joint{i}" for i in range(len(parents))), parents, held["offsets31"])
    turns, root = held["local_quat_wxyz"][::step], held["root_pos"][::step]
    found = STYLE.features_of_tree(tree, turns, root, held["remain_joints"].tolist(), limit)
    for name, part in STYLE.layout.slices.items():
        close(found[:, part], held[key][:, part], 0.0 if name == "contacts" else TOLERANCE, name)


@pytest.mark.parametrize("path", FILES)
def test_golden_recovery(path) -> None:
    held = load(path)
    made, offsets = held["features_ds1"], held["offsets31"][held["remain_joints"]]
    heading, root = STYLE.recover_root(made)
    close(heading, held["recover_root_quat"], TOLERANCE, "heading")
    close(root, held["recover_root_pos"], TOLERANCE, "root")
    close(STYLE.recover_positions(made), held["recover_pos_from_ric"], TOLERANCE, "from positions")
    close(STYLE.recover_rotations(made, offsets), held["recover_pos_from_rot"], TOLERANCE, "from rotations")
    world, local = STYLE.recover_turns(made)
    same_turn(world, held["recover_global_quat"])
    same_turn(local, held["recover_local_quat"])


@pytest.mark.parametrize("path", FILES)
def test_golden_skeleton(path) -> None:
    held = load(path)
    assert STYLE.skeleton.parents == tuple(held["parents21"].tolist())
    facing = [STYLE.skeleton.index(name) for name in ("right_hip", "left_hip", "right_shoulder", "left_shoulder")]
    assert facing == held["face_joint_idx_r_hip_l_hip_r_sdr_l_sdr"].tolist()
