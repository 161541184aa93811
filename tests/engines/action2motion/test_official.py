"""Official checkpoints: what is read, what is refused, and the released maths against naive loops."""

from __future__ import annotations

import os
import pickle
from itertools import pairwise
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file
from torch import Tensor

from engines.action2motion import official_lie
from engines.action2motion.official import (
    OfficialConfig,
    OfficialModel,
    OfficialNetworks,
    feeds_own_output,
    gaussian_kl,
    load_official,
    to_official,
)
from engines.action2motion.official_lie import MOCAP, SKELETONS
from engines.errors import CheckpointError, OutOfRangeError, UnknownLabelError

SIZES = {"latent_size": 4, "hidden_size": 8, "prior_layers": 1, "posterior_layers": 2, "generator_layers": 3}


def config(lie: bool, joints: int = 20, classes: int = 8, time_counter: bool | None = None) -> OfficialConfig:
    counter = lie if time_counter is None else time_counter
    return OfficialConfig(joints=joints, classes=classes, lie=lie, time_counter=counter, **SIZES)


def networks(sizes: OfficialConfig) -> OfficialNetworks:
    torch.manual_seed(3)
    return OfficialNetworks(sizes).eval()


def nested(made: OfficialNetworks, prefix: str = "") -> dict[str, dict[str, Tensor]]:
    """A dict of state dicts, as the release's trainer saves it."""
    sections: dict[str, dict[str, Tensor]] = {}
    for name, value in to_official(made.state_dict()).items():
        section, _, rest = name.partition(".")
        sections.setdefault(section, {})[prefix + rest] = value
    return sections


@pytest.fixture(params=[True, False], ids=["lie", "plain"])
def made(request) -> OfficialNetworks:
    return networks(config(request.param))


def assert_same(loaded: OfficialNetworks, made: OfficialNetworks) -> None:
    assert loaded.config == made.config
    for name, value in made.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], value), name
    assert not loaded.training


def test_a_trainers_file_is_read(made: OfficialNetworks, tmp_path: Path) -> None:
    optimizer = torch.optim.Adam(made.parameters())
    content = {**nested(made), "opt_decoder": optimizer.state_dict(), "iterations": 500}
    torch.save(content, tmp_path / "latest.tar")
    torch.save(content, tmp_path / "latest.pth", _use_new_zipfile_serialization=False)
    torch.save(nested(made, prefix="module."), tmp_path / "parallel.pt")
    for name in ("latest.tar", "latest.pth", "parallel.pt"):
        assert_same(load_official(tmp_path / name), made)


def test_flat_names_are_read(made: OfficialNetworks, tmp_path: Path) -> None:
    flat = to_official(made.state_dict())
    assert "decoder.gru.2.weight_hh" in flat
    assert "posterior_net.gru.1.bias_ih" in flat
    save_file(flat, tmp_path / "a.safetensors")
    torch.save(flat, tmp_path / "a.pth")
    assert_same(load_official(tmp_path / "a.safetensors"), made)
    assert_same(load_official(tmp_path / "a.pth"), made)


def test_sampling_needs_no_posterior(made: OfficialNetworks, tmp_path: Path) -> None:
    content = nested(made)
    del content["posterior_net"]
    torch.save(content, tmp_path / "a.tar")
    model, whole = OfficialModel.load(tmp_path / "a.tar"), OfficialModel(made)
    noise = model.noise(2, 5, seed=1)
    assert torch.equal(model.sample([0, 7], noise).joints, whole.sample([0, 7], noise).joints)
    with pytest.raises(CheckpointError, match="posterior_net"):
        model.reconstruct(torch.zeros(2, 5, 60), torch.tensor([0, 1]), noise, own_output=False)


class Harmful:
    def __reduce__(self):
        return os.system, ("touch harmed",)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"not a checkpoint", "accepted"),
        (b"", "accepted"),
        (pickle.dumps({"prior_net": Harmful()}, protocol=2), "accepted"),
        ({"prior_net": {}, "model": {}}, "no prior_net and no decoder"),
        ({"encoder": {"weight": torch.zeros(2)}}, "it has encoder"),
        ([torch.zeros(1)], "not a dict"),
        ({"prior_net": {"embed.weight": torch.zeros(2, 3)}, "decoder": {"x": torch.zeros(1)}}, "mu_net"),
    ],
    ids=["bytes", "empty", "code", "empty sections", "other names", "list", "few weights"],
)
@pytest.mark.parametrize("suffix", [".pth", ".safetensors"])
def test_what_is_no_checkpoint_is_refused(content, says, suffix, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / f"bad{suffix}"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        torch.save(content, path)
    with pytest.raises(CheckpointError, match="accepted" if suffix == ".safetensors" else says) as caught:
        load_official(path)
    assert str(path) in str(caught.value)
    assert not (tmp_path / "harmed").exists()
    with pytest.raises(CheckpointError, match="no such file"):
        load_official(tmp_path / "absent.tar")


def test_contradicting_shapes_are_refused(made: OfficialNetworks, tmp_path: Path) -> None:
    for name, shape in (("decoder.embed.weight", (8, 70)), ("prior_net.gru.0.weight_hh", (24, 9))):
        flat = to_official(made.state_dict())
        flat[name] = torch.zeros(shape)
        save_file(flat, tmp_path / "a.safetensors")
        with pytest.raises(CheckpointError, match=r"a\.safetensors"):
            load_official(tmp_path / "a.safetensors")


@pytest.mark.parametrize(
    ("lie", "joints", "classes", "time_counter"),
    [(True, 24, 12, True), (False, 24, 12, False), (True, 24, 12, False), (False, 18, 13, True), (True, 20, 5, True)],
)
def test_the_time_counter_is_told_by_the_classes(lie, joints, classes, time_counter, tmp_path: Path) -> None:
    sizes = config(lie, joints, classes, time_counter)
    save_file(to_official(networks(sizes).state_dict()), tmp_path / "a.safetensors")
    assert load_official(tmp_path / "a.safetensors").config == sizes
    other = load_official(tmp_path / "a.safetensors", time_counter=not time_counter).config
    assert other.condition_size == sizes.condition_size
    assert other.time_counter is not time_counter


def test_condition_is_label_then_time() -> None:
    model = OfficialModel(networks(config(lie=True)))
    condition = model.condition([2, 7], 5)
    assert condition.shape == (5, 2, 9)
    assert condition[..., :8].argmax(-1).tolist() == [[2, 7]] * 5
    assert condition[:, 0, 8].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert model.condition([0], 1).isfinite().all()
    for labels, frames in (([8], 5), ([-1], 5), ([], 5), ([0], 0)):
        with pytest.raises(OutOfRangeError):
            model.condition(labels, frames)


def test_samples_of_a_seed_do_not_depend_on_the_count(made: OfficialNetworks) -> None:
    model = OfficialModel(made)
    many, one = model.noise(3, 6, seed=11), model.noise(1, 6, seed=11)
    assert torch.equal(many[:, :1], one)
    assert not torch.equal(many[:, 1], many[:, 0])
    assert not torch.equal(one, model.noise(1, 6, seed=12))
    joints = model.sample([1, 2, 3], many).joints
    assert joints.shape == (3, 6, 20, 3)
    torch.testing.assert_close(model.sample([1], one).joints[0], joints[0])
    with pytest.raises(OutOfRangeError, match="noise"):
        model.sample([1, 2], many)


def test_bone_lengths_come_from_first_frames_in_turn() -> None:
    model, count = OfficialModel(networks(config(lie=True))), 5  # networks() seeds
    bones = torch.randn(2, 3, 60)
    joints = model.sample([0] * count, model.noise(count, 4, seed=0), bones).joints
    lengths = MOCAP.bone_lengths(joints)
    for sample in range(count):
        expected = MOCAP.bone_lengths(bones[sample % 2, 0].unflatten(-1, (20, 3))).expand(4, -1)
        torch.testing.assert_close(lengths[sample], expected, atol=1e-3, rtol=0)
    standard = MOCAP.bone_lengths(model.sample([0], model.noise(1, 4, seed=0)).joints)
    torch.testing.assert_close(standard[0, 0], torch.tensor(MOCAP.mean_lengths), atol=1e-3, rtol=0)


def test_labels_have_names() -> None:
    model = OfficialModel(networks(config(lie=True)))
    assert model.actions[model.label("Dance")] == "Dance"
    with pytest.raises(UnknownLabelError, match="Dance"):
        model.label("dancing")
    unnamed = OfficialModel(networks(config(lie=True, classes=3)))
    assert unnamed.actions == ("0", "1", "2")


def test_a_lie_model_of_another_skeleton_is_refused() -> None:
    with pytest.raises(CheckpointError, match="21 joints"):
        OfficialModel(networks(config(lie=True, joints=21)))
    assert OfficialModel(networks(config(lie=False, joints=21))).skeleton is None


def test_the_teacher_forcing_flag_is_reversed() -> None:
    assert feeds_own_output(0.59)
    assert not feeds_own_output(0.6)


def test_kl_is_that_of_the_distributions() -> None:
    mu_q, logvar_q, mu_p, logvar_p = torch.randn(4, 5, 6, dtype=torch.float64)
    normal = torch.distributions.Normal
    q, p = normal(mu_q, (logvar_q / 2).exp()), normal(mu_p, (logvar_p / 2).exp())
    expected = torch.distributions.kl_divergence(q, p)
    torch.testing.assert_close(gaussian_kl(mu_q, logvar_q, mu_p, logvar_p), expected)


@pytest.mark.parametrize("name", SKELETONS)
@pytest.mark.parametrize("root_rotation", [False, True])
def test_forward_kinematics_against_a_loop(name: str, root_rotation: bool) -> None:
    torch.manual_seed(0)
    skeleton = SKELETONS[name]
    lie, root = torch.randn(2, 3, len(skeleton), 3).double(), torch.randn(2, 3, 3).double()
    translations = skeleton.bone_translations(torch.rand(2, 1, len(skeleton)).double() + 0.1)
    joints = skeleton.forward_kinematics(lie, root, translations, root_rotation)
    expected = torch.zeros_like(joints)
    for b in range(2):
        for t in range(3):
            expected[b, t, 0] = root[b, t]
            for chain in skeleton.chains:
                turn = official_lie.exp(lie[b, t, 0]) if root_rotation else torch.eye(3).double()
                for parent, joint in pairwise(chain):
                    turn = turn @ official_lie.exp(lie[b, t, joint])
                    expected[b, t, joint] = expected[b, t, parent] + turn @ translations[b, 0, joint]
    torch.testing.assert_close(joints, expected)


@pytest.mark.parametrize("name", SKELETONS)
def test_inverse_kinematics_is_undone_by_forward(name: str) -> None:
    torch.manual_seed(0)
    skeleton = SKELETONS[name]
    joints = torch.randn(7, len(skeleton), 3, dtype=torch.float64)
    lie = skeleton.inverse_kinematics(joints)
    translations = skeleton.bone_translations(skeleton.bone_lengths(joints))
    torch.testing.assert_close(skeleton.forward_kinematics(lie, joints[:, 0], translations), joints, atol=1e-6, rtol=0)


def test_gradients_survive_sampling_first() -> None:
    """Nothing cached while sampling (inference mode) may be in the way of training."""
    model = OfficialModel(networks(config(lie=True)).double())
    model.sample([0], model.noise(1, 3, seed=0))
    joints = torch.randn(2, 3, 60, dtype=torch.float64)
    noise = torch.randn(3, 2, 4, dtype=torch.float64)
    model.reconstruct(joints, torch.tensor([0, 1]), noise, own_output=True).loss().backward()
    assert all(p.grad is not None and p.grad.isfinite().all() for p in model.networks.parameters())
