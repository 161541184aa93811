"""The stylization engine: any motion, in another manner."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from scipy.ndimage import gaussian_filter1d
from torch import Tensor

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.features.style import STYLE
from engines.geometry.cleanup import travel_on_feet
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22
from engines.stylization import train
from engines.stylization.model import LAYOUT, Stylizer
from engines.stylization.tempo import at_pace, travels
from engines.weights_file import SHIPPED

SHORTEST = 8
"""Frames at 30 fps, a quarter of a second."""
_LEAST = 24
"""Frames that the networks are shown at least: they halve the rate up to four times, and look to either side."""
LONGEST = 18_000
MAX_COUNT = 256
STRONGEST = 1.5
_SMOOTH = 2.0
"""Frames over which what the style changes is smoothed (deviation of a Gaussian): decoders tremble, manners do not."""
_VARIANTS = ("ae", "vae", "ae-unsupervised", "vae-unsupervised")


class StylizationEngine:
    """Puts the style of a label, of a reference or of chance on a motion; `engines.load("stylization")` makes one."""

    name = "stylization"
    description = "Any motion in another manner: from a label, from a reference, or a surprise (Guo et al. 2024)."
    licence = "CC BY-NC 4.0 (trained on Bandai-Namco clips)"
    fps = STYLE.fps

    def __init__(self, model: Stylizer, weights_hash: str) -> None:
        self.model = model.eval().requires_grad_(False)
        self.config = model.config
        self.weights_hash = weights_hash
        self.variant = self.config.latent + ("" if self.config.supervised else "-unsupervised")
        self.variants = shipped_variants() or (self.variant,)
        self.styles: tuple[str, ...] = self.config.styles if self.config.supervised else ()
        told = {"styles"} if self.styles else set()
        timed = {"tempo"} if self.styles and self.config.pace else set()
        self.capabilities = frozenset({"stylise", "references", "variants"} | told | timed)

    def stylise(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        motion: Motion,
        style: str | None = None,
        *,
        like: Motion | None = None,
        strength: float = 1.0,
        tempo: bool = False,
        count: int = 1,
        seed: int = 0,
    ) -> list[Motion]:
        """The motion in another manner.

        Args:
            motion: any of 8 frames or more at 30 fps; retargeted to smpl22 where it is not.
            style: a name of `styles` (label-based); with `like`, the style that shows.
            like: a motion to take the manner from (motion-based). Without both it is drawn from the prior: a style
                code, and in the supervised setting a style.
            strength: 0 gives the motion back, 1 the style as it was learned, up to 1.5 more of it.
            tempo: whether it also becomes as fast as the style is, beside its own or a normal one.
            count: how many; they differ in the style code that is drawn.
            seed: of the draws; the same one gives the same motions.

        Returns:
            Motions at 30 fps, where the given one stood and, without `tempo`, as long as it.

        Raises:
            UnknownLabelError: a style that is not known, or any for weights that learned without labels.
            OutOfRangeError: a number is outside its range; the motion is too short or too long.
        """
        _check(strength, count, seed)
        house, features = self._seen(motion)
        names = self._names(style, like, count, seed)
        label = self._labels(names)
        draws = (torch.randn(self.config.style_size, generator=_generator(seed, index)) for index in range(count))
        told = torch.stack([*draws])
        if like is not None:
            reference = self.model.encode(self._normal(self._seen(like)[1])).expand(count, -1, -1)
            told = self.model.style_of(reference, label).sample(told)
        made = self._restyled(features, told, label, strength)
        said = {"style": style, "like": None if like is None else like.provenance.source, "strength": strength}
        done = [
            self._finished(house, row, name, said, seed, index)
            for index, (row, name) in enumerate(zip(made, names, strict=True))
        ]
        if not tempo:
            return done
        own = house.label_at(0, "style")
        return [
            at_pace(one, (self._pace(name, house) / self._pace(own, house)) ** strength)
            for one, name in zip(done, names, strict=True)
        ]

    def style_code(self, motion: Motion, style: str | None = None) -> np.ndarray:
        """(K,) where the manner of a motion lies in the style space, mean of its Gaussian."""
        code = self.model.encode(self._normal(self._seen(motion)[1]))
        label = self._labels(self._names(style, motion, 1, 0))
        return self.model.style_of(code, label).mean[0].numpy()

    def interpolate_styles(
        self, motion: Motion, a: np.ndarray, b: np.ndarray, steps: int = 5, style: Sequence[str] = ()
    ) -> list[Motion]:
        """The motion in manners between two style codes.

        Args:
            motion: as in `stylise`.
            a: (K,) style code of the first.
            b: (K,) of the last.
            steps: how many, both ends included; 2 to 64.
            style: none, one for all, or two to go between (supervised weights).
        """
        if not 2 <= steps <= 64:
            raise OutOfRangeError("steps", steps, "2 to 64")
        house, features = self._seen(motion)
        share = torch.linspace(0, 1, steps)[:, None]
        first, last = (torch.as_tensor(code, dtype=torch.float32) for code in (a, b))
        names = [*style] or [None]
        ends = self._labels([self._known(name) for name in (names[0], names[-1])])
        label = None if ends is None else (1 - share) * ends[:1] + share * ends[1:]
        made = self._restyled(features, (1 - share) * first + share * last, label, 1.0)
        return [self._finished(house, row, " > ".join(style) or None, {}, 0, i) for i, row in enumerate(made)]

    # ---- how it is made ---------------------------------------------------------------------------------------

    def _known(self, style: str | None) -> str | None:
        """The style itself, if it is one that was learned or none."""
        if style is not None and style not in self.styles:
            raise UnknownLabelError("style", style, self.styles or ("(none: these weights learned without labels)",))
        return style

    def _names(self, style: str | None, like: Motion | None, count: int, seed: int) -> list[str | None]:
        """The style of each of `count`: the one asked for, the reference's own, or one by chance."""
        if not self.styles:
            return [self._known(style) if like is None else None] * count
        if style is not None or like is not None:
            name = style or (like.label_at(0, "style") if like is not None else None)
            return [self._known(name)] * count
        draws = (torch.randint(len(self.styles), (), generator=_generator(seed, index)) for index in range(count))
        return [self.styles[int(draw)] for draw in draws]

    def _labels(self, names: Sequence[str | None]) -> Tensor | None:
        """(N, S) one-hot, a style that is not known spread over all; none in the unsupervised setting."""
        if not self.styles:
            return None
        rows = torch.eye(len(self.styles))
        return torch.stack([rows.mean(0) if name is None else rows[self.styles.index(name)] for name in names])

    def _pace(self, style: str | None, motion: Motion) -> float:
        """How fast a style is beside a neutral one, on the spot or on the way as the motion is."""
        known = style in self.styles and self.config.pace
        return self.config.pace[self.styles.index(str(style))][int(travels(motion))] if known else 1.0

    def _seen(self, motion: Motion) -> tuple[Motion, np.ndarray]:
        """The motion at 30 fps on smpl22, and its features (T, D)."""
        house = motion.retarget(SMPL22).resample(STYLE.fps)
        if not SHORTEST <= len(house) <= LONGEST:
            raise OutOfRangeError("frames of the motion at 30 fps", len(house), f"{SHORTEST} to {LONGEST:,}")
        return house, STYLE.encode(house)

    def _normal(self, features: np.ndarray) -> Tensor:
        """(1, T', D) normalised, the last frame held up to a multiple of 8 and what the networks need at least."""
        more = max(-len(features) % 8, _LEAST - len(features))
        rows = np.concatenate([features, np.repeat(features[-1:], more, axis=0)])
        return ((torch.from_numpy(rows) - self.model.mean) / self.model.std)[None]

    def _restyled(self, features: np.ndarray, told: Tensor, label: Tensor | None, strength: float) -> np.ndarray:
        """Features (N, T, D), not normalised: on the way from the given ones to those of the stylised code.

        Content codes lose more than the manner (instance norms take away that one arm hangs still). Of what they cannot
        say of the motion in its own manner the share `kept` stays in it; so does what the autoencoder cannot say of it,
        and the regressor of its travel: without strength nothing changes.
        """
        model, given = self.model, self._normal(features)
        code = model.encode(given)
        content = model.content(code)
        kept = self.config.kept
        own = kept * self._rebuilt(code, content) + (1 - kept) * code
        styled = code + strength * (model.generate(content.expand(len(told), -1, -1), told, label) - own)
        change = (model.decode(styled) - model.decode(code)).numpy()
        made = given + torch.from_numpy(gaussian_filter1d(change, _SMOOTH, axis=1, mode="nearest"))
        given = given.expand_as(made)
        turning = given[..., LAYOUT["yaw_velocity"]]
        travel = given[..., LAYOUT["root_velocity"]] + model.travel(made, given) - model.travel(given, given)
        rest = made[..., LAYOUT["root_height"].start :]
        whole = torch.cat([turning, travel, rest], dim=-1) * model.std + model.mean
        return whole[:, : len(features)].numpy()

    def _rebuilt(self, code: Tensor, content: Tensor) -> Tensor:
        """(1, Z, L): the code from its own content and manner; of labels the one that comes nearest."""
        labels = torch.eye(len(self.styles)) if self.styles else None
        many = max(1, len(self.styles))
        codes, contents = (value.expand(many, -1, -1) for value in (code, content))
        made = self.model.generate(contents, self.model.style_of(codes, labels).mean, labels)
        nearest = int((made - codes).abs().mean(dim=(1, 2)).argmin())
        return made[nearest : nearest + 1]

    def _finished(  # noqa: PLR0913, PLR0917 - what goes into labels and provenance
        self, house: Motion, row: np.ndarray, style: str | None, said: dict[str, Any], seed: int, index: int
    ) -> Motion:
        motion = STYLE.decode(row, source="rotations", start=STYLE.start(house))
        motion = travel_on_feet(motion, house)
        labels = [s for s in house.labels if s.kind != "style"]
        if style:
            labels.append(Segment(0, len(motion), "style", style))
        told = {key: value for key, value in said.items() if value is not None}
        origin = Provenance(self.name, self.weights_hash, house.provenance.prompt, seed, index, told)
        return motion.replaced(labels=tuple(labels), provenance=origin)


def load(variant: str = "ae", checkpoint: str | Path | None = None) -> StylizationEngine:
    """The engine with shipped weights, or with a checkpoint written by `motionloom train stylization`.

    Args:
        variant: ae, vae, ae-unsupervised or vae-unsupervised.
        checkpoint: weights (.safetensors with its .json beside it).

    Raises:
        UnknownLabelError: no such variant.
        CheckpointError: the file is missing, damaged or of another architecture.
    """
    if variant not in _VARIANTS:
        raise UnknownLabelError("variant of stylization", variant, _VARIANTS)
    path = Path(checkpoint) if checkpoint else SHIPPED / f"stylization-{variant}.safetensors"
    model = train.read(path)
    return StylizationEngine(model, hashlib.sha256(path.read_bytes()).hexdigest())


def shipped_variants() -> tuple[str, ...]:
    """Those whose weights are there."""
    return tuple(name for name in _VARIANTS if (SHIPPED / f"stylization-{name}.safetensors").is_file())


def _check(strength: float, count: int, seed: int) -> None:
    if not 0.0 <= strength <= STRONGEST:
        raise OutOfRangeError("strength", strength, f"0 to {STRONGEST:g}")
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAX_COUNT:
        raise OutOfRangeError("count", count, f"a whole number from 1 to {MAX_COUNT}")
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise OutOfRangeError("seed", seed, "a whole number from 0 to 2^63 - 1")


def _generator(seed: int, index: int) -> torch.Generator:
    return torch.Generator().manual_seed((seed * 1_000_003 + index) % 2**63)
