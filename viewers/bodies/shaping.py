"""Shapes of bodies: sliders with names and bounds, and bodies made by moving them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.geometry.skins import vertex_normals
from engines.skeletons.skeleton import Skeleton
from viewers.bodies.body import Body, Slider


@dataclass(frozen=True, eq=False)
class Blend:
    """What moves when a slider goes from its usual value towards one end."""

    slider: str
    """Name of the slider."""
    end: float
    """The value at which all of it is applied; between, in proportion; beyond, more than all."""
    vertices: np.ndarray
    """(V, 3) metres each vertex moves."""
    offsets: np.ndarray
    """(J, 3) metres each joint's offset from its parent changes."""


class BlendShapes:
    """Reshapes a body by adding up blends, as SMPL and MakeHuman do.

    Args:
        base: the body with all sliders at their usual values.
        sliders: what can be moved.
        blends: one or two (either way) for each slider.
    """

    def __init__(self, base: Body, sliders: Sequence[Slider], blends: Sequence[Blend]) -> None:
        self._sliders = {slider.name: slider for slider in sliders}
        self._blends = tuple(blends)
        # vertices at one place, split where colours meet, must keep one normal
        places = np.round(base.vertices, 5)
        self._groups = np.unique(places, axis=0, return_inverse=True)[1].ravel()
        self.base = replace(base, sliders=tuple(sliders), reshape=self)
        self._normals = self._of_faces(base.vertices)

    def __call__(self, values: Mapping[str, float]) -> Body:
        """The body with sliders at `values`; those not named are at their usual values."""
        base = self.base
        vertices, offsets = base.vertices.astype(np.float64), np.array(base.skeleton.offsets)
        for blend in self._blends:
            usual = self._sliders[blend.slider].usual
            share = max((values.get(blend.slider, usual) - usual) / (blend.end - usual), 0.0)
            if share:
                vertices += share * blend.vertices
                offsets += share * blend.offsets
        if np.array_equal(offsets, base.skeleton.offsets) and np.array_equal(vertices, base.vertices):
            return base
        skeleton: Skeleton = base.skeleton.replaced(offsets=offsets)
        # the body's own normals know where it has edges (a hem), those of its faces only how they turn
        normals = _turned(base.normals, self._normals, self._of_faces(vertices))
        return replace(base, vertices=vertices, normals=normals, skeleton=skeleton, own_bones=True)

    def _of_faces(self, vertices: np.ndarray) -> np.ndarray:
        """(V, 3) normals by the faces around, zero where there are none but coarse ones."""
        return vertex_normals(vertices, self.base.faces, self._groups)


def _turned(vectors: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """(V, 3) vectors, each turned as a unit vector `before` turns the shortest way into `after`; float32."""
    axis = np.cross(before, after)
    once = np.cross(axis, vectors)
    turned = vectors + once + np.cross(axis, once) / (1.0 + np.sum(before * after, axis=1, keepdims=True)).clip(1e-6)
    return (turned / np.linalg.norm(turned, axis=1, keepdims=True).clip(1e-9)).astype(np.float32)


def checked(body: Body, values: Mapping[str, float]) -> dict[str, float]:
    """Values of a body's sliders, once they are known to be some.

    Raises:
        UnknownLabelError: a slider the body does not have.
        OutOfRangeError: a value out of its bounds.
    """
    known = {slider.name: slider for slider in body.sliders}
    for name, value in values.items():
        if name not in known:
            raise UnknownLabelError(f"shape of body {body.name!r}", name, known or ("none: it has one shape only",))
        low, high = known[name].low, known[name].high
        if not low <= value <= high:
            raise OutOfRangeError(name, value, f"{low:g} to {high:g} (usually {known[name].usual:g})")
    return {name: float(value) for name, value in values.items()}
