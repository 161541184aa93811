"""Loss terms: nothing to lose at the truth, what each of them sees, and the divergence against the library's."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch.distributions import Normal, kl_divergence

from engines.action2motion.config import DECODERS
from engines.action2motion.data import Sequences
from engines.action2motion.losses import gaussian_kl, kl_weight, losses
from engines.action2motion.model import Poses
from engines.action2motion.train import FEET
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import clips, config, model

ROUNDING = 22 * 1.2e-4
"""Each distance is the root of its square plus 1e-8."""


@pytest.fixture(scope="module")
def batch():
    return Sequences(clips(), config()).draw(np.random.default_rng(0))


def terms(made, batch, monkeypatch=None, step: int = 0, **changed):
    """The losses of a pass whose decoder gives the truth, some parts of it changed."""
    if monkeypatch is not None:
        gaussians = (torch.zeros(*batch.mask.shape, made.config.latent_size),) * 4
        truth = {"vectors": batch.vectors, "positions": batch.positions, "matrices": batch.matrices}
        poses = Poses(**{**truth, "velocity": batch.velocity, **changed})
        monkeypatch.setattr(made, "reconstruct", lambda *_: (poses, gaussians))
    return losses(made, batch, step, FEET, torch.Generator().manual_seed(0))


def test_nothing_is_lost_at_the_truth(batch, monkeypatch) -> None:
    found = terms(model(), batch, monkeypatch)
    assert set(found) == {"reconstruction", "kl", "alignment", "rotation", "velocity", "contact"}
    assert found["kl"] == 0
    assert found["rotation"] == 0
    assert found["reconstruction"] < ROUNDING
    assert found["velocity"] < ROUNDING
    assert found["alignment"] <= 10 * 1.2e-4
    # a standing foot still moves a little by the detector's measure: below its speed limit
    assert found["contact"] < 2.0 * 4 * 0.05


def test_each_term_sees_its_own_error(batch, monkeypatch) -> None:
    made = model()
    truth = {name: float(value) for name, value in terms(made, batch, monkeypatch).items()}
    moved = {name: float(v) for name, v in terms(made, batch, monkeypatch, positions=batch.positions + 0.1).items()}
    assert moved["reconstruction"] == pytest.approx(22 * 0.1 * 3**0.5, rel=1e-3)
    assert moved["velocity"] == pytest.approx(truth["velocity"], abs=1e-3)
    faster = {name: float(v) for name, v in terms(made, batch, monkeypatch, velocity=batch.velocity + 0.1).items()}
    assert faster["alignment"] == pytest.approx(10 * 0.1 * 3**0.5, rel=1e-3)
    assert faster["reconstruction"] == truth["reconstruction"]
    turned = {name: float(v) for name, v in terms(made, batch, monkeypatch, matrices=-batch.matrices).items()}
    assert turned["rotation"] == pytest.approx(4 * 3, rel=1e-4), "chordal, mean over joints"


def test_a_standing_foot_that_slides_costs_its_way(monkeypatch) -> None:
    """All four foot points stand, the body slides by 3 cm a frame."""
    made = model()
    still = Sequences(clips(1), made.config).windows(np.zeros(3, dtype=int), np.zeros(3, dtype=int))
    pose, ones = still.positions[:1].expand_as(still.positions), torch.ones_like(still.contacts)
    batch = type(still)(**{**vars(still), "positions": pose, "contacts": ones})
    slide = torch.zeros_like(batch.velocity)
    slide[..., 0] = 0.03
    found = terms(made, batch, monkeypatch, positions=pose, velocity=slide)
    assert float(found["contact"]) == pytest.approx(made.config.contact_weight * 4 * 0.03, rel=1e-2)
    assert len(FEET) == 4
    assert {SMPL22.joints[joint] for joint in FEET} == {"left_ankle", "left_foot", "right_ankle", "right_foot"}


@pytest.mark.parametrize("decoder", DECODERS)
def test_terms_of_every_decoder_train(decoder: str) -> None:
    made = model(decoder)
    batch = Sequences(clips(), made.config).draw(np.random.default_rng(1))
    found = terms(made, batch)
    assert ("rotation" in found) == (decoder != "plain")
    total = torch.stack(list(found.values())).sum()
    assert torch.isfinite(total)
    total.backward()
    assert all(p.grad is not None and torch.isfinite(p.grad).all() for p in made.parameters())


def test_paper_has_the_papers_terms_only(batch) -> None:
    made = model(rotation_weight=0.0, velocity_weight=0.0, contact_weight=0.0)
    assert set(terms(made, batch)) == {"reconstruction", "kl", "alignment"}


def test_divergence_is_the_librarys() -> None:
    mu_q, logvar_q, mu_p, logvar_p = torch.randn(4, 9, 5, 3, dtype=torch.float64)
    expected = kl_divergence(Normal(mu_q, (logvar_q / 2).exp()), Normal(mu_p, (logvar_p / 2).exp()))
    torch.testing.assert_close(gaussian_kl(mu_q, logvar_q, mu_p, logvar_p), expected)
    assert gaussian_kl(mu_q, logvar_q, mu_q, logvar_q).abs().max() < 1e-12


def test_the_divergences_weight_rises_then_stays() -> None:
    made = config(kl_weight=(0.001, 0.021), kl_rise=0.5, steps=100)
    assert [kl_weight(made, step) for step in (0, 25, 50, 100)] == pytest.approx([0.001, 0.011, 0.021, 0.021])
