"""What the released Text2Motion does otherwise than paper and thesis, for its checkpoints and their numbers.

- The text encoder's backward half is turned round in time, and attention sees padding, so that a result depends on the
  longest sentence of the batch; layers of prior and posterior all hear the input (`Sizes.release`).
- Times to arrival below one, of motions that have ended while others go on, are looked up from the table's end.
- The differences of codes and motions are smooth (SmoothL1), and their two weights are exchanged.
- The divergence is summed and divided by steps and batch; every network's gradient is shortened by itself.
- A length is drawn anew, up to two more times, where it is under 10 codes (6 for KIT-ML).
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional as nnf

from engines.text2motion.losses import divergence
from engines.text2motion.model import Autoencoder, TemporalVAE, Unrolled, unroll
from engines.text2motion.networks import UNIT

CLIP_NORM = 0.5
SENTENCE = 20
"""Words read of a sentence, besides its marks."""
LEAST = {263: 10, 251: 6}
"""Size of the features -> codes from which on a drawn length is taken."""
DRAWS = 3
LONGEST = 196
"""Frames."""


class Forced(NamedTuple):
    """A training pass."""

    told: Unrolled
    motions: Tensor
    """(B, T, D) normalised."""
    real: Tensor
    """(B, S, C) codes."""


def forced(  # noqa: PLR0913, PLR0917 - two networks, a batch, and how it is fed
    vae: TemporalVAE, autoencoder: Autoencoder, words: Tensor, tags: Tensor, lengths: Tensor, motions: Tensor,
    frames: Tensor, noise: Tensor, teacher: bool, from_prior: bool = False,
) -> Forced:  # fmt: skip
    """A pass over a batch as the release's training does it.

    Args:
        vae: its networks.
        autoencoder: the frozen encoder, and the decoder.
        words: (B, N, E) vectors.
        tags: (B, N, K) one-hot.
        lengths: (B,) words.
        motions: (B, T, D) normalised.
        frames: (B,) of each motion; all T are passed over.
        noise: (B, S, Z) of the latents that the generator hears.
        teacher: feed the real codes.
        from_prior: the generator hears draws of the prior.
    """
    with torch.no_grad():
        real = autoencoder.encode(motions)
    rows = torch.full((len(motions),), teacher)
    read = vae.reader(words, tags, lengths)
    told = unroll(vae, read, real, frames // UNIT, start(autoencoder, len(motions)), noise, rows, from_prior)
    return Forced(told, autoencoder.decode(told.codes), real)


def losses(made: Forced, motions: Tensor, codes: float, motion: float, kl: float) -> dict[str, Tensor]:
    """The release's terms, before weights, and their sum `total` with its weights.

    Args:
        made: a pass.
        motions: (B, T, D) the real ones, normalised.
        codes: lambda_rec_mov, by which the release multiplies the motion's term.
        motion: lambda_rec_mot, by which it multiplies the codes' term.
        kl: lambda_kld.
    """
    terms = {
        "motion": nnf.smooth_l1_loss(made.motions, motions),
        "codes": nnf.smooth_l1_loss(made.told.codes, made.real),
        "kl": divergence(made.told.posterior, made.told.prior).mean(),
    }
    return {**terms, "total": codes * terms["motion"] + motion * terms["codes"] + kl * terms["kl"]}


def shorten(vae: TemporalVAE, autoencoder: Autoencoder) -> None:
    """Each network's gradient, by itself, to `CLIP_NORM` at most."""
    for net in (*vae.children(), autoencoder.decoder):
        nn.utils.clip_grad_norm_(net.parameters(), CLIP_NORM)


def start(autoencoder: Autoencoder, count: int) -> Tensor:
    """(B, C) the code of a snippet of zeros, which comes before the first."""
    shown = autoencoder.encoder.first.weight.new_zeros(1, UNIT, autoencoder.shown)
    return autoencoder.encoder(shown)[:, 0].detach().expand(count, -1)


def drawn_length(logits: Tensor, uniform: Tensor, least: int) -> int:
    """Codes of a motion, drawn from the estimator's classes, and anew where they are few.

    Args:
        logits: (classes,); a class is a number of codes.
        uniform: (`DRAWS`,) in [0, 1).
        least: codes from which on a draw is taken.
    """
    sums = logits.double().softmax(-1).cumsum(-1)
    found = 0
    for draw in uniform.tolist():
        found = min(int((sums <= draw * float(sums[-1])).sum()), len(logits) - 1)
        if found >= least:
            break
    return max(1, found)
