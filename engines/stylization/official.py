"""The authors' checkpoints: their names of the weights -> ours. The networks are the same.

What the released code does differently is in `engines.features.official_style` (its features), and here: a motion-based
style is sampled and not its mean, and the codes of a variational autoencoder are sampled as well.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import torch
from torch import Tensor

from engines.errors import CheckpointError
from engines.stylization.config import StylizationConfig
from engines.stylization.model import Stylizer

_NAMES = (
    (r"^ae_encoder\.model\.2\.Conv\.conv", "encoder.output"),
    (r"^ae_encoder\.model\.(\d)\.Conv\.conv", r"encoder.down.\1"),
    (r"^ae_decoder\.model\.0\.Conv\.conv", "decoder.first"),
    (r"^ae_decoder\.model\.1\.conv1\.1\.conv", "decoder.up.0"),
    (r"^ae_decoder\.model\.2\.conv1\.1\.conv", "decoder.up.1"),
    (r"^ae_decoder\.model\.3\.Conv\.conv", "decoder.output"),
    (r"^encoder\.(content|style)_encoder\.ToMidPoint\.(\d)\.Conv\.conv", r"\1.down.\2"),
    (r"^encoder\.content_encoder\.ToSpatialCode\.(\d)\.Conv\.conv", r"content.code.\1"),
    (r"^encoder\.style_encoder\.ToGlobalCode\.3\.Conv\.conv", "style.output"),
    (r"^encoder\.style_encoder\.ToGlobalCode\.(\d)\.Conv\.conv", r"style.code.\1"),
    (r"^decoder\.layers\.(\d)\.adain1\.style_net\.linear", r"generator.layers.\1.style"),
    (r"^decoder\.layers\.(\d)\.conv1(\.1)?\.conv", r"generator.layers.\1.convolution"),
    (r"^decoder\.out_linear\.Conv\.conv", "generator.output"),
    (r"^regressor\.layers\.3\.Conv\.conv", "regressor.output"),
    (r"^regressor\.layers\.(\d)\.Conv\.conv", r"regressor.layers.\1"),
)
"""Patterns of their names -> ours."""


def renamed(stored: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Their weights under our names; the classifiers, which `engines.metrics.official` reads, are left out."""
    made = {}
    for name, value in stored.items():
        if "classifier" in name:
            continue
        for pattern, ours in _NAMES:
            found, count = re.subn(pattern, ours, name)
            if count:
                made[found] = value
                break
        else:
            raise CheckpointError(f"the checkpoint holds {name!r}, which no network of stylization has")
    return made


def build(stored: Mapping[str, Tensor], styles: int = 0) -> Stylizer:
    """The networks of a checkpoint, sizes read off its weights.

    Args:
        stored: their names -> weights, of all networks (prefixes ae_encoder, ae_decoder, encoder, decoder, regressor).
        styles: how many style labels it was told in training; 0 for an unsupervised one.

    Raises:
        CheckpointError: a weight is missing, unknown or of another size.
    """
    weights = renamed(stored)
    try:
        rows = {name: weights[f"{name}.weight"].shape[0] for name in (
            "encoder.down.0", "encoder.down.1", "decoder.first", "decoder.up.0", "decoder.up.1", "content.down.0",
            "content.code.0", "content.code.1", "style.code.0", "style.code.1", "style.output",
            "generator.layers.0.convolution", "generator.layers.1.convolution", "generator.layers.2.convolution",
            "generator.output", "encoder.output", "regressor.layers.0", "regressor.layers.1", "regressor.layers.2",
        )}  # fmt: skip
    except KeyError as error:
        raise CheckpointError(f"the checkpoint lacks {error}; it must hold all networks of stylization") from error
    config = StylizationConfig(
        latent="vae" if rows["encoder.output"] == 2 * rows["generator.output"] else "ae",
        supervised=styles > 0,
        styles=tuple(f"style {i}" for i in range(styles)),
        encoder=(rows["encoder.down.0"], rows["encoder.down.1"]),
        latent_size=rows["generator.output"],
        decoder=(rows["decoder.first"], rows["decoder.up.0"], rows["decoder.up.1"]),
        mid=(rows["content.down.0"],),
        content=(rows["content.code.0"], rows["content.code.1"]),
        style=(rows["style.code.0"], rows["style.code.1"]),
        style_size=rows["style.output"] // 2,
        generator=tuple(rows[f"generator.layers.{i}.convolution"] for i in range(3)),
        regressor=tuple(rows[f"regressor.layers.{i}"] for i in range(3)),
    )
    model = Stylizer(config)
    try:
        missing, unknown = model.load_state_dict(weights, strict=False)
    except RuntimeError as error:
        raise CheckpointError(f"the checkpoint is of other networks: {error}") from error
    if unknown or set(missing) - {"mean", "std"}:
        raise CheckpointError(f"the checkpoint does not fit: {', '.join([*missing, *unknown])}")
    return model.eval()


def stylised(  # noqa: PLR0913, PLR0917 - what the release draws from
    model: Stylizer,
    content: Tensor,
    style: Tensor,
    label: Tensor | None,
    codes: tuple[Tensor | None, Tensor | None],
    noise: Tensor,
    from_prior: bool = False,
) -> Tensor:
    """Features (B, T, D) as the release generates them: every Gaussian is drawn from.

    Args:
        model: from `build`.
        content: (B, T, D) normalised.
        style: (B, T, D) normalised; only its size matters with `from_prior`.
        label: (B, S) one-hot.
        codes: noise of the two motion codes of a variational autoencoder.
        noise: (B, K) of the style.
        from_prior: the style is the noise itself.
    """
    with torch.no_grad():
        own, other = (model.encode(m, n) for m, n in zip((content, style), codes, strict=True))
        told = noise if from_prior else model.style_of(other, label).sample(noise)
        return model.assembled(content, model.generate(model.content(own), told, label))
