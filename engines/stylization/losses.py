"""What the three trainings of latent stylization make small: named terms, thesis equations 5.1 to 5.4."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.func import functional_call
from torch.nn.functional import cross_entropy, smooth_l1_loss

from engines.stylization.config import StylizationConfig
from engines.stylization.model import LAYOUT, Stylizer
from engines.stylization.networks import Gaussian

Terms = dict[str, Tensor]


@dataclass(frozen=True)
class Draws:
    """The noise of a pass: of motion codes (for the variational autoencoder) and of the five style codes."""

    codes: tuple[Tensor | None, Tensor | None]
    styles: tuple[Tensor, Tensor, Tensor, Tensor, Tensor]


@dataclass(frozen=True)
class Pass:
    """What a pass of the style model makes on the way."""

    codes: tuple[Tensor, Tensor, Tensor]
    """z1, z2, z3."""
    rebuilt: tuple[Tensor, Tensor]
    """From their own content and style: of z1 and z2."""
    transferred: Tensor
    """z2's content in z3's style."""
    cycled: tuple[Tensor, Tensor]
    """z2 and z3, put together again from the transferred code."""
    styles: tuple[Gaussian, Gaussian, Gaussian, Gaussian]
    """Of z1, z2, z3 and the transferred code."""


def autoencoder(model: Stylizer, motion: Tensor, noise: Tensor | None) -> Terms:
    """Reconstruction, and codes that are small and smooth (ae) or near a normal draw (vae).

    Args:
        model: its encoder and decoder are trained.
        motion: (B, T, D) normalised.
        noise: (B, Z, L) of the variational code.
    """
    config: StylizationConfig = model.config
    gaussian = model.encoder(motion.mT[:, : LAYOUT["contacts"].start])
    code = gaussian.mean if noise is None or config.latent == "ae" else gaussian.sample(noise)
    terms = {"reconstruction": smooth_l1_loss(model.decode(code), motion)}
    if config.latent == "vae":
        terms["latent_kl"] = config.latent_kl_weight * to_normal(gaussian)
    else:
        terms["l1"] = config.l1_weight * code.abs().mean()
        terms["smooth"] = config.smooth_weight * (code[..., 1:] - code[..., :-1]).abs().mean()
    return terms


def regressor(model: Stylizer, motion: Tensor) -> Terms:
    """How far the root velocity of local movement is from the real one (mean absolute error)."""
    made = model.travel(motion, motion)
    return {"root_velocity": (made - motion[..., LAYOUT["root_velocity"]]).abs().mean()}


def swapped(values: Tensor) -> Tensor:
    """Rows of consecutive pairs exchanged: (0, 1, 2, 3) -> (1, 0, 3, 2)."""
    return values.unflatten(0, (-1, 2)).flip(1).flatten(0, 1)


def run(model: Stylizer, first: Tensor, second: Tensor, label: Tensor | None, draws: Draws) -> Pass:
    """Auto-encode, transfer and cycle (thesis, learning scheme); the autoencoder is not trained here.

    Args:
        model: its content and style encoders and generator are trained.
        first: (B, T, D) normalised; B is even.
        second: (B, T, D) of the same sequences as `first`.
        label: (B, S) one-hot style of both.
        draws: the noise.
    """
    with torch.no_grad():
        z1, z2 = (model.encode(m, noise) for m, noise in zip((first, second), draws.codes, strict=True))
    z3 = swapped(z2)
    other = None if label is None else swapped(label)
    styles = model.style_of(z1, label), model.style_of(z2, label), model.style_of(z3, other)
    content = model.content(z2)
    rebuilt = (
        model.generate(model.content(z1), styles[0].sample(draws.styles[0]), label),
        model.generate(content, styles[1].sample(draws.styles[1]), label),
    )
    lost = model.config.kept * (z2 - rebuilt[1]).detach()
    transferred = model.generate(content.detach(), styles[2].sample(draws.styles[2]), other) + lost
    again = model.style_of(transferred, other)
    own = Gaussian(styles[1].mean.detach(), styles[1].logvar.detach())
    cycled = (
        model.generate(model.content(transferred), own.sample(draws.styles[3]), label),
        model.generate(swapped(content).detach(), again.sample(draws.styles[4]), other),
    )
    return Pass((z1, z2, z3), rebuilt, transferred, cycled, (*styles, again))


def stylization(model: Stylizer, first: Tensor, second: Tensor, label: Tensor | None, draws: Draws) -> Terms:
    """Every term of the style model, already weighted."""
    config: StylizationConfig = model.config
    made = run(model, first, second, label, draws)
    z1, z2, z3 = made.codes
    third = swapped(second)

    def apart(code: Tensor, target: Tensor, motion: Tensor) -> Tensor:
        """Eqs. 5.1 and 5.3: in latent and in motion space."""
        return smooth_l1_loss(code, target) + smooth_l1_loss(model.decode(code), motion)

    one, two, _, again = made.styles
    terms = {
        "reconstruction": apart(made.rebuilt[0], z1, first) + apart(made.rebuilt[1], z2, second),
        "cycle": config.cycle_weight * (apart(made.cycled[0], z2, second) + apart(made.cycled[1], z3, third)),
        "style_kl": config.kl_weight * sum((to_normal(g) for g in (one, two, again)), start=z1.new_zeros(())),
        "homo_style": config.hsa_weight * between(one, two),
    }
    if model.critic is not None and label is not None:
        terms |= criticised(model, made, label)
    return terms


def criticised(model: Stylizer, made: Pass, label: Tensor) -> Terms:
    """What the critic learns from real codes, and what it says, as it is, of transferred ones.

    Of those it sees what is left once they were decoded: no code that means nothing persuades it.
    """
    critic = model.critic
    assert critic is not None
    z1, z2, _ = made.codes
    given = torch.cat([label, label]).argmax(dim=1)
    fixed = {name: value.detach() for name, value in critic.named_parameters()}
    said = functional_call(critic, fixed, (model.encode(model.decode(made.transferred)),))
    return {
        "critic": cross_entropy(critic(torch.cat([z1, z2])), given),
        "manner": model.config.critic_weight * cross_entropy(said, swapped(label).argmax(dim=1)),
    }


def to_normal(found: Gaussian) -> Tensor:
    """KL from the standard normal, mean over elements, nats (eq. 5.4)."""
    return -0.5 * (1 + found.logvar - found.mean.square() - found.logvar.exp()).mean()


def between(one: Gaussian, two: Gaussian) -> Tensor:
    """KL(one || two), mean over elements, nats (eq. 5.2)."""
    gap = two.logvar - one.logvar + (one.logvar.exp() + (one.mean - two.mean).square()) * (-two.logvar).exp() - 1
    return 0.5 * gap.mean()
