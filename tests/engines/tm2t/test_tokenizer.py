"""The tokenizer: what it is shown, how gradients pass the codebook, how entries follow latents."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.tm2t.losses import _movement, vq_losses
from engines.tm2t.model import HIDDEN_FEATURES, LAYOUT
from engines.tm2t.tokenizer import AveragedCodebook, Codebook, perplexity
from tests.engines.tm2t.tiny import model


def test_contacts_are_told_and_not_given() -> None:
    net = model()
    assert net.tokenizer.shown == LAYOUT.size - HIDDEN_FEATURES == LAYOUT["contacts"].start
    features = torch.randn(2, 16, LAYOUT.size)
    other = features.clone()
    other[..., LAYOUT["contacts"]] += 5
    assert torch.equal(net.tokenizer.encode(features), net.tokenizer.encode(other))
    assert net.tokenizer(features)[0].shape == features.shape
    assert vq_losses(net, other)["reconstruction"] > vq_losses(net, features)["reconstruction"]


def test_a_swing_that_is_missing_counts_more_than_a_place_that_is_off() -> None:
    """Of two tokenizers that are off by as much, one keeps how the body moves; in quiet windows it counts more."""
    swing = torch.zeros(1, 40, LAYOUT.size)
    swing[..., LAYOUT["positions"].start] = torch.sin(torch.arange(40.0))
    off = swing + 2 / np.pi  # a sine is so far from zero on average
    missing = _movement(torch.zeros_like(swing), swing)
    assert missing > 0
    assert _movement(off, swing) == pytest.approx(0, abs=1e-6)
    lively = swing.clone()
    lively[..., LAYOUT["rotations"]] = torch.randn(40, LAYOUT.part("rotations").size)
    still = lively.clone()
    still[..., LAYOUT["positions"]] = 0
    assert _movement(still, lively) < missing
    assert "movement" not in vq_losses(model(movement_weight=0.0), swing)


@pytest.mark.parametrize("frames", [4, 7, 30, 61])
def test_four_frames_make_a_token(frames: int) -> None:
    net = model()
    codes = net.tokenizer.encode(torch.randn(1, frames, LAYOUT.size))
    assert codes.shape == (1, frames // 4)
    assert net.tokenizer.decode(codes).shape == (1, 4 * (frames // 4), LAYOUT.size)


@given(st.integers(1, 5), st.integers(1, 9), st.integers(2, 20), st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_the_nearest_entry_is_found(batch: int, count: int, codes: int, seed: int) -> None:
    torch.manual_seed(seed)
    book = Codebook(codes, 3)
    latents = torch.randn(batch, count, 3)
    naive = torch.cdist(latents, book.weight.expand(batch, -1, -1)).argmin(-1)
    assert torch.equal(book.nearest(latents), naive)


def test_gradients_go_straight_through() -> None:
    torch.manual_seed(0)
    book, latents = Codebook(5, 3), torch.randn(2, 4, 3, requires_grad=True)
    coded = book(latents)
    torch.testing.assert_close(coded.passed, coded.entries)
    (coded.passed * torch.arange(3.0)).sum().backward()
    assert latents.grad is not None
    torch.testing.assert_close(latents.grad, torch.arange(3.0).expand(2, 4, 3))
    assert book.weight.grad is None


def test_by_gradients_both_sides_come_nearer() -> None:
    net = model(codebook_update="gradient")
    net.freeze_all_but("tokenizer")
    terms = vq_losses(net, torch.randn(2, 16, LAYOUT.size))
    assert set(terms) == {"reconstruction", "movement", "codebook", "commitment"}
    torch.testing.assert_close(terms["commitment"], net.config.commitment * terms["codebook"])
    terms["codebook"].backward()
    book = net.tokenizer.codebook.weight
    assert book.grad is not None
    assert all(p.grad is None for p in net.tokenizer.encoder.parameters())


def test_averages_follow_latents() -> None:
    """Against a plain loop over codes, three batches long."""
    torch.manual_seed(1)
    book = AveragedCodebook(4, 2, decay=0.9).train()
    uses, sums = np.zeros(4), book.weight.numpy().copy()
    for _ in range(3):
        latents = torch.randn(2, 6, 2)
        coded = book(latents)
        for code in range(4):
            mine = latents[coded.codes == code].numpy()
            uses[code] = 0.9 * uses[code] + 0.1 * len(mine)
            sums[code] = 0.9 * sums[code] + 0.1 * mine.sum(0)
        smooth = (uses + 1e-5) / (uses.sum() + 4e-5) * uses.sum()
        np.testing.assert_allclose(book.weight, sums / smooth[:, None], rtol=1e-5, atol=1e-6)
    before = book.weight.clone()
    book.eval()(torch.randn(1, 3, 2))
    assert torch.equal(book.weight, before)


def test_entries_that_are_never_used_wake() -> None:
    torch.manual_seed(0)
    book = AveragedCodebook(8, 2, least=0.05).train()
    latents = 10 + torch.randn(1, 64, 2)  # far from all entries
    book(latents)
    used = len(book.nearest(latents).unique())
    assert used >= 4
    sleepy = AveragedCodebook(8, 2).train()
    sleepy(latents)
    assert len(sleepy.nearest(latents).unique()) < used


def test_perplexity_counts_what_is_used() -> None:
    assert float(perplexity(torch.arange(8), 8)) == pytest.approx(8, rel=1e-5)
    assert float(perplexity(torch.zeros(8, dtype=torch.long), 8)) == pytest.approx(1, rel=1e-5)
