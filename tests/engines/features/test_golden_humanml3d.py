"""The released 263 and 251 numbers against their own (golden/hml3d_features)."""

from __future__ import annotations

import numpy as np
import pytest

from engines.features import Statistics
from engines.features.humanml3d import layout
from engines.features.official_humanml3d import HUMANML3D, KIT, OfficialHumanML3D, between, rotate
from engines.geometry import rotations
from tests.engines.features.golden import cases, close, load

pytestmark = pytest.mark.golden

CLIPS = cases("hml3d_features", "joints", "features", "uniform_joints")
RECOVER, FEATURES, ROTATIONS = 1e-5, 3e-5, 3e-4


def codec(clip: dict[str, np.ndarray]) -> OfficialHumanML3D:
    return HUMANML3D if clip["joints"].shape[1] == 22 else KIT


@pytest.mark.parametrize("path", CLIPS)
def test_golden_bones_of_another_length(path) -> None:
    clip = load(path)
    close(codec(clip).uniform(clip["joints"], clip["tgt_offsets"]), clip["uniform_joints"], FEATURES)


@pytest.mark.parametrize("path", CLIPS)
def test_golden_placing(path) -> None:
    clip = load(path)
    dialect = codec(clip)
    joints = dialect.canonical(clip["uniform_joints"])
    close(joints, clip["global_positions"], FEATURES, "global")
    places = dialect._clips(joints)
    local = rotate(dialect.headings(places)[:, None], dialect._above_origin(places))
    close(local[:, :, 0].transpose(2, 1, 0), clip["local_positions"], FEATURES, "local")


@pytest.mark.parametrize("path", CLIPS)
def test_golden_features(path) -> None:
    clip = load(path)
    dialect = codec(clip)
    found, wanted = dialect.features_of(clip["uniform_joints"]), clip["features"]
    parts = dialect.layout.slices
    for name in ("yaw_velocity", "root_velocity", "root_height", "positions", "velocities"):
        close(found[:, parts[name]], wanted[:, parts[name]], FEATURES, name)
    close(found[:, parts["root_velocity"]], clip["root_linear_velocity"], FEATURES, "root velocity by itself")
    steady = np.maximum(ROTATIONS, clip["sensitivity_to_1e6_input_noise"][parts["rotations"]])
    close(found[:, parts["rotations"]], wanted[:, parts["rotations"]], steady, "rotations")
    feet = clip["global_positions"][:, [dialect.skeleton.index(name) for name in dialect.feet]]
    clear = np.abs((np.diff(feet, axis=0) ** 2).sum(-1) - clip["feet_thre"]) > 1e-6
    assert clear.mean() > 0.9
    np.testing.assert_array_equal(found[:, parts["contacts"]][clear], wanted[:, parts["contacts"]][clear])


@pytest.mark.parametrize("path", CLIPS)
@pytest.mark.parametrize(("key", "smoothing"), [("ik_quat_of_input", 0.0), ("ik_quat_of_input_smoothed", 20.0)])
def test_golden_inverse_kinematics(path, key: str, smoothing: float) -> None:
    clip = load(path)
    dialect = codec(clip)
    places = dialect._clips(clip["joints"])
    turns = dialect.rotations(places, dialect.headings(places, smoothing)[:, None])
    close(turns[:, :, 0].transpose(2, 1, 0), clip[key], ROTATIONS)


@pytest.mark.parametrize("path", CLIPS)
def test_golden_recovery(path) -> None:
    clip = load(path)
    dialect = codec(clip)
    heading, root = dialect.recover_root(clip["features"])
    close(heading, clip["recover_root_quat"], RECOVER, "heading")
    close(root, clip["recover_root_pos"], RECOVER, "root")
    close(dialect.recover_positions(clip["features"]), clip["recover_ric"], RECOVER, "from positions")
    turned = dialect.recover_rotations(clip["features"], clip["tgt_offsets"])
    close(turned, clip["recover_rot"], RECOVER, "from rotations")


@pytest.mark.parametrize("path", cases("hml3d_features", "joints", "reference_new_joint_vecs"))
def test_golden_real_pair_of_the_data_set(path) -> None:
    clip = load(path)
    close(codec(clip).recover_positions(clip["reference_new_joint_vecs"]), clip["joints"], RECOVER)


@pytest.mark.parametrize("path", cases("hml3d_features", "features", "mean", "std"))
def test_golden_mean_and_deviation(path) -> None:
    held = load(path)
    parts = layout(22 if held["features"].shape[1] == 263 else 21)
    found = Statistics.measure([held["features"][:50], held["features"][50:]], parts)
    np.testing.assert_allclose(found.mean, held["mean"], atol=1e-5, rtol=1e-5)
    np.testing.assert_allclose(found.std, held["std"], atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("path", cases("hml3d_features", "t2m_raw_offsets"))
def test_golden_tables(path) -> None:
    tables = load(path)
    for prefix, dialect in (("t2m", HUMANML3D), ("kit", KIT)):
        np.testing.assert_array_equal(dialect.raw_offsets, tables[f"{prefix}_raw_offsets"])
        assert dialect.skeleton.parents == tuple(tables[f"{prefix}_parents"])
        starts = {int(chain[1]) for chain in tables[f"{prefix}_kinematic_chain"]}
        assert {j for j, parent in enumerate(dialect.rotation_parents) if j and parent == 0} == starts
        facing = [dialect.skeleton.index(n) for n in ("right_hip", "left_hip", "right_shoulder", "left_shoulder")]
        assert facing == tables[f"{prefix}_face_joint_indx"].tolist()
        feet = [*tables[f"{prefix}_fid_l"], *tables[f"{prefix}_fid_r"]]
        assert [dialect.skeleton.index(name) for name in dialect.feet] == feet
        assert [dialect.skeleton.index(name) for name in dialect.legs] == tables[f"{prefix}_leg_idx"].tolist()
        assert dialect.contact_limit == tables[f"{prefix}_feet_thre"]
        assert dialect.fps == tables[f"{prefix}_fps"]
    np.testing.assert_allclose(HUMANML3D.offsets, tables["t2m_tgt_offsets_from_012314"], atol=6e-5)


@pytest.mark.parametrize("path", cases("hml3d_features", "Mean", "Std"))
def test_golden_the_shipped_deviation_is_one_number_a_part(path) -> None:
    std = load(path)["Std"]
    for part in layout(22):
        assert np.ptp(std[layout(22)[part.name]]) < 1e-6, part.name
    assert len(np.unique(std)) >= 6, "the parts differ"


@pytest.mark.parametrize("path", cases("hml3d_features", "qmul", "qbetween"))
def test_golden_quaternions(path) -> None:
    held = load(path)
    q, p, v = held["q"], held["p"], held["v"]
    close(rotations.multiply(q, p), held["qmul"], RECOVER, "product")
    close(rotations.invert(q), held["qinv"], RECOVER, "inverse")
    close(rotations.rotate(q, v), held["qrot"], RECOVER, "rotate")
    odd = held["q_unnormalised"]
    close(rotations.rotate(odd, v), held["qrot_unnormalised"], RECOVER, "rotate, not normalised")
    close(rotations.quaternion_to_matrix(q), held["quat_to_matrix"], RECOVER, "matrix")
    close(rotations.quaternion_to_matrix(odd), held["quat_to_matrix_unnormalised"], RECOVER, "matrix, not normalised")
    close(rotations.matrix_to_rot6d(rotations.quaternion_to_matrix(q)), held["quat_to_cont6d"], RECOVER, "6-D")
    close(rotations.rot6d_to_matrix(held["cont6d"]), held["cont6d_to_matrix"], RECOVER, "from 6-D")
    close(rotations.continuous(held["qfix_in"]), held["qfix_out"], RECOVER, "signs")
    close(between(v.T, held["w"].T).T, held["qbetween"], RECOVER, "between")
    a, b, wanted = held["near_a"], held["near_b"], held["qbetween_near"]
    found = between(a.T, b.T).T
    told = ~np.isnan(wanted).any(axis=-1)
    assert told.sum() >= 6
    close(found[told], wanted[told], 1.2e-4, "between, near opposite")
    opposite = np.linalg.norm(rotations.normalise(a) + rotations.normalise(b), axis=-1) < 1e-6
    assert opposite.sum() >= 3
    right = rotations.rotate(rotations.between(a, b), rotations.normalise(a))
    np.testing.assert_allclose(right, rotations.normalise(b), atol=1e-6, err_msg="ours turns half a circle there")
