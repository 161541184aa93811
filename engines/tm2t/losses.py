"""What each stage makes small, named terms: equations 6.3, 6.4 and 6.7 of the thesis."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional as nnf

from engines.tm2t.attentive import AttentiveGRU, Read, unroll
from engines.tm2t.data import Batch
from engines.tm2t.model import LAYOUT, TM2T
from engines.tm2t.sampling import SoftDrawn, gumbel_noise, gumbel_sample, straight_through
from engines.tm2t.transformer import Source, Translator
from engines.tm2t.vocabulary import MotionTokens
from engines.training.devices import ALONE, Share

_MOVING = ("positions", "rotations")
_USUAL_STEP = 0.2
"""Of a normalised feature from frame to frame, in a walk."""


def vq_losses(model: TM2T, features: Tensor) -> dict[str, Tensor]:
    """Equation 6.3, of features (B, T, D) that are not normalised; contacts are told, not given.

    With `movement_weight` also how joints move: beside where a body is, the swing of a waving hand is next to nothing,
    and codes are not spent on it: a tokenizer without (512 entries) gave 55 of 95 held-out waves back as raised hands,
    the one that ships 21.
    """
    real = model.normalised(features)
    made, coded = model.tokenizer(real)
    terms = {"reconstruction": nnf.l1_loss(made, real)}
    if model.config.movement_weight > 0:
        terms["movement"] = model.config.movement_weight * _movement(made, real)
    if model.config.codebook_update == "gradient":
        terms["codebook"] = nnf.mse_loss(coded.entries, coded.latents.detach())
    terms["commitment"] = model.config.commitment * nnf.mse_loss(coded.latents, coded.entries.detach())
    return terms


def _movement(made: Tensor, real: Tensor) -> Tensor:
    """Mean absolute error of the steps of positions and rotations; in windows with little movement it counts more."""
    wanted, found = (torch.cat([x[..., LAYOUT[name]] for name in _MOVING], -1).diff(dim=1) for x in (real, made))
    missed = (found - wanted).abs().mean((1, 2))
    much = wanted.abs().mean((1, 2))
    return (missed * (_USUAL_STEP / (much + 0.05 * _USUAL_STEP)).clamp(0.5, 4.0)).mean()


def m2t_losses(model: TM2T, batch: Batch) -> dict[str, Tensor]:
    """Equation 6.4: what the right words are worth, a mean over words."""
    net = _motion2text(model)
    source = net.read(batch.tokens, batch.tokens != model.tokens.pad).repeated(batch.texts)
    return {"words": _words(model, source, batch)}


def t2m_losses(
    model: TM2T, batch: Batch, teacher: bool, generator: torch.Generator, share: Share = ALONE
) -> dict[str, Tensor]:
    """Equation 6.7: what the right tokens are worth, and what the sentence is worth to motion2text, given those made.

    Args:
        model: with motion2text, if `alignment` is above 0.
        batch: with word vectors.
        teacher: feed the attentive GRU with the real tokens, not with its own likeliest ones.
        generator: of the Gumbel noise, which is drawn for the whole batch.
        share: which part of the batch this is.
    """
    net, config = model.text2motion, model.config
    tokens = batch.tokens.repeat_interleave(batch.texts, 0)
    before, gold = tokens[:, :-1], tokens[:, 1:]
    read: Read | Source
    if isinstance(net, AttentiveGRU):
        read = net.read(batch.vectors, batch.lengths)
        logits = unroll(net, read, before, teacher)
    else:
        assert net is not None
        read = read_sentences(net, batch.vectors, batch.lengths)
        logits = net(read, before, before != model.tokens.pad)
    terms = {"tokens": _cross_entropy(logits, gold, model.tokens.pad, _smoothing(model)) / batch.steps}
    if config.alignment > 0 and model.training:
        shape = (len(gold) * share.world, gold.shape[1] - 1, model.tokens.size)
        noise = gumbel_noise(shape, generator)[share.rows].to(share.device)
        if isinstance(net, AttentiveGRU):
            steps = net.steps(read)  # pyright: ignore[reportArgumentType]
            drawn = gumbel_sample(steps, model.tokens, noise, config.temperature)
        else:
            drawn = _drawn_at_once(logits, gold, noise, model)
        source = _motion2text(model).read_shares(*between_marks(drawn, model.tokens))
        terms["inverse_alignment"] = config.alignment * _words(model, source, batch)
    return terms


def between_marks(drawn: SoftDrawn, tokens: MotionTokens) -> tuple[Tensor, Tensor]:
    """Nearly one-hot shares as motion2text knows motions: (B, S + 2, V) from [BOM] to [EOM], and which are there."""
    batch, count, size = drawn.shares.shape
    at = torch.arange(count + 2, device=drawn.shares.device)
    end = (drawn.lengths + 1)[:, None]
    whole = nnf.pad(drawn.shares, (0, 0, 1, 1)) * ((at > 0) & (at < end))[..., None]
    marks = torch.zeros(batch, count + 2, size, device=drawn.shares.device)
    marks[:, 0, tokens.begin] = 1.0
    marks[torch.arange(batch, device=marks.device), drawn.lengths + 1, tokens.end] = 1.0
    return whole + marks, at <= end


def read_sentences(net: Translator, vectors: Tensor, lengths: Tensor) -> Source:
    """Word vectors (B, N, E) of sentences of so many words, for a transformer."""
    there = torch.arange(vectors.shape[1], device=vectors.device) < lengths[:, None].to(vectors.device)
    return net.read(vectors, there)


def _drawn_at_once(logits: Tensor, gold: Tensor, noise: Tensor, model: TM2T) -> SoftDrawn:
    """A draw on teacher-forced logits, as long as the real motion: what a transformer can afford."""
    codes = torch.full((model.tokens.size,), -torch.inf, device=logits.device)
    codes[: model.tokens.codes] = 0.0
    lengths = ((gold != model.tokens.pad) & (gold != model.tokens.end)).sum(1)
    return SoftDrawn(straight_through(logits[:, :-1] + codes, noise, model.config.temperature), lengths)


def _words(model: TM2T, source: Source, batch: Batch) -> Tensor:
    net, pad = _motion2text(model), model.words.pad
    before, gold = batch.words[:, :-1], batch.words[:, 1:]
    logits = net(source, before, before != pad)
    return _cross_entropy(logits, gold, pad, _smoothing(model) if net.training else 0.0) / batch.said


def _smoothing(model: TM2T) -> float:
    """Only while learning: validation asks what is right."""
    return model.config.label_smoothing if model.training else 0.0


def _cross_entropy(logits: Tensor, gold: Tensor, pad: int, smoothing: float) -> Tensor:
    """Summed over what is not padding."""
    return nnf.cross_entropy(
        logits.flatten(0, 1), gold.flatten(), ignore_index=pad, reduction="sum", label_smoothing=smoothing
    )


def _motion2text(model: TM2T) -> Translator:
    assert model.motion2text is not None
    return model.motion2text
