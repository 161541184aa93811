"""What the released TM2T does otherwise than the thesis, for its checkpoints and their numbers.

- Text2motion's sentence encoder turns its backward half round in time, and its attention sees padding, so that a
  result depends on the longest caption of the batch (`GRUSizes.release`).
- Gumbel-sampling rules out the marks but not padding, passes no gradient through the tokens it feeds back, and what it
  gives motion2text has [BOM] but no [EOM].
- Beams that have ended grow on, and their scores with them; only in the end are they cut.
- A codebook that follows by averages never hears of new latents (`AveragedCodebook(release=True)`).
- The tokenizer is trained with a hinge GAN from epoch 10 on, of which neither paper nor thesis speaks.
- Losses are sums over tokens.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional as nnf

from engines.tm2t.attentive import AttentiveGRU, unroll
from engines.tm2t.sampling import gumbel_sample, straight_through
from engines.tm2t.search import ALPHA, BeamSteps
from engines.tm2t.tokenizer import SLOPE, Coded, MotionTokenizer
from engines.tm2t.transformer import Source, Translator
from engines.tm2t.vocabulary import MotionTokens

MAX_STEPS, TOP_K = 49, 100
"""Tokens of a motion at most, and among how many of the likeliest each is drawn."""
BEAMS, MAX_WORDS = 2, 30
CLIP_NORM = 0.5
"""Of gradients, in the joint training."""


def text_loss(logits: Tensor, gold: Tensor, pad: int, smoothing: float = 0.0) -> Tensor:
    """Cross entropy summed over what is not padding; smoothing is spread over the other classes.

    Args:
        logits: (..., V).
        gold: (...) indices.
        pad: index that does not count.
        smoothing: taken from the right class.
    """
    logs, gold = logits.flatten(0, -2).log_softmax(-1), gold.flatten()
    right = logs.gather(1, gold[:, None])[:, 0]
    if smoothing:
        others = (logs.sum(-1) - right) / (logs.shape[-1] - 1)
        right = (1 - smoothing) * right + smoothing * others
    return -(right * (gold != pad)).sum()


def correct(logits: Tensor, gold: Tensor, pad: int) -> tuple[int, int]:
    """How many of the words that are there were the likeliest, and how many there are."""
    there = gold != pad
    return int(((logits.argmax(-1) == gold) & there).sum()), int(there.sum())


def forced(net: AttentiveGRU, words: Tensor, lengths: Tensor, tokens: Tensor, teacher: bool) -> Tensor:
    """(B, S, V) logits over a batch: each step fed with the real token, or with the likeliest of the step before."""
    return unroll(net, net.read(words, lengths), tokens, teacher)


class Cycle(NamedTuple):
    """A batch brought from words to motion tokens and back."""

    tokens: Tensor
    """(B, 1 + S) drawn, from [BOM] on."""
    lengths: Tensor
    """(B,) steps before [EOM] was the likeliest."""
    logits: Tensor
    """(B, N, V) of the words."""


def cycle(  # noqa: PLR0913, PLR0917 - two networks and a batch
    net: AttentiveGRU, back: Translator, words: Tensor, lengths: Tensor, targets: Tensor, noise: Tensor, pad_word: int
) -> Cycle:
    """Inverse alignment as the release has it.

    Args:
        net: text2motion.
        back: motion2text, frozen.
        words: (B, N, E) vectors.
        lengths: (B,) of the captions.
        targets: (B, N) word indices, without the last.
        noise: (B, S, V) standard Gumbel draws.
        pad_word: index of padding in the targets.
    """
    tokens = MotionTokens(noise.shape[-1] - 3)
    drawn = gumbel_sample(net.steps(net.read(words, lengths)), tokens, noise, release=True)
    shares = _with_begin(drawn.shares, tokens)
    there = torch.arange(shares.shape[1]) < (drawn.lengths + 1)[:, None]
    logits = back(back.read_shares(shares, there), targets, targets != pad_word)
    return Cycle(shares.argmax(-1), drawn.lengths, logits)


def joint_shares(logits: Tensor, noise: Tensor, temperature: float = 1.0) -> Tensor:
    """(B, 1 + S, V) what motion2text gets of the transformer: one draw on teacher-forced logits, after [BOM]."""
    return _with_begin(straight_through(logits, noise, temperature), MotionTokens(logits.shape[-1] - 3))


def _with_begin(shares: Tensor, tokens: MotionTokens) -> Tensor:
    begin = torch.zeros_like(shares[:, :1])
    begin[..., tokens.begin] = 1.0
    return torch.cat([begin, shares], dim=1)


class OfficialBeams(NamedTuple):
    """The end of a search."""

    result: list[int]
    """From the start mark, with the end mark if one was found."""
    beams: Tensor
    """(K, longest)."""
    scores: list[Tensor]
    """(K,) after every step but the first."""


@torch.no_grad()
def beam_search(  # noqa: PLR0913, PLR0917 - a vocabulary's marks and two limits
    steps: BeamSteps, begin: int, end: int, pad: int, beams: int = BEAMS, longest: int = MAX_WORDS
) -> OfficialBeams:
    """The release's beam search, of one motion.

    Args:
        steps: fresh, with `beams` rows.
        begin: start mark of a sentence.
        end: its end mark.
        pad: fills what was not reached.
        beams: K.
        longest: words and both marks.
    """
    rows = torch.full((beams, longest), pad, dtype=torch.long)
    rows[:, 0] = begin
    first = steps.step(rows[:, 0])[0].log_softmax(-1)
    scores, rows[:, 1] = first.topk(beams)
    told = []
    for length in range(2, longest):
        total = scores[:, None] + steps.step(rows[:, length - 1]).log_softmax(-1)
        scores, best = total.flatten().topk(beams)
        beam, word = best // total.shape[-1], best % total.shape[-1]
        steps.choose(beam)
        rows[:, :length] = rows[beam, :length]
        rows[:, length] = word
        told.append(scores)
        if (rows == end).any(1).all():
            break
    ends = rows == end
    lengths = torch.where(ends.any(1), ends.int().argmax(1) + 1, longest)
    chosen = int((scores / lengths.float() ** ALPHA).argmax())
    return OfficialBeams(rows[chosen, : lengths[chosen]].tolist(), rows, told)


class Discriminator(nn.Module):
    """Tells real features from reconstructed ones, a score for every stretch.

    Args:
        features: D.
        hidden: channels after the first layer; halved by each further one.
        layers: how many halve the frames.
    """

    def __init__(self, features: int, hidden: int, layers: int) -> None:
        super().__init__()
        parts: list[nn.Module] = []
        before = features
        for depth in range(layers):
            after = hidden // 2**depth
            parts += [nn.Conv1d(before, after, 4, 2, 1), nn.BatchNorm1d(after), nn.LeakyReLU(SLOPE)]
            before = after
        self.layers = nn.Sequential(*parts)
        self.out = nn.Conv1d(before, 1, 3, 1, 1)

    def forward(self, features: Tensor) -> Tensor:
        """(B, T, D) -> (B, t, 1)."""
        return self.out(self.layers(features.transpose(1, 2))).transpose(1, 2)


def discriminator_of(state: Mapping[str, Tensor]) -> Discriminator:
    """The discriminator whose weights these are, names with the prefix discriminator."""
    own = {name.removeprefix("discriminator."): value for name, value in state.items() if "discriminator." in name}
    ours = {re.sub(r"^main\.", "layers.", name).replace("out_net.", "out."): value for name, value in own.items()}
    hidden, features, _ = ours["layers.0.weight"].shape
    layers = sum(value.ndim == 3 for name, value in ours.items() if name.startswith("layers."))
    net = Discriminator(features, hidden, layers)
    net.load_state_dict(ours)
    return net


def vq_losses(features: Tensor, made: Tensor, coded: Coded, beta: float = 1.0) -> dict[str, Tensor]:
    """The release's terms: reconstruction, and both parts of the embedding loss as one."""
    codebook = nnf.mse_loss(coded.entries, coded.latents.detach())
    commitment = nnf.mse_loss(coded.latents, coded.entries.detach())
    return {"reconstruction": nnf.l1_loss(made, features), "embedding": codebook + beta * commitment}


class VQStep(NamedTuple):
    """What one of the release's updates logged."""

    total: Tensor
    terms: dict[str, Tensor]
    codes: Tensor


def vq_update(  # noqa: PLR0913, PLR0917 - two sets of weights, one batch
    net: MotionTokenizer, judge: Discriminator, features: Tensor, optimisers: list[torch.optim.Optimizer],
    judge_optimiser: torch.optim.Optimizer, adversarial: float = 0.0,
) -> VQStep:  # fmt: skip
    """One update of the tokenizer, and before it of the discriminator where there is an adversarial term.

    Args:
        net: tokenizer.
        judge: discriminator.
        features: (B, T, D) normalised.
        optimisers: of the tokenizer's networks.
        judge_optimiser: of the discriminator.
        adversarial: weight of the hinge GAN; 0: none.
    """
    made, coded = net(features)
    terms = vq_losses(features, made, coded)
    if adversarial:
        real, false = judge(features), judge(made.detach())
        hinge = adversarial * 0.5 * (torch.relu(1 - real).mean() + torch.relu(1 + false).mean())
        judge_optimiser.zero_grad()
        hinge.backward()
        judge_optimiser.step()
        terms["adversarial"] = -judge(made).mean()
    total = terms["reconstruction"] + terms["embedding"] + adversarial * terms.get("adversarial", torch.zeros(()))
    for optimiser in optimisers:
        optimiser.zero_grad()
    total.backward()
    for optimiser in optimisers:
        optimiser.step()
    if adversarial:
        terms["discriminator"] = hinge.detach()
    return VQStep(total.detach(), {name: value.detach() for name, value in terms.items()}, coded.codes)


__all__ = [
    "BEAMS", "CLIP_NORM", "MAX_STEPS", "MAX_WORDS", "TOP_K", "Cycle", "Discriminator", "OfficialBeams", "Source",
    "VQStep", "beam_search", "correct", "cycle", "discriminator_of", "forced", "joint_shares", "text_loss", "vq_losses",
    "vq_update",
]  # fmt: skip
