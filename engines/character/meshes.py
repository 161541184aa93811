"""Other people's meshes: OBJ, PLY and GLB, with their textures, read into a Surface that stands upright.

A file from elsewhere may claim anything: sizes are looked at before anything is unpacked, nothing outside the file's
own folder is opened, and nothing is fetched.
"""

from __future__ import annotations

import io
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from PIL import Image

from engines.character.mesh import LARGEST_TEXTURE, MAX_FACES, Surface
from engines.character.pieces import Piece, joined, standing
from engines.errors import FormatError, MeshError
from engines.formats.files import read_bytes
from engines.formats.gltf import Gltf

MAX_BYTES = 200 * 2**20
"""No larger mesh file, or file in an archive, is read."""
MAX_FILES = 500
"""No archive of more files is read."""
KINDS = (".obj", ".ply", ".glb")
BESIDE = (".mtl", ".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga", ".tif", ".tiff")
"""What a mesh may refer to."""


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as it was read."""

    surface: Surface
    """Metres, Y up, on the floor; it is taken to face +Z."""
    remarks: tuple[str, ...] = ()
    """What was guessed or left out, in sentences for the person whose file it is."""


def read_mesh(source: str | Path | bytes, name: str = "", height: float | None = None) -> MeshFile:
    """Read a mesh with its texture.

    Args:
        source: an .obj (with its .mtl and pictures in the same folder), .ply or .glb; a .zip with one of them and what
            belongs to it; or the bytes of such a file.
        name: of the file, if there are only bytes of it; its ending tells the kind.
        height: metres from the soles to the crown, where it is known; else it is told from the numbers.

    Raises:
        OutOfRangeError: a height that nobody has.
        FormatError: no such file, of another kind, too large, or damaged.
        MeshError: it holds no faces, too many, or places that are no numbers.
    """
    path = Path(name or "mesh") if isinstance(source, bytes) else Path(source)
    data = source if isinstance(source, bytes) else read_bytes(path, MAX_BYTES)
    if len(data) > MAX_BYTES:
        raise FormatError(path, f"has {len(data):,} bytes; accepted: at most {MAX_BYTES:,}.")
    find: Callable[[str], bytes | None] = (lambda _: None) if isinstance(source, bytes) else _folder(path.parent)
    kind = path.suffix.lower()
    if kind == ".zip":
        find, inner, data = _archive(path, data)
        kind = inner.suffix.lower()
    if kind not in KINDS:
        raise FormatError(path, f"meshes of this kind are not read; accepted: {', '.join(KINDS)}, or a .zip of one.")
    check_faces(path, kind, data)
    beside = _Beside(find)
    surface, remarks = standing(joined(_pieces(path, kind, data, beside)), kind == ".glb", height)
    lost = [f"What it refers to as {missing!r} was not found and is left out." for missing in beside.missing]
    return MeshFile(surface, (*remarks, *lost))


def check_faces(path: Path, kind: str, data: bytes) -> None:
    """Refuse a mesh that says it has more faces than are taken, before they are unpacked.

    Raises:
        MeshError: too many.
        FormatError: a .glb that is none.
    """
    claimed = _claimed_faces(path, kind, data)
    if claimed > MAX_FACES:
        raise MeshError(
            f"{path}: has {claimed:,} faces; accepted: at most {MAX_FACES:,}. Simplify it first: a body needs some "
            "twenty thousand."
        )


def _claimed_faces(path: Path, kind: str, data: bytes) -> int:
    if kind == ".obj":
        return data.count(b"\nf ") + data.count(b"\nf\t")
    if kind == ".ply":
        found = re.search(rb"element\s+face\s+(\d{1,15})", data[: 2**16])
        return int(found[1]) if found else 0
    gltf = Gltf(path, data)
    counts = [
        gltf.item("accessors", primitive["indices"]).get("count", 0)
        for mesh in gltf.items("meshes")
        for primitive in mesh.get("primitives", ())
        if "indices" in primitive
    ]
    return sum(count for count in counts if isinstance(count, int)) // 3


def _pieces(path: Path, kind: str, data: bytes, beside: _Beside) -> Iterator[Piece]:
    """The meshes of a file, where the file places them."""
    import trimesh

    try:
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=kind[1:], resolver=beside, allow_remote=False, process=False
        )
        meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    except Exception as problem:  # it raises whatever comes up: ValueError, KeyError, IndexError, struct.error, ...
        raise FormatError(path, f"is no readable {kind} file ({type(problem).__name__}: {problem}).") from problem
    for mesh in meshes:
        yield Piece(
            np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64), **_painting(path, mesh.visual)
        )


def _painting(path: Path, visual: Any) -> dict[str, Any]:
    """What a mesh is painted with, as `Piece` has it."""
    material = getattr(visual, "material", None)
    if material is None:
        if visual.kind not in ("vertex", "face"):
            return {}
        return {"colours": np.asarray(visual.vertex_colors)[:, :3].astype(np.uint8)}
    image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    if image is not None and visual.uv is not None and len(visual.uv):
        return {"picture": pixels(path, image), "uv": np.asarray(visual.uv)[:, :2] * [1, -1] + [0, 1]}
    colour = np.asarray(material.main_color)[:3]
    return {"colour": tuple(int(value) for value in colour)}


def pixels(path: Path, image: Image.Image) -> np.ndarray:
    """(h, w, 3) uint8 sRGB of a texture; what shines through is drawn as if it did not.

    Raises:
        FormatError: too large, or damaged.
    """
    if max(image.size) > LARGEST_TEXTURE:
        size = " x ".join(map(str, image.size))
        raise FormatError(path, f"has a texture of {size} pixels; accepted: at most {LARGEST_TEXTURE} a side.")
    try:
        return np.array(image.convert("RGB"))
    except (OSError, ValueError, SyntaxError, EOFError) as problem:
        raise FormatError(path, f"has a texture that cannot be read ({problem}).") from problem


# ---- what belongs to a mesh ---------------------------------------------------------------------------------


class _Beside(Mapping[str, bytes]):
    """Files that a mesh refers to, by the names it uses; those that are not there are remembered.

    Args:
        find: gives the bytes of a file by its place ("textures/skin.png", never one that leads elsewhere), or None.
    """

    def __init__(self, find: Callable[[str], bytes | None]) -> None:
        self._find = find
        self.missing: list[str] = []

    def __getitem__(self, name: str) -> bytes:
        parts = [part for part in PurePosixPath(name.replace("\\", "/")).parts if part not in ("/", "..")]
        if parts and PurePosixPath(parts[-1]).suffix.lower() in BESIDE:
            for place in ("/".join(parts), parts[-1]):
                found = self._find(place)
                if found is not None:
                    return found
        self.missing.append(name[:200])
        raise FileNotFoundError(name)

    def get(self, name: str, default: Any = None) -> bytes:
        """The file; nothing takes its place, which a reader would take for the file."""
        return self[name]

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0


def _folder(folder: Path) -> Callable[[str], bytes | None]:
    """Finds files in a folder and below; capitals do not matter, links that lead out of it are not followed."""

    def find(place: str) -> bytes | None:
        path = folder / place
        if not path.is_file() and path.parent.is_dir():
            alike = (
                other for other in islice(path.parent.iterdir(), MAX_FILES) if other.name.lower() == path.name.lower()
            )
            path = next(alike, path)
        if not path.is_file() or not path.resolve().is_relative_to(folder.resolve()):
            return None
        return read_bytes(path, MAX_BYTES)

    return find


def _archive(path: Path, data: bytes) -> tuple[Callable[[str], bytes | None], Path, bytes]:
    """Finds files in an archive; with it the name of the mesh in the archive, and that mesh's bytes.

    Raises:
        FormatError: damaged, locked, too large when unpacked, or without a mesh.
    """
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as problem:
        raise FormatError(path, f"is no readable .zip ({problem}).") from problem
    held = {info.filename.lower(): info for info in archive.infolist()}
    if len(held) > MAX_FILES:
        raise FormatError(path, f"holds {len(held):,} files; accepted: at most {MAX_FILES}.")
    mesh = next((info for kind in KINDS for name, info in held.items() if name.endswith(kind)), None)
    if mesh is None:
        raise FormatError(path, f"holds no mesh; accepted: a .zip with one of {', '.join(KINDS)}.")
    above = PurePosixPath(mesh.filename.lower()).parent

    def read(info: zipfile.ZipInfo) -> bytes:
        if info.file_size > MAX_BYTES:
            raise FormatError(path, f"{info.filename} has {info.file_size:,} bytes; accepted: at most {MAX_BYTES:,}.")
        try:
            with archive.open(info) as file:
                return file.read(info.file_size)  # what a file says of itself is all that is unpacked
        except (OSError, RuntimeError, zipfile.BadZipFile, zlib.error, NotImplementedError, EOFError) as problem:
            raise FormatError(path, f"{info.filename} cannot be unpacked ({problem}).") from problem

    def find(place: str) -> bytes | None:
        info = held.get((above / place.lower()).as_posix())
        return None if info is None else read(info)

    return find, Path(PurePosixPath(mesh.filename).name), read(mesh)
