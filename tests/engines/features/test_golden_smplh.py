"""The released transforms of MultiAct against their own (golden/macvae, transform part)."""

from __future__ import annotations

import numpy as np
import pytest

from engines.features import official_smplh as official
from engines.geometry import rotations
from tests.engines.features.golden import cases, close, load

pytestmark = pytest.mark.golden

FILES = cases("macvae", "align0_param", "sixd_from_mat")
TOLERANCE = 1e-4


@pytest.mark.parametrize("path", FILES)
def test_golden_canonicalisation(path) -> None:
    held = load(path)
    count = sum(name.endswith("_anchor") for name in held)
    assert count >= 4
    for i in range(count):
        param, anchor = held[f"align{i}_param"], int(held[f"align{i}_anchor"])
        matrices = rotations.rotvec_to_matrix(param[:, :3])
        close(matrices, held[f"align{i}_in_global_mat"], TOLERANCE, "axis-angle")
        turned, shifted = official.face_front_align(matrices, held[f"align{i}_trans"], anchor)
        close(turned, held[f"align{i}_out_global_mat"], TOLERANCE, "global rotation")
        close(rotations.rotvec_to_matrix(held[f"align{i}_out_global_aa"]), turned, TOLERANCE, "as axis-angle")
        close(shifted, held[f"align{i}_out_trans"], TOLERANCE, "translation")
        assert abs(official.euler_zyx(turned[anchor])[0]) < 1e-4
        assert np.abs(shifted[anchor]).max() < 1e-6
        close(official.to_front_view(matrices), held[f"view{i}_front_global_mat"], TOLERANCE, "front")
        close(official.to_right_view(matrices), held[f"view{i}_right_global_mat"], TOLERANCE, "right")


@pytest.mark.parametrize("path", FILES)
def test_golden_rotations(path) -> None:
    held = load(path)
    matrices = held["sixd_mat_in"]
    close(official.write_rot6d(matrices), held["sixd_from_mat"], TOLERANCE, "rows")
    close(official.unwrite_rot6d(held["sixd_random"]), held["sixd_random_p3d_matrix"], TOLERANCE, "from rows")
    read = official.read_rot6d(held["sixd_random"])
    close(read, held["sixd_random_model_mat"], TOLERANCE, "interleaved")
    close(read, rotations.rotvec_to_matrix(held["sixd_random_model_aa"]), TOLERANCE, "as axis-angle")
    mismatch = official.read_rot6d(official.write_rot6d(matrices))
    close(mismatch, held["sixd_roundtrip_mismatch_mat"], TOLERANCE, "what goes in does not come out")
    assert np.abs(mismatch - matrices).max() > 1
    np.testing.assert_allclose(official.unwrite_rot6d(official.write_rot6d(matrices)), matrices, atol=1e-6)
    close(rotations.rotvec_to_matrix(held["aa_in"]), held["aa_mat"], TOLERANCE, "axis-angle")
    back = rotations.rotvec_to_matrix(held["aa_back_pytorch3d"])
    close(rotations.rotvec_to_matrix(rotations.matrix_to_rotvec(held["aa_mat"])), back, TOLERANCE, "and back")
    close(official.euler_zyx(held["aa_mat"]), held["aa_euler_ZYX"], TOLERANCE, "Euler angles")
