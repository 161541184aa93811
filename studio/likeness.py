"""Whom a file shows, and the character made of it: one chain for the app and the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from engines.character import meshes, rigged
from engines.character.meshes import MeshFile
from engines.character.picture import open_picture
from engines.character.rigged import Rigged
from engines.character.sighting import Sighting, look
from engines.formats.files import read_bytes

if TYPE_CHECKING:
    from engines.character.character import Character
    from engines.character.making import Cancel, Progress
    from engines.character.template import Template

PICTURES = (".jpg", ".jpeg", ".png", ".webp")
MESHES = (*meshes.KINDS, ".zip")
Likeness = Sighting | MeshFile | Rigged


def find(source: Path | bytes, name: str, height: float | None = None) -> Likeness:
    """Whom a file shows: somebody in a picture, a mesh, or a body that was rigged elsewhere.

    Args:
        source: the file, or its bytes.
        name: of the file; its ending tells a mesh from a picture.
        height: of the person, metres, where it is known; a mesh is brought to it.

    Raises:
        MotionloomError: it cannot be used; why, and what would be accepted.
    """
    kind = Path(name).suffix.lower()
    if kind not in MESHES:
        return look(open_picture(source, name))
    data = source if isinstance(source, bytes) else read_bytes(source, meshes.MAX_BYTES)
    if kind == ".glb" and rigged.is_rigged(data):
        return rigged.read_rigged(data, name)
    return meshes.read_mesh(source, name, height)


def make(  # noqa: PLR0913 - three may be left out
    found: Likeness,
    template: Template,
    file: str,
    *,
    name: str | None = None,
    height: float | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Character:
    """The character of whom a file shows.

    Args:
        found: as `find` gives it, corrected by hand or not.
        template: the body that is fitted.
        file: name of the file, for the character's provenance.
        name: of the character; the file's without its ending if left out.
        height: of the person in a picture, metres, where it is known.
        progress: told how much is done, 0 to 1, and what is done next.
        cancel: asked before every step whether to stop.

    Raises:
        MotionloomError: nobody can be made of it; why.
        Cancelled: `cancel` said so.
    """
    from engines.character import making  # brings torch

    name = name or Path(file).stem
    if isinstance(found, Sighting):
        return making.build(found, template, name=name, height=height, progress=progress, cancel=cancel)
    if isinstance(found, Rigged):
        return making.from_rigged(found, name, provenance={"file": file})
    about = {"file": file, "remarks": list(found.remarks)}
    return making.from_mesh(found.surface, template, name, provenance=about, progress=progress, cancel=cancel)
