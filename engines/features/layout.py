"""How a feature vector is made up: ordered named parts, from which slices, sizes and statistics follow.

Nothing else in the project types an index into a feature vector: a representation declares its parts once, and
everything is reached through their names.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engines.errors import OutOfRangeError, UnknownLabelError

EMPHASIS = 5.0
"""How much more root and contact features count than the rest (TM2T, section 3.1 of the paper: "by a value of 5")."""
_CONSTANT = 1e-6
"""A standard deviation below this is that of a part that never changes; it is centred and not scaled."""


@dataclass(frozen=True)
class Part:
    """One part of a feature vector."""

    name: str
    """What it holds, e.g. "root_height"."""
    shape: tuple[int, ...]
    """Its shape in one frame, e.g. (21, 3) for the positions of 21 joints."""
    emphasis: float = 1.0
    """How many times as much it weighs once normalised: its standard deviation is divided by this."""

    @property
    def size(self) -> int:
        """How many numbers of the vector it takes."""
        return math.prod(self.shape)


@dataclass(frozen=True)
class Layout:
    """Ordered named parts of a feature vector (..., size)."""

    parts: tuple[Part, ...]

    @cached_property
    def size(self) -> int:
        """How many numbers one frame has."""
        return sum(part.size for part in self.parts)

    @cached_property
    def slices(self) -> Mapping[str, slice]:
        """Where each part lies, in order."""
        ends = np.cumsum([part.size for part in self.parts]).tolist()
        return {part.name: slice(end - part.size, end) for part, end in zip(self.parts, ends, strict=True)}

    @property
    def names(self) -> tuple[str, ...]:
        """The parts' names, in order."""
        return tuple(part.name for part in self.parts)

    def __iter__(self) -> Iterator[Part]:
        return iter(self.parts)

    def __getitem__(self, name: str) -> slice:
        """Where a part lies, `features[..., layout["contacts"]]`.

        Raises:
            UnknownLabelError: there is no such part; those there are, are listed.
        """
        try:
            return self.slices[name]
        except KeyError:
            raise UnknownLabelError("part", name, self.slices) from None

    def part(self, name: str) -> Part:
        """The part of that name.

        Raises:
            UnknownLabelError: there is none.
        """
        if name not in self.slices:
            raise UnknownLabelError("part", name, self.slices)
        return next(part for part in self.parts if part.name == name)

    def read(self, features, name: str):
        """A part of (..., size) NumPy features or torch tensor as a view (..., *shape)."""
        held = features[..., self[name]]
        return held.reshape(*held.shape[:-1], *self.part(name).shape)

    def split(self, features) -> dict:
        """All parts by name, each a view (..., *shape) into the features (..., size)."""
        return {name: self.read(features, name) for name in self.names}

    def join(self, **parts: np.ndarray) -> np.ndarray:
        """Features (..., size) float32 from all parts (..., *shape) by name.

        Raises:
            UnknownLabelError: a name that is no part.
            OutOfRangeError: a part is missing, or has another shape.
        """
        for name in parts:
            self.part(name)
        if missing := [name for name in self.names if name not in parts]:
            raise OutOfRangeError("parts of the features", sorted(parts), f"all of them; missing: {', '.join(missing)}")
        first = self.parts[0]
        lead = np.shape(parts[first.name])[: np.ndim(parts[first.name]) - len(first.shape)]
        features = np.empty((*lead, self.size), dtype=np.float32)
        for part in self.parts:
            if np.shape(parts[part.name]) != (*lead, *part.shape):
                raise OutOfRangeError(
                    f"shape of {part.name!r}", np.shape(parts[part.name]), f"{(*lead, *part.shape)}, as the other parts"
                )
            self.read(features, part.name)[...] = parts[part.name]
        return features

    def without(self, *names: str) -> Layout:
        """The same layout lacking some parts (the papers' encoders are not shown the contacts).

        Raises:
            UnknownLabelError: a name that is no part.
        """
        for name in names:
            self.part(name)
        return Layout(tuple(part for part in self.parts if part.name not in names))

    def check(self, features: np.ndarray) -> np.ndarray:
        """The features as float32, if they are (..., T, size), T >= 1, and finite.

        Raises:
            OutOfRangeError: another shape, or values that are not finite numbers.
        """
        features = np.asarray(features)
        if features.ndim < 2 or features.shape[-1] != self.size or features.shape[-2] == 0:
            raise OutOfRangeError(
                "shape of the features", features.shape, f"(..., frames, {self.size}), 1 frame or more"
            )
        features = features.astype(np.float32, copy=False)
        if not np.isfinite(features).all():
            raise OutOfRangeError("features", "partly NaN or infinite", "finite numbers")
        return features


@dataclass(frozen=True, eq=False)
class Statistics:
    """Mean and standard deviation of every feature, by which networks see them as numbers around zero and one.

    The deviation is averaged inside each part, so that the joints keep their proportions; root and contact parts are
    made to weigh `Part.emphasis` times as much by dividing theirs (`emphasised`).
    """

    mean: np.ndarray
    """(size,) float32."""
    std: np.ndarray
    """(size,) float32, positive."""

    def __post_init__(self) -> None:
        for name in ("mean", "std"):
            held = np.array(getattr(self, name), dtype=np.float32)
            if held.ndim != 1 or not np.isfinite(held).all():
                raise OutOfRangeError(f"{name} of the features", held.shape, "finite numbers in one row")
            held.setflags(write=False)
            object.__setattr__(self, name, held)
        if self.mean.shape != self.std.shape or not (self.std > 0).all():
            raise OutOfRangeError("std of the features", self.std.shape, f"{self.mean.shape}, all of it positive")

    @classmethod
    def measure(cls, clips: Iterable[np.ndarray], layout: Layout) -> Statistics:
        """Over all frames of all clips (..., T, size), one clip at a time, in double precision.

        Raises:
            OutOfRangeError: no frame at all, or a clip of another width or not finite.
        """
        count, mean, spread = 0, np.zeros(layout.size), np.zeros(layout.size)
        for clip in clips:
            rows = layout.check(clip).reshape(-1, layout.size).astype(np.float64)
            added, centre = len(rows), rows.mean(axis=0)
            shift = centre - mean
            # two sets of rows become one (Chan et al. 1983), which keeps the digits that sums of squares lose
            spread += ((rows - centre) ** 2).sum(axis=0) + shift**2 * (count * added / (count + added))
            mean += shift * (added / (count + added))
            count += added
        if count == 0:
            raise OutOfRangeError("number of clips to measure", 0, "1 or more")
        std = np.sqrt(spread / count)
        for part in layout:
            average = float(std[layout[part.name]].mean())
            std[layout[part.name]] = average if average > _CONSTANT else 1.0
        return cls(mean, std)

    def emphasised(self, layout: Layout) -> Statistics:
        """The same with each part's deviation divided by its emphasis, which makes it count that much more."""
        std = np.array(self.std)
        for part in layout:
            std[layout[part.name]] /= part.emphasis
        return Statistics(self.mean, std)

    def chosen(self, layout: Layout, kept: Layout) -> Statistics:
        """Of the parts of another, smaller layout only."""
        rows = np.concatenate([np.arange(layout.size)[layout[name]] for name in kept.names])
        return Statistics(self.mean[rows], self.std[rows])

    def normalise(self, features: np.ndarray) -> np.ndarray:
        """Features (..., size) -> numbers around zero, float32."""
        return ((np.asarray(features) - self.mean) / self.std).astype(np.float32, copy=False)

    def denormalise(self, values: np.ndarray) -> np.ndarray:
        """The way back from `normalise`, (..., size) float32."""
        return (np.asarray(values) * self.std + self.mean).astype(np.float32, copy=False)
