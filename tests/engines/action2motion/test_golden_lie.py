"""The released so(3) maths against its own numbers (golden/lie)."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from engines.action2motion import official_lie
from engines.action2motion.official_lie import SKELETONS, OfficialSkeleton
from engines.errors import OutOfRangeError
from engines.geometry import so3
from tests.engines.action2motion.golden import cases, close, tensors

pytestmark = pytest.mark.golden

MAPS = cases("lie", "public*maps.npz")
KINDS = {"f64": torch.float64, "f32": torch.float32}
MAP_TOLERANCE = {"f64": 1e-9, "f32": 1e-6}
FK_TOLERANCE = {"f64": 1e-9, "f32": 2e-6}
STEEP = 3.1
"""Angle in radians above which the released inverse kinematics loses digits."""


def skeleton_cases():
    """Every golden/lie file of a skeleton, once in each precision."""
    files = [case for case in cases("lie") if case.id == "absent" or not case.id.endswith("maps")]
    return [
        pytest.param(*case.values, kind, marks=case.marks, id=f"{case.id}-{kind}") for case in files for kind in KINDS
    ]


def read(path, kind: str) -> tuple[OfficialSkeleton, dict[str, Tensor]]:
    """The skeleton that a file is about, and its arrays in one precision, suffix dropped."""
    skeleton = next(s for s in SKELETONS.values() if s.name in path.stem)
    arrays = tensors(path)
    chosen = {name: value.to(KINDS[kind]) for name, value in arrays.items() if value.is_floating_point()}
    return skeleton, chosen | {
        name.removesuffix(f"_{kind}"): v for name, v in arrays.items() if name.endswith(kind)
    } | {"scale_inds": arrays["scale_inds"]}


def compared_rows(angle: Tensor, kind: str) -> Tensor:
    """Which rows a map is compared at: all in float64, angles 0.05 ... 3.05 in float32."""
    return torch.ones_like(angle, dtype=torch.bool) if kind == "f64" else (angle > 0.05) & (angle < 3.05)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("path", MAPS)
def test_golden_exp_and_log(path, kind: str) -> None:
    maps = tensors(path)
    rotvec, matrix = maps[f"exp_in_{kind}"], maps[f"exp_out_{kind}"]
    rows = compared_rows(rotvec.norm(dim=-1), kind)
    assert rows.sum() > 15
    close(official_lie.exp(rotvec)[rows], matrix[rows], MAP_TOLERANCE[kind], "exp")
    close(official_lie.log(matrix)[rows], maps[f"log_of_exp_out_{kind}"][rows], MAP_TOLERANCE[kind], "log of exp")
    rows = compared_rows(so3.matrix_to_rotvec(maps["log_in_f64"]).norm(dim=-1), kind)
    close(official_lie.log(maps[f"log_in_{kind}"])[rows], maps[f"log_out_{kind}"][rows], MAP_TOLERANCE[kind], "log")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("path", MAPS)
def test_golden_log_quirks(path, kind: str) -> None:
    maps = tensors(path)
    out = official_lie.log(maps[f"log_special_in_{kind}"])
    assert out[0].isnan().all()  # the identity
    close(out, maps[f"log_special_out_{kind}"], MAP_TOLERANCE[kind])  # and zero at half a turn


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("path", MAPS)
def test_golden_between(path, kind: str) -> None:
    maps = tensors(path)
    out, expected = official_lie.between(maps[f"uv_u_{kind}"], maps[f"uv_v_{kind}"]), maps[f"uv_out_{kind}"]
    rows = compared_rows(expected.norm(dim=-1), kind)
    assert rows.sum() > 15
    close(out[rows], expected[rows], MAP_TOLERANCE[kind])
    close(official_lie.exp(expected)[rows], maps[f"uv_R_{kind}"][rows], MAP_TOLERANCE[kind])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("path", MAPS)
def test_golden_hat(path, kind: str) -> None:
    maps = tensors(path)
    close(so3.hat(maps[f"hat_in_{kind}"]), maps[f"hat_out_{kind}"], 0.0)


@pytest.mark.parametrize(("path", "kind"), skeleton_cases())
def test_golden_inverse_kinematics(path, kind: str) -> None:
    skeleton, arrays = read(path, kind)
    steep = tensors(path)["ik_lie_f64"].norm(dim=-1) > STEEP
    lie, expected = skeleton.inverse_kinematics(arrays["joints"]), arrays["ik_lie"]
    # near a half turn, where single precision of one processor is 1.6e-4 from that of another
    close(lie[~steep], expected[~steep], {"f64": 1e-7, "f32": 2e-4}[kind])
    close(lie[steep], expected[steep], {"f64": 1e-5, "f32": 4e-3}[kind])
    translations = skeleton.bone_translations(skeleton.bone_lengths(arrays["joints"]))
    close(translations, arrays["bone_translation"], FK_TOLERANCE[kind])
    back = skeleton.forward_kinematics(lie, arrays["joints"][:, 0], translations)
    close(back, arrays["fk_of_ik"], {"f64": 1e-7, "f32": 4e-3}[kind])


@pytest.mark.parametrize(("path", "kind"), skeleton_cases())
def test_golden_forward_kinematics(path, kind: str) -> None:
    skeleton, arrays = read(path, kind)
    lie = arrays["generator_raw_output"]
    lengths, root = skeleton.bone_lengths(arrays["fk_bone_ref"]), lie[:, 0]
    plain, scaled = (
        skeleton.bone_translations(lengths),
        skeleton.bone_translations(lengths, arrays["scale_inds"].tolist()),
    )
    close(skeleton.forward_kinematics(lie, root, plain), arrays["fk_gen"], FK_TOLERANCE[kind], "fk_gen")
    close(skeleton.forward_kinematics(lie, root, scaled), arrays["fk_gen_scaled"], FK_TOLERANCE[kind], "scaled")
    turned = skeleton.forward_kinematics(lie, root, plain, root_rotation=True)
    close(turned, arrays["fk_gen_rootR"], FK_TOLERANCE[kind], "root rotation")
    assert not torch.allclose(turned, arrays["fk_gen"], atol=1e-2)


@pytest.mark.parametrize("path", cases("lie", "tables.npz"))
@pytest.mark.parametrize("name", SKELETONS)
def test_golden_tables(path, name: str) -> None:
    skeleton = SKELETONS[name]
    with np.load(path) as tables:
        np.testing.assert_array_equal(skeleton.offsets, tables[f"{name}_raw_offsets"])
        chains = [tuple(int(j) for j in row if j >= 0) for row in tables[f"{name}_kinematic_chains"]]
        assert list(skeleton.chains) == chains
        np.testing.assert_array_equal(skeleton.parents, tables[f"{name}_parents"])
        lengths = tables[f"{name}_mean_bone_length_of_shipped_motions"]
        np.testing.assert_allclose(skeleton.mean_lengths, lengths, atol=6e-5)
        coarse = f"{name}_coarse_names" if name == "humanact12" else f"{name}_names"
        assert list(skeleton.actions) == tables[coarse].tolist()
    assert len(set(skeleton.joints)) == len(skeleton)


@pytest.mark.parametrize("path", [case for case in cases("lie") if case.id == "absent" or not case.id.endswith("maps")])
def test_golden_house_axes(path) -> None:
    """Turned into our axes a body stands upright, and its left is where its left is."""
    skeleton, arrays = read(path, "f64")
    joints = skeleton.house(arrays["joints"])
    place = {name: joints[:, i] for i, name in enumerate(skeleton.joints)}
    ahead = place["nose"] - place["head_top"] if "nose" in place else place["left_foot"] - place["left_ankle"]
    up = torch.tensor([0.0, 1.0, 0.0], dtype=joints.dtype)
    left = torch.linalg.cross(up.expand_as(ahead), ahead)
    for side in ("hip", "shoulder"):
        across = place[f"left_{side}"] - place[f"right_{side}"]
        assert ((across * left).sum(-1) > 0).double().mean() > 0.9
    assert (place["left_knee"][:, 1] > place["left_ankle"][:, 1]).all()
    leg = skeleton.metre * sum(skeleton.mean_lengths[skeleton.joints.index(f"left_{j}")] for j in ("knee", "ankle"))
    assert 0.65 < leg < 0.95  # metres


def test_log_refuses_what_is_no_rotation() -> None:
    with pytest.raises(OutOfRangeError, match="trace"):
        official_lie.log(2 * torch.eye(3))
