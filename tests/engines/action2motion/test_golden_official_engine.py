"""The engine on the authors' checkpoints: their joints as they come, then sane Motions on the house skeleton."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import torch

import engines
from engines.action2motion.official_engine import OfficialEngine
from engines.action2motion.official_lie import SKELETONS
from engines.errors import Cancelled, CheckpointError, OutOfRangeError, UnknownLabelError
from engines.geometry import rotations
from engines.skeletons import SMPL22
from tests.engines.action2motion.golden import cases, tensors

pytestmark = pytest.mark.golden

RATES = {"humanact12": 20.0, "ntu_vibe": 30.0, "mocap": 12.0}


@pytest.fixture(params=cases("a2m_vae"))
def golden(request, tmp_path: Path) -> tuple[OfficialEngine, dict[str, torch.Tensor]]:
    """The engine, loaded as a person would, and the arrays of the case."""
    path = tmp_path / "latest.safetensors"
    shutil.copy(request.param.with_suffix(".safetensors"), path)
    return engines.load("action2motion", checkpoint=path), tensors(request.param)


def test_golden_joints_before_retargeting(golden, monkeypatch) -> None:
    engine, a = golden
    frames, count = a["eps_prior_sample"].shape[:2]
    # the engine's own way, with the reference's noise and bone lengths in place of the seed's
    sample = engine.model.sample
    monkeypatch.setattr(engine.model, "noise", lambda _n, _f, seed: a["eps_prior_sample"][:, [seed % 1_000_003]])
    bones = a.get("sample_bone_source")
    for index in range(count):
        own = None if bones is None else bones[[index % len(bones)]]
        monkeypatch.setattr(engine.model, "sample", lambda labels, noise, own=own: sample(labels, noise, own))
        action = engine.actions[int(a["labels"][index])].name
        made = engine.joints(action, frames, 0, range(index, index + 1))[0]
        np.testing.assert_allclose(made.reshape(frames, -1), a["sample_joints"][index].numpy(), atol=1e-5, rtol=0)


def test_golden_real_poses_keep_their_shape(golden) -> None:
    """Limbs of the retargeted Motion point where the data's do, once both are turned to face the front."""
    engine, a = golden
    real = a["joints"].unflatten(-1, (-1, 3))
    for sequence in real:
        motion = engine.motion(sequence.numpy())
        _assert_sane(motion, len(sequence))
        named = list(engine.skeleton.joints)
        places = engine.skeleton.house(sequence.double()).numpy()
        for far, near in (("left_knee", "left_hip"), ("right_ankle", "right_knee"), ("left_elbow", "left_shoulder")):
            seen = places[:, named.index(far)] - places[:, named.index(near)]
            made = motion.positions[:, SMPL22.index(far)] - motion.positions[:, SMPL22.index(near)]
            height = rotations.normalise(seen)[:, 1] - rotations.normalise(made)[:, 1]
            assert np.abs(height).max() < 1e-5, far


def test_golden_generation(golden) -> None:
    engine, _ = golden
    name = engine.skeleton.name
    assert (engine.name, engine.fps, engine.variant) == (
        "action2motion", RATES[name], "official-lie" if engine.model.config.lie else "official-plain",
    )  # fmt: skip
    if engine.model.config.classes == len(SKELETONS[name].actions):
        assert len(engine.actions) == len(SKELETONS[name].actions)
    action = engine.actions[1].name
    seen = []
    many = engine.generate_many(action, count=3, frames=9, seed=5, progress=lambda *now: seen.append(now))
    again = engine.generate_many(action, count=3, frames=9, seed=5)
    assert seen == [(3, 3)]
    for index, (motion, same) in enumerate(zip(many, again, strict=True)):
        _assert_sane(motion, 9)
        assert motion.fps == RATES[name]
        np.testing.assert_array_equal(motion.rotations, same.rotations)
        np.testing.assert_array_equal(motion.translation, same.translation)
        made = motion.provenance
        assert (made.source, made.prompt, made.seed, made.index) == ("action2motion", action, 5, index)
        assert made.weights == engine.weights_hash
        assert motion.label_at(8) == action
    assert not np.allclose(many[0].rotations, many[1].rotations)
    one = engine.generate(action, frames=9, seed=5)
    np.testing.assert_allclose(one.positions, many[0].positions, atol=1e-3)
    assert len(engine.generate(action.upper(), frames=1)) == 1
    longer = engine.generate(action, frames=9, seed=5, bone_scale={"*": 1.2})
    np.testing.assert_allclose(longer.skeleton.bone_lengths, 1.2 * SMPL22.bone_lengths)


def test_golden_what_is_refused(golden, tmp_path: Path) -> None:
    engine, _ = golden
    action = engine.actions[0].name
    with pytest.raises(UnknownLabelError, match="did you mean"):
        engine.generate("polka")
    for wrong in ({"frames": 0}, {"frames": 12_001}, {"seed": -1}):
        with pytest.raises(OutOfRangeError):
            engine.generate(action, **wrong)
    with pytest.raises(OutOfRangeError, match="count"):
        engine.generate_many(action, count=0)
    with pytest.raises(Cancelled):
        engine.generate_many(action, cancel=lambda: True)
    (tmp_path / "broken.tar").write_bytes(b"no checkpoint")
    with pytest.raises(CheckpointError, match=r"broken\.tar"):
        engines.load("action2motion", checkpoint=tmp_path / "broken.tar")


def _assert_sane(motion, frames: int) -> None:
    assert (motion.skeleton, len(motion)) == (SMPL22, frames)
    assert np.isfinite(motion.positions).all()
    feet = [SMPL22.index(joint) for foot in SMPL22.feet for joint in foot]
    assert -0.3 < motion.positions[:, feet, 1].min() < 0.3
    np.testing.assert_allclose(motion.positions[0, 0, [0, 2]], 0, atol=1e-9)
    assert abs(motion.heading[0]) < 1e-9
