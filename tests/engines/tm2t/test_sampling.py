"""Drawing tokens: the end, a length that is told, streams of their own, gradients through one-hot draws."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import torch

from engines.text.words import Words
from engines.tm2t.losses import between_marks
from engines.tm2t.sampling import (
    SoftDrawn,
    gumbel_noise,
    gumbel_sample,
    pick,
    sample,
    straight_through,
    top_k,
    uniforms,
)
from engines.tm2t.search import beam_search
from engines.tm2t.vocabulary import MotionTokens

TOKENS = MotionTokens(4)


class Table:
    """A decoder whose logits are written down: by the last token, and by how far it is."""

    def __init__(self, logits: torch.Tensor, end_at: int | None = None, end: int = TOKENS.end) -> None:
        self.logits, self.end_at, self.end, self.at = logits, end_at, end, 0

    def step(self, tokens: torch.Tensor) -> torch.Tensor:
        made = self.logits[tokens].clone()
        if self.at == self.end_at:
            made[:, self.end] = 50.0
        self.at += 1
        return made

    def step_shares(self, shares: torch.Tensor) -> torch.Tensor:
        return self.step(shares.argmax(-1)) + 0 * shares.sum()

    def choose(self, rows: torch.Tensor) -> None:
        """Nothing is kept by row."""


def table(size: int = TOKENS.size, seed: int = 0) -> torch.Tensor:
    return torch.randn(size, size, generator=torch.Generator().manual_seed(seed))


def test_the_end_token_ends() -> None:
    uniform = uniforms(3, range(5), 10)
    drawn = sample(Table(table() - 5, end_at=6), TOKENS, uniform)
    assert (drawn.lengths <= 6).all()
    assert (drawn.lengths == 6).any()
    for row, length in zip(drawn.tokens, drawn.lengths.tolist(), strict=True):
        assert (row[:length] < TOKENS.codes).all()
        if length < drawn.tokens.shape[1]:
            assert row[length] == TOKENS.end


def test_a_length_that_is_told_is_kept() -> None:
    drawn = sample(Table(table(), end_at=2), TOKENS, uniforms(0, range(3), 10), exactly=7)
    assert drawn.tokens.shape == (3, 7)
    assert drawn.lengths.tolist() == [7, 7, 7]
    assert (drawn.tokens < TOKENS.codes).all()
    least = sample(Table(table(), end_at=0), TOKENS, uniforms(0, range(3), 10), least=3)
    assert (least.lengths >= 3).all()


def test_marks_alone_leave_a_code() -> None:
    logits = torch.full((TOKENS.size, TOKENS.size), -torch.inf)
    logits[:, TOKENS.pad] = 0.0
    assert (sample(Table(logits), TOKENS, uniforms(0, range(3), 4)).tokens < TOKENS.codes).all()


def test_a_motion_has_its_own_stream() -> None:
    whole, part = uniforms(7, range(4), 5), uniforms(7, range(2, 4), 5)
    assert torch.equal(whole[2:], part)
    assert not torch.equal(whole, uniforms(8, range(4), 5))
    assert len(np.unique(whole.numpy())) == whole.numel()


def test_draws_follow_their_chances() -> None:
    chances = torch.tensor([[0.1, 0.0, 0.6, 0.3]])
    uniform = torch.linspace(0, 1 - 1e-9, 1001, dtype=torch.float64)
    drawn = pick(chances.expand(1001, -1), uniform)
    shares = torch.bincount(drawn, minlength=4) / 1001
    torch.testing.assert_close(shares, chances[0], atol=2e-3, rtol=0)
    assert pick(chances, torch.tensor([1.0])).item() == 3


def test_top_k_leaves_the_likeliest() -> None:
    logits = torch.tensor([[3.0, 1.0, 2.0, 0.0]])
    assert torch.isfinite(top_k(logits, 2)).tolist() == [[True, False, True, False]]
    assert torch.equal(top_k(logits, 0), logits)
    assert torch.equal(top_k(logits, 9), logits)


def test_straight_through_is_one_hot_and_passes_gradients() -> None:
    logits = table().requires_grad_()
    made = straight_through(logits, gumbel_noise(tuple(logits.shape), torch.Generator().manual_seed(0)), 0.7)
    torch.testing.assert_close(made.max(-1).values, torch.ones(len(logits)))
    torch.testing.assert_close(made.sum(-1), torch.ones(len(logits)))
    (made * table(seed=1)).sum().backward()
    assert logits.grad is not None
    assert (logits.grad.abs().sum(1) > 0).all()


def test_gumbel_draws_as_softmax_has_it() -> None:
    logits = torch.tensor([0.0, 1.0, -1.0])
    noise = gumbel_noise((20_000, 3), torch.Generator().manual_seed(0))
    shares = straight_through(logits.expand(20_000, -1), noise, 1.0).mean(0)
    torch.testing.assert_close(shares, logits.softmax(-1), atol=0.02, rtol=0)


def test_gumbel_sampling_ends_and_has_no_marks() -> None:
    noise = gumbel_noise((3, 9, TOKENS.size), torch.Generator().manual_seed(0))
    made = gumbel_sample(Table(table(), end_at=5), TOKENS, noise)
    assert (made.lengths <= 5).all()
    assert (made.shares[..., TOKENS.codes :] < 1e-6).all()


def test_what_motion2text_is_given_lies_between_marks() -> None:
    shares = torch.nn.functional.one_hot(torch.tensor([[1, 2, 3], [0, 3, 2]]), TOKENS.size).float()
    rows, there = between_marks(SoftDrawn(shares, torch.tensor([3, 1])), TOKENS)
    for row, seen, codes in zip(rows, there, ([1, 2, 3], [0]), strict=True):
        expected = TOKENS.rows([np.array(codes)])[0]
        assert row[seen].argmax(-1).tolist() == expected.tolist()
        assert row[~seen].abs().sum() == 0


# ---- beam search ------------------------------------------------------------------------------------------

WORDS = Words(("a", "b", "c"))


def exhaustive(logits: torch.Tensor, longest: int, alpha: float) -> list[tuple[float, list[int]]]:
    """Every sentence there is, scored one by one."""
    scored = []
    allowed = [0, 1, 2, WORDS.end]
    for count in range(1, longest):
        for words in itertools.product(range(3), repeat=count):
            score, last = 0.0, WORDS.begin
            for place, word in enumerate([*words, WORDS.end]):
                row = logits[last]
                among = allowed[:-1] if place == 0 else allowed
                score += float(row[word] - row[among].logsumexp(0))
                last = word
            scored.append((score / (count + 1) ** alpha, list(words)))
    return sorted(scored, reverse=True)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("alpha", [0.0, 0.7])
def test_beams_enough_find_what_an_exhaustive_search_finds(seed: int, alpha: float) -> None:
    logits = table(WORDS.size, seed)
    logits[:, WORDS.end] += 1.5
    (found,) = beam_search(Table(logits), WORDS, 1, beams=200, longest=5, alpha=alpha)
    ended = [one for one in found if one.ended]
    expected = exhaustive(logits, 5, alpha)
    assert [one.words for one in ended[:5]] == [words for _, words in expected[:5]]
    for one, (score, _) in zip(ended[:5], expected[:5], strict=True):
        assert one.score == pytest.approx(score, abs=1e-5)


def test_two_beams_beat_one() -> None:
    """The likeliest first word leads nowhere: greedy search takes it, two beams do not."""
    logits = torch.full((WORDS.size, WORDS.size), -4.0)
    logits[WORDS.begin, 0], logits[WORDS.begin, 1] = 0.1, 0.0
    logits[0, [0, 1, 2, WORDS.end]] = 0.0
    logits[1, WORDS.end] = 5.0
    (greedy,) = beam_search(Table(logits), WORDS, 1, beams=1, longest=3, alpha=0.0)
    (found,) = beam_search(Table(logits), WORDS, 1, beams=2, longest=3, alpha=0.0)
    assert greedy[0].words[0] == 0
    assert found[0].words == [1]
    assert found[0].score > greedy[0].score
