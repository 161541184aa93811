"""The released temporal VAE against its own numbers (golden/a2m_vae): training pass, gradients, a step, sampling."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
import torch
from safetensors.torch import load_file
from torch import Tensor

from engines.action2motion.official import ADAM, OfficialModel, from_official, load_official, to_official
from tests.engines.action2motion.golden import cases, close, tensors

pytestmark = pytest.mark.golden

FORWARD, LOSS, GRADIENT, STEP, STEP_UNDECIDED = 1e-5, 1e-5, 1e-4, 1e-6, 4e-4
CONFIG = ("batch", "frames", "joints", "hidden", "latent", "classes", "prior", "posterior", "decoder", "time", "lie")
FEEDS = pytest.mark.parametrize("feed", ["gtfeed", "selffeed"])


@dataclass
class Case:
    """One file: its arrays, its sizes and the model that its weights make."""

    arrays: dict[str, Tensor]
    sizes: dict[str, int]
    model: OfficialModel
    weights: dict[str, Tensor]
    step: dict[str, Tensor]

    def reconstruct(self, feed: str):
        a = self.arrays
        return self.model.reconstruct(a["joints"], a["labels"], a["eps_posterior"], own_output=feed == "selffeed")


@pytest.fixture(params=cases("a2m_vae"))
def case(request) -> Case:
    path = request.param
    arrays = tensors(path)
    sizes = dict(zip(CONFIG, arrays["config"].tolist(), strict=True))
    weights = path.with_suffix(".safetensors")
    model = OfficialModel(load_official(weights, time_counter=bool(sizes["time"])))
    return Case(arrays, sizes, model, load_file(weights), load_file(path.with_name(f"{path.stem}_step.safetensors")))


def test_golden_sizes_and_names(case: Case) -> None:
    config, sizes = case.model.config, case.sizes
    found = [config.joints, config.hidden_size, config.latent_size, config.classes, config.prior_layers]
    found += [config.posterior_layers, config.generator_layers, int(config.time_counter), int(config.lie)]
    assert dict(zip(CONFIG[2:], found, strict=True)) == {name: sizes[name] for name in CONFIG[2:]}
    ours = case.model.networks.state_dict()
    assert set(from_official(case.weights)) == set(ours)
    back = to_official(ours)
    assert set(back) == set(case.weights)
    for name, value in case.weights.items():
        assert torch.equal(back[name], value), name


@FEEDS
def test_golden_networks(case: Case, feed: str) -> None:
    made = case.reconstruct(feed)
    found = {
        "z": made.z, "mu_q": made.posterior.mu, "lv_q": made.posterior.logvar, "h_q": made.posterior.hidden,
        "mu_p": made.prior.mu, "lv_p": made.prior.logvar, "h_p": made.prior.hidden,
        "out": made.raw, "h_dec": made.hidden, "pri_in": made.prior_input, "dec_in": made.generator_input,
    }  # fmt: skip
    if case.sizes["lie"]:
        found["fk_joints"] = made.joints.reshape(made.raw.shape)
    kept_apart = {"mse", "kld", "log_g_loss", "log_g_recon_loss", "log_g_kld_loss"}
    stated = {name.removeprefix(f"{feed}_") for name in case.arrays if name.startswith(feed)} - kept_apart
    assert stated <= set(found)
    for name in stated:
        close(found[name], case.arrays[f"{feed}_{name}"], FORWARD, name)


@FEEDS
def test_golden_losses(case: Case, feed: str) -> None:
    made = case.reconstruct(feed)
    for name, value in (("mse", made.recon), ("kld", made.kl)):
        torch.testing.assert_close(value, case.arrays[f"{feed}_{name}"], rtol=LOSS, atol=1e-8)
    logged = made.logged()
    assert {f"{feed}_log_{name}" for name in logged} == {n for n in case.arrays if n.startswith(f"{feed}_log")}
    for name, value in logged.items():
        assert value == pytest.approx(case.arrays[f"{feed}_log_{name}"].item(), rel=LOSS), name


def test_golden_gradients_and_step(case: Case) -> None:
    networks = case.model.networks
    optimizer = torch.optim.Adam(networks.parameters(), **ADAM)
    case.reconstruct("gtfeed").loss().backward()
    gradients = to_official({name: p.grad for name, p in networks.named_parameters() if p.grad is not None})
    optimizer.step()
    after = to_official(networks.state_dict())
    assert {f"{name}.grad" for name in gradients} | {f"{name}.after_step" for name in after} == set(case.step)
    for name, gradient in gradients.items():
        expected, size = case.step[f"{name}.grad"], case.step[f"{name}.grad"].abs()
        close(gradient, expected, GRADIENT * size.max().item(), name)
        # Adam's first step is the sign of the gradient: where that is about zero, rounding decides
        decided = size > 1e-5 * size.max() + 1e-7
        close(after[name][decided], case.step[f"{name}.after_step"][decided], STEP, name)
        close(after[name][~decided], case.step[f"{name}.after_step"][~decided], STEP_UNDECIDED, name)
        assert decided.double().mean() > 0.2, name


def test_golden_sampling(case: Case) -> None:
    a = case.arrays
    made = case.model.sample(a["labels"], a["eps_prior_sample"], bones=a.get("sample_bone_source"))
    for name, value in (("z", made.z), ("mu", made.mu), ("logvar", made.logvar), ("decoder_out", made.raw)):
        close(value, a[f"sample_{name}"], FORWARD, name)
    close(made.joints.flatten(-2), a["sample_joints"], FORWARD, "joints")
