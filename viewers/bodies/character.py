"""People's own characters as bodies, and where they are kept: a folder of files in the user's data folder.

Each is known as "character:NAME", in the app as on the command line; the path of a character's file does as well.
"""

from __future__ import annotations

import os
import re
import zipfile
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import platformdirs
from PIL import Image

from engines.errors import FormatError, OutOfRangeError, UnknownLabelError
from viewers.bodies.body import LARGEST_TEXTURE, Body
from viewers.bodies.coarse import coarser, rims

if TYPE_CHECKING:
    from engines.character.character import Character
    from engines.character.mesh import Surface

PREFIX = "character:"
"""Of the names by which `bodies.get` knows characters."""
ENDING = ".npz"
GREY = (178, 178, 184)
"""sRGB of a surface that nobody has painted."""
FEW_FACES = 12_000
"""What is drawn as it is, however small; of more there is a coarser level."""
NAMES = re.compile(r"\w[\w \-]{0,59}")


def folder() -> Path:
    """Where characters are kept unless told: $MOTIONLOOM_CHARACTERS, or a folder among the user's data."""
    told = os.environ.get("MOTIONLOOM_CHARACTERS")
    return Path(told or Path(platformdirs.user_data_dir("motionloom", appauthor=False)) / "characters")


def saved() -> tuple[str, ...]:
    """Names of the characters that are kept, as `bodies.get` knows them."""
    there = folder()
    found = sorted(there.glob(f"*{ENDING}")) if there.is_dir() else ()
    return tuple(PREFIX + path.stem for path in found if NAMES.fullmatch(path.stem))


def file_of(name: str) -> Path:
    """The file of a character, by its name with or without the prefix; it need not be there.

    Raises:
        OutOfRangeError: a name that no file can have.
    """
    bare = name.removeprefix(PREFIX).strip()
    if not NAMES.fullmatch(bare):
        raise OutOfRangeError("name of the character", bare, "up to 60 letters, digits, spaces, - and _")
    return folder() / f"{bare}{ENDING}"


def save(character: Character, name: str) -> str:
    """Keep a character under a name, in place of any that had it.

    Returns:
        What `bodies.get` knows it by.

    Raises:
        OutOfRangeError: a name that no file can have.
        FormatError: it cannot be written there.
    """
    path = file_of(name)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise FormatError(path.parent, f"cannot be made: {problem.strerror}.") from problem
    replace(character, name=path.stem).save(path)
    return PREFIX + path.stem


def get(name: str) -> Body:
    """A character that is kept ("character:NAME"), or that of a file, as a body.

    Raises:
        UnknownLabelError: none of that name is kept; the nearest are listed.
        FormatError: none is kept at all, or the file is missing, damaged or no character.
    """
    path = Path(name)
    if name.startswith(PREFIX):
        path = file_of(name)
        if not path.is_file() and not saved():
            raise FormatError(path, "there is no such character; `motionloom character PICTURE --save NAME` keeps one.")
        if not path.is_file():
            raise UnknownLabelError("character", name, saved())
    return _read(path.resolve(), path.stat().st_mtime_ns if path.exists() else 0)


def is_one(path: Path) -> bool:
    """Is this the file of a character?"""
    from engines.character.character import HEADER

    try:
        with zipfile.ZipFile(path) as archive:
            return f"{HEADER}.npy" in archive.namelist()
    except (OSError, zipfile.BadZipFile, ValueError):
        return False


@lru_cache(maxsize=8)
def _read(path: Path, changed: int) -> Body:
    from engines.character import character

    del changed  # part of the key: a file that was replaced is read again
    return body_of(character.load(path))


def body_of(character: Character) -> Body:
    """A character as every viewer wants it; it keeps its own bones, and takes no actor's colour."""
    surface = character.surface
    count = len(surface.vertices)
    coloured = surface.coloured()
    colours = np.tile(np.array(GREY, np.uint8), (count, 1)) if coloured.colours is None else coloured.colours
    lone = np.where(surface.normals.any(axis=1, keepdims=True), surface.normals, [0.0, 1.0, 0.0])
    return Body(
        name=PREFIX + character.name,
        skeleton=character.skeleton,
        vertices=surface.vertices.astype(np.float32),
        faces=surface.faces.astype(np.uint32),
        normals=lone.astype(np.float32),
        skin_indices=character.skin_indices,
        skin_weights=character.skin_weights,
        colours=colours,
        tint=np.zeros(count, np.float32),
        licence=f"{character.name}: your own character. What may be done with pictures and exports of it is up to whom "
        "the picture or mesh belongs to that it was made of.",
        uv=None if surface.uv is None else np.clip(surface.uv, 0, 1),
        texture=_small(surface.texture),
        own_bones=True,
        coarse=_coarse(surface),
    )


def _coarse(surface: Surface) -> tuple[np.ndarray, ...]:
    """Fewer faces for figures that are small or have to be drawn fast, the texture's seams as they were."""
    if len(surface.faces) <= FEW_FACES:
        return ()
    kept = rims(surface.faces, surface.groups)
    return (coarser(surface.vertices, surface.faces, kept, max(len(surface.faces) // 3, FEW_FACES)),)


def _small(texture: np.ndarray | None) -> np.ndarray | None:
    """A texture of a size that all viewers take."""
    if texture is None or max(texture.shape) <= LARGEST_TEXTURE:
        return texture
    image = Image.fromarray(texture)
    image.thumbnail((LARGEST_TEXTURE, LARGEST_TEXTURE), Image.Resampling.LANCZOS)
    return np.array(image)
