"""Text2Motion: autoencoder of snippets, text2length, and the temporal VAE of text2motion, those that are there.

Guo et al. 2022, section 3; thesis 4.2. One code after another: words are attended to with the generator's memory, prior
and posterior say what the latent may be, the generator tells the code. Letters as in `networks`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from engines.features.humanml3d import HUMANML3D
from engines.text.tags import SIDES, TAGS
from engines.text2motion.config import Text2MotionConfig
from engines.text2motion.networks import (
    UNIT,
    Gaussian,
    Generator,
    Held,
    LatentNet,
    LengthEstimator,
    Read,
    SnippetDecoder,
    SnippetEncoder,
    WordAttention,
    WordReader,
    time_to_arrival,
)
from engines.text2motion.words import WordBatch

LAYOUT = HUMANML3D.layout
HIDDEN_FEATURES = LAYOUT.part("contacts").size
"""At the end of the features; the encoder is not shown them, the decoder has to tell them."""


@dataclass(frozen=True)
class Sizes:
    """Of a temporal VAE."""

    word: int
    """E."""
    tags: int
    """K; 0: none."""
    text_hidden: int
    attention: int
    """A; 0: words are not attended to."""
    latent: int
    """Z."""
    latent_hidden: int
    motion_hidden: int
    code: int
    """C."""
    layers: int = 1
    position: bool = True
    """Time to arrival is told."""
    release: bool = False
    """As the released networks have it, see `official`."""


class Autoencoder(nn.Module):
    """Motions and snippet codes (equations 4.1, 4.2).

    Args:
        features: D.
        hidden_features: how many at the end of D the encoder is not shown.
        hidden: channels between convolutions, of encoder and decoder.
        code: C.
        dropout: in the encoder.
    """

    def __init__(
        self, features: int, hidden_features: int, hidden: tuple[int, int], code: int, dropout: float = 0.2
    ) -> None:
        super().__init__()
        self.shown = features - hidden_features
        self.encoder = SnippetEncoder(self.shown, hidden[0], code, dropout)
        self.decoder = SnippetDecoder(code, hidden[1], features)

    def encode(self, features: Float[Tensor, "B T D"], codes: Int[Tensor, " B"] | None = None) -> Tensor:
        """Snippet codes (B, T // 4, C) of normalised features; `codes` of each row are there, all if none."""
        return self.encoder(features[..., : self.shown], codes)

    def decode(self, codes: Float[Tensor, "B S C"], count: Int[Tensor, " B"] | None = None) -> Tensor:
        """Normalised features (B, 4 S, D), contacts among them."""
        return self.decoder(codes, count)


class TemporalVAE(nn.Module):
    """Text encoder, word attention, prior, posterior and generator."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.sizes = sizes
        words, seen, code = 2 * sizes.text_hidden, sizes.attention, sizes.code
        self.reader = WordReader(sizes.word, sizes.tags, sizes.text_hidden, sizes.release)
        self.attention = WordAttention(sizes.motion_hidden, words, seen) if seen else None
        latent = (sizes.latent_hidden, words, sizes.latent, sizes.layers, not sizes.release)
        self.prior = LatentNet(code + seen, *latent)
        self.posterior = LatentNet(2 * code + seen, *latent)
        self.generator = Generator(code + seen + sizes.latent, sizes.motion_hidden, words, code, sizes.layers)

    def steps(self, read: Read, lengths: Int[Tensor, " B"]) -> Steps:
        """To generate motions of so many codes of sentences, code after code."""
        held = None if self.attention is None else self.attention.hold(read)
        prior, posterior, generator = (net.begin(read.sentence) for net in (self.prior, self.posterior, self.generator))
        return Steps(self, held, lengths.to(read.sentence.device), prior, posterior, generator)


@dataclass
class Steps:
    """Where generation stands."""

    net: TemporalVAE
    held: Held | None
    lengths: Tensor
    """(B,) codes of each motion."""
    prior: list[Tensor]
    """(B, H), a layer each."""
    posterior: list[Tensor]
    generator: list[Tensor]
    done: int = 0
    """Codes so far."""
    weights: Tensor | None = None
    """(B, N) how much each word was attended to for the code at hand."""

    def look(self) -> tuple[Tensor, Tensor | None, Tensor | None]:
        """What of the words is seen for the code at hand (B, A), and its time to arrival for both sizes of memory."""
        net = self.net
        seen = self.generator[-1][:, :0]
        if net.attention is not None and self.held is not None:
            seen, self.weights = net.attention(self.generator[-1], self.held)
        if not net.sizes.position:
            return seen, None, None
        left = self.lengths - self.done
        # past its end a motion is nobody's; the release looks up its table from behind
        left = left.remainder(TABLE) if net.sizes.release else left.clamp_min(0)
        return seen, time_to_arrival(left, net.sizes.latent_hidden), time_to_arrival(left, net.sizes.motion_hidden)

    def step(self, last: Float[Tensor, "B C"], noise: Float[Tensor, "B Z"]) -> tuple[Tensor, Gaussian]:
        """The code after `last`, by a draw of the prior, and the prior itself."""
        seen, for_latent, for_motion = self.look()
        prior, self.prior = self.net.prior(torch.cat([last, seen], -1), for_latent, self.prior)
        return self._told(last, seen, prior.sample(noise), for_motion), prior

    def learn(
        self, last: Tensor, target: Float[Tensor, "B C"], noise: Float[Tensor, "B Z"], from_prior: bool = False
    ) -> tuple[Tensor, Gaussian, Gaussian]:
        """The code after `last`, by a draw of the posterior, which is shown it; posterior and prior.

        Args:
            last: the code before.
            target: the real one.
            noise: standard normal.
            from_prior: draw from the prior instead.
        """
        seen, for_latent, for_motion = self.look()
        prior, self.prior = self.net.prior(torch.cat([last, seen], -1), for_latent, self.prior)
        given = torch.cat([last, target, seen], -1)
        posterior, self.posterior = self.net.posterior(given, for_latent, self.posterior)
        latent = (prior if from_prior else posterior).sample(noise)
        return self._told(last, seen, latent, for_motion), posterior, prior

    def _told(self, last: Tensor, seen: Tensor, latent: Tensor, arrival: Tensor | None) -> Tensor:
        code, self.generator = self.net.generator(torch.cat([last, seen, latent], -1), arrival, self.generator)
        self.done += 1
        return code


TABLE = 300
"""Rows of the release's table of times to arrival."""


class Unrolled(NamedTuple):
    """What became of a batch of real codes."""

    codes: Float[Tensor, "B S C"]
    posterior: Gaussian
    """(B, S, Z) each."""
    prior: Gaussian
    weights: Float[Tensor, "B S N"] | None
    """What each step attended to."""


def unroll(  # noqa: PLR0913, PLR0917 - a batch, and how it is fed
    net: TemporalVAE, read: Read, real: Float[Tensor, "B S C"], lengths: Tensor, start: Float[Tensor, "B C"],
    noise: Float[Tensor, "B S Z"], teacher: Tensor, from_prior: bool = False,
) -> Unrolled:  # fmt: skip
    """Reconstruct codes, each step fed with the real code before it or with the network's own.

    Args:
        net: the VAE.
        read: sentences.
        real: codes.
        lengths: (B,) codes of the whole motions, of which S or fewer are here.
        start: what comes before the first code.
        noise: standard normal.
        teacher: (B,) which rows are fed with the real ones.
        from_prior: latents are drawn from the prior.
    """
    steps = net.steps(read, lengths)
    codes, posteriors, priors, weights, last = [], [], [], [], start
    for at in range(real.shape[1]):
        code, posterior, prior = steps.learn(last, real[:, at], noise[:, at], from_prior)
        codes.append(code)
        posteriors.append(posterior)
        priors.append(prior)
        weights += [] if steps.weights is None else [steps.weights]
        # what was wrong is mended where it was made, not in the steps before
        last = torch.where(teacher[:, None], real[:, at], code.detach())
    looked = torch.stack(weights, 1) if weights else None
    return Unrolled(torch.stack(codes, 1), _joined(posteriors), _joined(priors), looked)


def _joined(steps: list[Gaussian]) -> Gaussian:
    """(B, S, Z) of (B, Z) each."""
    return Gaussian(torch.stack([one.mean for one in steps], 1), torch.stack([one.logvar for one in steps], 1))


class Going(Protocol):
    """Goes on from one code to the next: `Steps`, or `packed.PackedSteps`, a faster way to the same."""

    weights: Tensor | None

    def step(self, last: Tensor, noise: Tensor) -> tuple[Tensor, Gaussian]:
        """As `Steps.step`."""
        ...


@torch.no_grad()
def generate(
    steps: Going, start: Float[Tensor, "B C"], noise: Float[Tensor, "B S Z"], heat: list[Tensor] | None = None
) -> Float[Tensor, "B S C"]:
    """Codes by draws of the prior; a row's codes past its length mean nothing.

    Args:
        steps: fresh.
        start: what comes before the first code.
        noise: standard normal.
        heat: gets what each step attended to (B, N).
    """
    made, last = [], start
    for at in range(noise.shape[1]):
        last, _ = steps.step(last, noise[:, at])
        made.append(last)
        if heat is not None and steps.weights is not None:
            heat.append(steps.weights)
    return torch.stack(made, 1)


class Text2Motion(nn.Module):
    """The networks that `config.parts` names, and the statistics of features.

    Args:
        config: see there.
    """

    mean: Tensor
    std: Tensor
    autoencoder: Autoencoder | None
    text2length: LengthEstimator | None
    text2motion: TemporalVAE | None

    def __init__(self, config: Text2MotionConfig) -> None:
        super().__init__()
        self.config = config
        self.trained = ""
        """The part that is trained now; the others evaluate, whatever mode the whole is in."""
        self.register_buffer("mean", torch.zeros(LAYOUT.size))
        self.register_buffer("std", torch.ones(LAYOUT.size))
        tags = len(TAGS) * config.length_tags
        hidden = (config.autoencoder_hidden, config.autoencoder_hidden)
        self.autoencoder = self.text2length = self.text2motion = None
        if "autoencoder" in config.parts and config.snippet_codes:
            self.autoencoder = Autoencoder(LAYOUT.size, HIDDEN_FEATURES, hidden, config.code_size, config.dropout)
        if "text2length" in config.parts:
            self.text2length = LengthEstimator(config.text_size, tags, config.length_hidden, config.classes)
        if "text2motion" in config.parts:
            self.text2motion = TemporalVAE(sizes_of(config))

    def train(self, mode: bool = True) -> Text2Motion:
        """As torch's, but for frozen parts."""
        super().train(mode)
        for name, part in self.named_children():
            if self.trained and name != self.trained:
                part.eval()
        return self

    def freeze_all_but(self, part: str) -> None:
        """Train one part; with text2motion the motion decoder is fine-tuned (thesis 4.2.3), else others learn not."""
        self.trained = part
        for name, child in self.named_children():
            child.requires_grad_(name == part)
        if part == "text2motion" and self.autoencoder is not None:
            self.autoencoder.decoder.requires_grad_(True)
        self.train(self.training)

    def read(self, words: WordBatch) -> Read:
        """Sentences as text2motion is told them."""
        assert self.text2motion is not None
        tags, sides = words.marks.split([len(TAGS), len(SIDES)], -1)
        told = [part for part, wanted in ((tags, self.config.tags), (sides, self.config.sides)) if wanted]
        marks = torch.cat(told, -1) if told else words.marks  # which are not looked at then
        return self.text2motion.reader(words.vectors, marks, words.lengths)

    def length_logits(self, words: WordBatch) -> Float[Tensor, "B L"]:
        """What text2length says of sentences: a logit for 4, 8, ... frames."""
        assert self.text2length is not None
        return self.text2length(words.vectors, words.marks[..., : len(TAGS)], words.lengths).float()

    def normalised(self, features: Tensor) -> Tensor:
        """Features (..., D) as the networks see them."""
        return (features - self.mean) / self.std

    def denormalised(self, values: Tensor) -> Tensor:
        """The way back."""
        return values * self.std + self.mean

    def encode(self, features: Float[Tensor, "B T D"], codes: Int[Tensor, " B"] | None = None) -> Tensor:
        """Codes (B, S, C) of normalised features; the features themselves where there are no snippet codes."""
        return features if self.autoencoder is None else self.autoencoder.encode(features, codes)

    def decode(self, codes: Float[Tensor, "B S C"], count: Int[Tensor, " B"] | None = None) -> Tensor:
        """Normalised features (B, T, D) of codes."""
        return codes if self.autoencoder is None else self.autoencoder.decode(codes, count)

    def start(self, count: int) -> Float[Tensor, "B C"]:
        """What comes before the first code: that of the mean pose."""
        still = self.mean.new_zeros(1, UNIT, LAYOUT.size)
        return self.encode(still)[:, 0].detach().expand(count, -1)


def sizes_of(config: Text2MotionConfig) -> Sizes:
    """Of the VAE of some settings."""
    return Sizes(
        word=config.text_size,
        tags=len(TAGS) * config.tags + len(SIDES) * config.sides,
        text_hidden=config.text_hidden,
        attention=config.attention_size if config.attention else 0,
        latent=config.latent_size,
        latent_hidden=config.latent_hidden,
        motion_hidden=config.motion_hidden,
        code=config.code_size if config.snippet_codes else LAYOUT.size,
        position=config.position,
    )
