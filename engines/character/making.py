"""A character from what a person has: a picture, what was seen in one and corrected, a mesh, or a rigged file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import PurePath
from typing import Any

import numpy as np

from engines.character.atlas import baked
from engines.character.character import Character
from engines.character.fitting import Fit, fit, fit_to_surface
from engines.character.mesh import EASY_FACES, Surface, cleaned, simplified
from engines.character.picture import Picture
from engines.character.rig import rigged
from engines.character.rigged import Rigged
from engines.character.sighting import Sighting, look
from engines.character.surface import clothed
from engines.character.template import Template
from engines.character.texture import Front, painted
from engines.errors import Cancelled

Progress = Callable[[float, str], object]
"""Told how much is done, 0 to 1, and what is done next, in words for the person who waits."""
Cancel = Callable[[], bool]
"""Asked before every step whether to stop."""


def build(  # noqa: PLR0913 - four may be left out
    source: Picture | Sighting,
    template: Template,
    *,
    name: str | None = None,
    height: float | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Character:
    """A textured character from one picture of a standing person (thesis, section 3.2.2).

    Args:
        source: the picture, or what was seen in it, corrected by hand or not.
        template: the body that is fitted, `viewers.bodies.get("anny")` for one.
        name: of the character; the picture's file name if left out.
        height: of the person, metres, where it is known.
        progress: see `Progress`.
        cancel: see `Cancel`.

    Raises:
        FormatError: the picture does not show one whole person.
        OutOfRangeError: a height no person has, or an empty mask.
        MissingDependencyError: the networks that look at pictures are not installed.
        Cancelled: `cancel` said so.
    """
    step = _Steps(progress, cancel)
    if isinstance(source, Picture):
        step(0.0, "Looking for the person")
        source = look(source)
    step(0.15, "Fitting a body")
    found = fit(source, template, height=height)
    step(0.55, "Dressing it to the outline")
    surface = clothed(found, source)
    step(0.65, "Colouring what the picture does not show")
    front = Front.of(surface, source.picture, source.mask, found.view)
    surface = painted(surface, front, face=facing(found))
    step(0.75, "Drawing the texture")
    surface = baked(surface, front)
    step(0.85, "Rigging")
    width, tall = source.picture.size
    about = {"picture": source.picture.name, "pixels": [width, tall], "remarks": list(source.remarks)}
    made = rigged(surface, found, name or PurePath(source.picture.name).stem, about | _report(found))
    step(1.0, "Done")
    return made


def from_mesh(  # noqa: PLR0913 - three may be left out
    surface: Surface,
    template: Template,
    name: str,
    *,
    provenance: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Character:
    """A character from a mesh of another tool, which takes the place of the surface a picture gives.

    Args:
        surface: someone upright in an A- or T-pose, facing +Z, in metres on the floor (`meshes.read_mesh`). Its texture
            stays; more than `EASY_FACES` faces are simplified, and keep the texture's colours at their vertices.
        template: the body that is fitted.
        name: of the character.
        provenance: what is known of where the mesh comes from.
        progress: see `Progress`.
        cancel: see `Cancel`.

    Raises:
        MeshError: nothing is left of it once it is cleaned.
        MissingDependencyError: simplifying needs the extra `character`.
        Cancelled: `cancel` said so.
    """
    step = _Steps(progress, cancel)
    step(0.0, "Cleaning the mesh")
    about: dict[str, Any] = {"faces": len(surface.faces), "open_edges": surface.open_edges, **(provenance or {})}
    if surface.texture is None or len(surface.faces) > EASY_FACES:
        surface = simplified(cleaned(surface))
    step(0.15, "Fitting a body")
    found = fit_to_surface(surface, template)
    step(0.85, "Rigging")
    made = rigged(surface, found, name, about | _report(found))
    step(1.0, "Done")
    return made


def from_rigged(source: Rigged, name: str, *, provenance: Mapping[str, Any] | None = None) -> Character:
    """A character that was rigged elsewhere; it keeps its skeleton and weights, and motions are retargeted to it.

    Args:
        source: as `rigged.read_rigged` gives it.
        name: of the character.
        provenance: what is known of where the file comes from.
    """
    return Character(
        name=name,
        surface=source.surface,
        skin_indices=source.skin_indices.astype(np.uint16),
        skin_weights=source.skin_weights.astype(np.float32),
        hold=np.ones(len(source.surface.vertices), np.float32),
        skeleton=source.skeleton,
        provenance={"remarks": list(source.remarks), **(provenance or {})},
    )


def facing(found: Fit) -> tuple[float, float, float]:
    """(3,) where the head of a fitted body faces."""
    x, y, z = found.turns[found.template.skeleton.index("head")][:, 2]
    return float(x), float(y), float(z)


def _report(found: Fit) -> dict[str, Any]:
    """What is written down of a fit."""
    return {"fit": {term: float(value) for term, value in found.report.items()}}


class _Steps:
    """Says what comes next, unless it is to stop."""

    def __init__(self, progress: Progress | None, cancel: Cancel | None) -> None:
        self.progress, self.cancel = progress, cancel

    def __call__(self, share: float, words: str) -> None:
        if self.cancel and self.cancel():
            raise Cancelled("making the character was cancelled.")
        if self.progress:
            self.progress(share, words)
