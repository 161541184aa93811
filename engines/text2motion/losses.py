"""What each stage makes small, named terms: equations 4.2 and 4.6 of the thesis, and the cross entropy of 4.2.2.

The sums of the equations are means here, over frames or codes and over the numbers of each, so that weights do not
depend on lengths; the divergence is summed over the numbers of a latent.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional as nnf

from engines.text2motion.data import MotionBatch, TextBatch
from engines.text2motion.model import Text2Motion, unroll
from engines.text2motion.networks import Gaussian
from engines.training.devices import ALONE, Share


def autoencoder_losses(model: Text2Motion, features: Tensor) -> dict[str, Tensor]:
    """Equation 4.2, of features (B, T, D) that are not normalised; contacts are told, not given."""
    assert model.autoencoder is not None
    real = model.normalised(features)
    codes = model.autoencoder.encode(real)
    made = model.autoencoder.decode(codes)
    return autoencoder_terms(real, made, codes, model.config.sparsity, model.config.smoothness)


def autoencoder_terms(real: Tensor, made: Tensor, codes: Tensor, sparsity: float, smoothness: float) -> dict:
    """The three terms of equation 4.2, of features (B, T, D) and codes (B, S, C)."""
    return {
        "reconstruction": nnf.l1_loss(made, real),
        "sparsity": sparsity * codes.abs().mean(),
        "smoothness": smoothness * codes.diff(dim=1).abs().mean(),
    }


def text2length_losses(model: Text2Motion, batch: TextBatch) -> dict[str, Tensor]:
    """Cross entropy of the real lengths, a mean over sentences."""
    logits = model.length_logits(batch.words)
    return {"length": nnf.cross_entropy(logits, batch.units - 1, reduction="sum") / batch.sentences}


def text2motion_losses(  # noqa: PLR0913, PLR0917 - a batch, and how it is learned from
    model: Text2Motion, batch: MotionBatch, generator: torch.Generator, teacher_forcing: float, kl_weight: float,
    share: Share = ALONE,
) -> dict[str, Tensor]:  # fmt: skip
    """Equation 4.6: codes, decoded motion, and the divergence of posterior and prior.

    Args:
        model: with text2motion.
        batch: motions, cut to the codes that are aimed for, and sentences.
        generator: of noise and coins, which are drawn for the whole batch.
        teacher_forcing: chance that a motion is fed with its real codes.
        kl_weight: lambda_KL now.
        share: which part of the batch this is.
    """
    net, texts = model.text2motion, batch.texts
    assert net is not None
    real_motion = model.normalised(batch.features)
    with torch.no_grad():
        real = model.encode(real_motion, batch.count).repeat_interleave(texts, 0)
    rows, steps = real.shape[:2]
    teacher = _drawn(torch.rand, (len(batch.features), texts), generator, share) < teacher_forcing
    noise = _drawn(torch.randn, (len(batch.features), texts, steps, net.sizes.latent), generator, share)
    read = model.read(batch.words)
    count, whole = (values.repeat_interleave(texts) for values in (batch.count, batch.whole))
    told = unroll(net, read, real, whole, model.start(rows), noise.flatten(0, 1), teacher.flatten())
    there = torch.arange(steps, device=real.device) < count[:, None]
    terms = {"codes": _difference(told.codes, real, there) / batch.steps}
    if model.autoencoder is not None:
        made = model.decode(told.codes, count)
        frames = there.repeat_interleave(model.config.frames_a_code, 1)
        motion = _difference(made, real_motion.repeat_interleave(texts, 0), frames) / model.config.frames_a_code
        terms["motion"] = model.config.motion_weight * motion / batch.steps
    terms["kl"] = kl_weight * (divergence(told.posterior, told.prior) * there).sum() / batch.steps
    return terms


def divergence(first: Gaussian, second: Gaussian) -> Tensor:
    """(...) KL divergence of normal distributions (..., Z) of the first from the second."""
    mean, logvar, other, other_logvar = (value.float() for value in (*first, *second))
    apart = (logvar.exp() + (mean - other).square()) / other_logvar.exp()
    return 0.5 * (other_logvar - logvar + apart - 1).sum(-1)


def _difference(made: Tensor, real: Tensor, there: Tensor) -> Tensor:
    """Absolute difference of (B, S, C), the mean over C, summed over what is there (B, S)."""
    return ((made - real).abs().float().mean(-1) * there).sum()


def _drawn(draw, shape: tuple[int, ...], generator: torch.Generator, share: Share) -> Tensor:
    """This process's rows of what is drawn for the whole batch."""
    whole = draw((shape[0] * share.world, *shape[1:]), generator=generator)
    return whole[share.rows].to(share.device)
