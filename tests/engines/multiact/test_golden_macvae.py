"""The released MACVAE against its own numbers: networks, losses, gradients, long-term generation."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from torch import Tensor
from torch.nn import functional as nnf

from engines.errors import CheckpointError
from engines.features import official_smplh
from engines.geometry import rotations, so3
from engines.multiact import official, official_cell
from engines.multiact.engine import load
from engines.multiact.official import Moved, OfficialMACVAE, Slots
from tests.conftest import find_shared
from tests.engines.action2motion.tiny import movement

pytestmark = pytest.mark.golden
FOLDER = (find_shared() or Path("absent")) / "golden" / "macvae"
TAGS = [path.name.removesuffix("forward_train.npz") for path in sorted(FOLDER.glob("public*forward_train.npz"))]
if not TAGS:
    pytest.skip("no golden numbers of MultiAct: see tests/conftest.py", allow_module_level=True)

Values = Mapping[str, Tensor]


def read(path: Path) -> dict[str, Tensor]:
    with np.load(path) as stored:
        return {name: torch.from_numpy(np.array(stored[name])) for name in stored.files}


class Golden:
    """The files of one tag."""

    def __init__(self, tag: str) -> None:
        self.tag = tag
        weights: dict[str, Tensor] = {}
        for path in FOLDER.glob(f"{tag}weights*.safetensors"):
            weights |= load_file(path)
        self.model: OfficialMACVAE = official.build(weights)
        self.train, self.gen = self.file("forward_train"), self.file("forward_gen")
        self.slots = Slots(self.train["in_frame_length"].long(), self.train["in_labels"].long())
        self.pose, self.place = self.train["in_smpl_param"], self.train["in_smpl_trans"]
        self.rows = rows_of(self.pose)

    def file(self, name: str) -> Values:
        return read(FOLDER / f"{self.tag}{name}.npz")


def rows_of(pose: Tensor) -> Tensor:
    """Axis-angle (..., 156) as rows of matrices (..., 312)."""
    matrices = rotations.rotvec_to_matrix(pose.unflatten(-1, (52, 3)).numpy())
    return torch.from_numpy(official_smplh.write_rot6d(matrices)).float().flatten(-2)


def near(ours: Tensor, theirs: Tensor, atol: float = 1e-4) -> None:
    torch.testing.assert_close(ours, theirs, atol=atol, rtol=0)


@pytest.fixture(scope="module", params=TAGS)
def golden(request: pytest.FixtureRequest) -> Golden:
    return Golden(request.param)


@torch.no_grad()
def test_golden_slots_and_latents(golden: Golden) -> None:
    held, slots = golden.train, golden.slots
    assert torch.equal(slots.label, held["in_label_mask"].long())
    assert torch.equal((slots.part < 3).float(), held["in_valid_mask"])
    prior = golden.model.priornet(golden.pose, golden.place, slots)
    posterior = golden.model.encoder(golden.pose, golden.place, slots)
    for name, found in (("prior", prior), ("posterior", posterior)):
        near(found.mean, held[f"{name}_mean"])
        near(found.logvar, held[f"{name}_logvar"])
    near(posterior.sample(held["noise"]), held["z"])
    near(prior.sample(golden.gen["noise"]), golden.gen["z"])


@torch.no_grad()
@pytest.mark.parametrize("mode", ["train", "gen"])
def test_golden_decoder_and_postprocessor(golden: Golden, mode: str) -> None:
    held = golden.train if mode == "train" else golden.gen
    decoded = golden.model.decoder(held["z"], golden.slots)
    near(decoded[:, : held["decoder_rot6d_valid"].shape[1], :312], held["decoder_rot6d_valid"])
    near(decoded[..., 312:], held["decoder_trans"])
    turns, place = official.read(golden.model(golden.rows, golden.place, held["z"], golden.slots))
    near(place, held["gen_smpl_trans"])
    there = golden.slots.part < 3
    theirs = torch.from_numpy(rotations.rotvec_to_matrix(held["gen_smpl_param"].unflatten(-1, (52, 3)).numpy())).float()
    near(turns[there], theirs[there])


@torch.no_grad()
def test_golden_postprocessor_alone(golden: Golden) -> None:
    held = golden.file("postprocess_train")
    made = golden.model.postprocessor(torch.cat([held["in_6d"], held["in_trans"]], dim=-1))
    near(made[..., 312:], held["out_trans"])
    near(made[:, : held["out_6d_first40"].shape[1], :312], held["out_6d_first40"])
    whole = golden.model.whole(golden.rows, golden.place, golden.model.decoder(golden.train["z"], golden.slots),
                               golden.slots)  # fmt: skip
    near(whole[..., :312], held["in_6d"])


class Body:
    """SMPL-H's linear blend skinning of the stand-in body, in double precision."""

    def __init__(self) -> None:
        held = read(FOLDER / "fake_smplh_body.npz")
        self.parents = held.pop("parents").tolist()
        self.held = {name: value.double() for name, value in held.items()}
        self.rest = self.held["J_regressor"] @ self.held["v_template"]

    def moved(self, turns: Tensor, place: Tensor) -> Moved:
        """Rotations (B, T, 52, 3, 3) and places (B, T, 3), the gradient kept."""
        turns, place = turns.double(), place.double()
        pose = so3.matrix_to_rotvec(turns)
        bend = (turns[..., 1:, :, :] - torch.eye(3)).flatten(-3)
        bent = self.held["v_template"] + (bend @ self.held["posedirs"].flatten(0, 1).T).unflatten(-1, (-1, 3))
        world, at = [turns[..., 0, :, :]], [self.rest[0].expand_as(place)]
        for joint, parent in enumerate(self.parents[1:], start=1):
            bone = self.rest[joint] - self.rest[parent]
            at.append(at[parent] + world[parent] @ bone)
            world.append(world[parent] @ turns[..., joint, :, :])
        turned, joints = torch.stack(world, dim=-3), torch.stack(at, dim=-2)
        shift = joints - (turned @ self.rest[..., None])[..., 0]
        skin = self.held["lbs_weights"]
        blended = torch.einsum("vj,btjxy->btvxy", skin, turned)
        vertices = (
            (blended @ bent[..., None])[..., 0] + torch.einsum("vj,btjx->btvx", skin, shift) + place[..., None, :]
        )
        return Moved(torch.cat([pose.flatten(-2), place], dim=-1), vertices, self.held["J_regressor"] @ vertices)


def _losses(golden: Golden, model: OfficialMACVAE) -> tuple[dict[str, Tensor], Tensor]:
    """The terms, and the posterior's means."""
    body, slots = Body(), golden.slots
    posterior = model.encoder(golden.pose, golden.place, slots)
    prior = model.priornet(golden.pose, golden.place, slots)
    made = body.moved(*official.read(model(golden.rows, golden.place, posterior.sample(golden.train["noise"]), slots)))
    real = body.moved(so3.rotvec_to_matrix(golden.pose.unflatten(-1, (52, 3)).double()), golden.place)
    there = golden.slots.part < 3
    if not model.training:
        near(made.joints[there][:, :22].float(), golden.train["gen_smpl_joint_body22"][there], 2e-4)
        near(real.joints[there][:, :22].float(), golden.train["gt_smpl_joint_body22"][there])
    terms = official.losses(made, real, posterior, prior, slots)
    return terms, posterior.mean.detach()


NAMES = {"pose": "rec_pose", "mesh": "rec_mesh", "acceleration": "accel_loss", "kl": "kl_loss"}


@torch.no_grad()
def test_golden_losses(golden: Golden) -> None:
    terms, _ = _losses(golden, golden.model)
    for ours, theirs in NAMES.items():
        assert float(terms[ours]) == pytest.approx(float(golden.train[f"loss_{theirs}_mean"]), rel=1e-4), ours


CONVOLUTIONS = {"encoder.mean_conv.weight", "encoder.logvar_conv.weight", "decoder.post_conv.weight"}


def as_released(convolution: official.Convolution, x: Tensor) -> Tensor:
    """The release's own operation, Conv2d over one channel."""
    padded = nnf.pad(x.mT, (convolution.before, 4 - convolution.before), mode="replicate").mT
    return nnf.conv2d(padded[:, None], convolution.weight, convolution.bias)[..., 0].mT


def weight_gradient(operation, convolution: official.Convolution, x: Tensor) -> Tensor:
    convolution.zero_grad()
    operation(convolution, x).square().sum().backward()
    grad = convolution.weight.grad
    assert grad is not None
    return grad.clone()


def the_reference_is_wrong_here() -> bool:
    """Torch 2.13's oneDNN gives Conv2d over one channel a wrong weight gradient on some processors, the reference's
    among them: whether on this one."""
    torch.manual_seed(0)
    convolution, x = official.Convolution(16, 16, 2), torch.randn(2, 20, 16)
    torch.nn.init.normal_(convolution.weight)
    ours, theirs = (weight_gradient(f, convolution, x) for f in (official.Convolution.forward, as_released))
    return not torch.allclose(ours, theirs, rtol=1e-3, atol=1e-3)


def test_the_weight_gradient_of_a_convolution_is_the_right_one() -> None:
    torch.manual_seed(0)
    convolution, x = official.Convolution(16, 16, 2), torch.randn(2, 20, 16)
    torch.nn.init.normal_(convolution.weight)

    def by_definition(convolution: official.Convolution, x: Tensor) -> Tensor:
        windows = nnf.pad(x.mT, (2, 2), mode="replicate").unfold(2, 5, 1)
        return torch.einsum("bctk,okc->bto", windows, convolution.weight[:, 0])

    ours = weight_gradient(official.Convolution.forward, convolution, x)
    torch.testing.assert_close(ours, weight_gradient(by_definition, convolution, x), rtol=1e-3, atol=1e-2)


def test_golden_gradients(golden: Golden, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(official.Convolution, "forward", as_released)
    held = golden.file("train_mode_dropout0")
    model = copy.deepcopy(golden.model).train()
    terms, mean = _losses(golden, model)
    near(mean, held["posterior_mean"])
    for ours, theirs in NAMES.items():
        assert float(terms[ours].detach()) == pytest.approx(float(held[f"loss_{theirs}_mean"]), rel=1e-4), ours
    total = torch.stack(list(terms.values())).sum()
    assert float(total.detach()) == pytest.approx(float(held["loss_total"]), rel=1e-4)
    total.backward()
    norm = model.encoder.bn
    assert norm.running_mean is not None and norm.running_var is not None and norm.num_batches_tracked is not None
    near(norm.running_mean, held["bn_running_mean_after"])
    near(norm.running_var, held["bn_running_var_after"])
    assert int(norm.num_batches_tracked) == int(held["bn_num_batches_tracked_after"])
    ours = {name.replace("postprocessor.", "postprocessor.layer.conv1."): p for name, p in model.named_parameters()}
    compared, wrong = 0, the_reference_is_wrong_here()
    for key, value in held.items():
        name = key.removeprefix("gradnorm.")
        if name == key or float(value) < 0:  # -1: no gradient
            continue
        if name in CONVOLUTIONS and not wrong:
            continue
        grad = ours[name].grad
        assert grad is not None, name
        if float(value) < 1e-6:  # shifts before a batch norm: rounding noise
            assert float(grad.norm()) < 1e-6, name
            continue
        assert float(grad.norm()) == pytest.approx(float(value), rel=1e-3), name
        compared += 1
    assert compared > 60


def joined(before: tuple[np.ndarray, np.ndarray], after: tuple[np.ndarray, np.ndarray]):
    """Both pieces brought to the canonical frame of the seam, as the release connects them."""
    pieces = []
    for (turns, place), anchor in ((before, len(before[1]) - 1), (after, 0)):
        root, there = official_smplh.face_front_align(turns[:, 0], place, anchor)
        pieces.append((np.concatenate([root[:, None], turns[:, 1:]], axis=1), there))
    turns, places = zip(*pieces, strict=True)
    return np.concatenate(turns), np.concatenate(places)


@pytest.mark.parametrize("item", [0, 1])
def test_golden_long_term_generation(golden: Golden, item: int) -> None:
    held = golden.file("longterm")
    whole, turns, place = None, None, None
    steps = sum(name.endswith("_labels") and name.startswith("step") for name in held)
    for step in range(steps):
        lengths, labels = (tuple(held[f"step{step}_{what}"][item].tolist()) for what in ("frame_length", "labels"))
        noise = held[f"noise_step{step}"][item : item + 1]
        if turns is None or place is None:  # the first step goes on from a real motion
            slots = Slots(torch.tensor([lengths]), torch.tensor([labels]))
            pose, there, rows = (value[item : item + 1] for value in (golden.pose, golden.place, golden.rows))
            with torch.no_grad():
                made = golden.model(rows, there, golden.model.priornet(pose, there, slots).sample(noise), slots)[0]
        else:
            made = official_cell.recur(golden.model, turns, place, lengths, labels, noise)
        read_turns, read_place = official.read(made)
        near(read_place, held[f"step{step}_item{item}_all_trans"])
        root = rotations.rotvec_to_matrix(held[f"step{step}_item{item}_root_aa"].numpy())
        there = sum(lengths)
        near(read_turns[:there, 0], torch.from_numpy(root[:there]).float())
        # the next step goes on from the action, whose last frames are not taken
        new = slice(lengths[0], sum(lengths) - 2)
        turns, place = read_turns.double().numpy(), read_place.double().numpy()
        piece = turns[new], place[new]
        whole = piece if whole is None else joined(whole, piece)
        turns, place = (values[lengths[0] + lengths[1] : sum(lengths) - 2] for values in (turns, place))
    assert whole is not None
    root, there = official_smplh.face_front_align(whole[0][:, 0], whole[1], 0)
    near(torch.from_numpy(root).float(), held[f"connected_item{item}_root_mat"])
    theirs = held[f"connected_item{item}_trans"]
    if not theirs[:, :2].any():  # the viewer has taken out where on the floor they are, whatever the README says
        there[:, :2] = 0
    near(torch.from_numpy(there).float(), theirs)


def test_golden_weights_make_an_engine(golden: Golden, tmp_path: Path) -> None:
    weights: dict[str, Tensor] = {}
    for path in FOLDER.glob(f"{golden.tag}weights*.safetensors"):
        weights |= load_file(path)
    torch.save({"epoch": 3, "model": {f"module.{name}": value for name, value in weights.items()}},
               tmp_path / "theirs.pth")  # fmt: skip
    (tmp_path / "labels.json").write_text('{"walk": 2, "T pose": 23}')
    engine = load(checkpoint=tmp_path / "theirs.pth")
    assert engine.variant == "official" and [action.name for action in engine.actions] == ["walk", "t pose"]
    made = engine.sequence([("t", 2.0), ("walk", 4.0)], seed=1, start=movement(30))
    assert len(made) == 30 + 120 and [s.kind for s in made.labels if s.kind == "transition"] == ["transition"] * 2
    seam = np.linalg.norm(np.diff(made.translation[28:32], axis=0), axis=-1)
    assert seam[1] < 1e-6  # the first frame stands where the last one did, as the release connects
    (tmp_path / "labels.json").write_text('{"walk": 4000}')
    with pytest.raises(CheckpointError, match="outside"):
        load(checkpoint=tmp_path / "theirs.pth")
