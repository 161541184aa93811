"""Meshes of other programs: what is read of them, where it stands, and what is refused."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from engines.character import meshes
from engines.character.meshes import MAX_FILES, read_mesh
from engines.character.pieces import Piece, joined
from engines.errors import FormatError, MeshError, OutOfRangeError

RED, BLUE, GREEN = (250, 20, 10), (10, 20, 250), (20, 240, 30)
BOX = trimesh.creation.box((0.5, 1.7, 0.3))


def picture(top=RED, bottom=BLUE) -> Image.Image:
    """The upper half in one colour, the lower in another."""
    rows = np.repeat(np.array([top, bottom], np.uint8), 8, axis=0)
    return Image.fromarray(np.repeat(rows[:, None], 16, axis=1))


def obj(folder: Path, image: str = "skin.png", scale: float = 1.0, up: int = 1, shift: float = 0.0) -> Path:
    """A box with the picture upright on it: red above, blue below."""
    points = BOX.vertices * scale
    places = points if up == 1 else np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=-1)
    lines = ["mtllib box.mtl", "usemtl skin"]
    lines += [f"v {x} {y} {z}" for x, y, z in places]
    lines += [f"vt 0.5 {0.8 + shift if point[1] > 0 else 0.2 + shift}" for point in BOX.vertices]
    lines += ["f " + " ".join(f"{corner + 1}/{corner + 1}" for corner in face) for face in BOX.faces]
    (folder / "box.obj").write_text("\n".join(lines))
    (folder / "box.mtl").write_text(f"newmtl skin\nKd 0 0 0\nmap_Kd {image}\n")
    return folder / "box.obj"


def upright(surface) -> None:
    """Red above, blue below, on the floor, 1.7 m tall."""
    assert len(surface.faces) == 12
    np.testing.assert_allclose(surface.vertices.min(0), [-0.25, 0, -0.15], atol=1e-6)
    np.testing.assert_allclose(surface.vertices.max(0), [0.25, 1.7, 0.15], atol=1e-6)
    colours = surface.coloured().colours.astype(int)
    above = surface.vertices[:, 1] > 0.8
    assert np.abs(colours[above] - RED).max() < 8 and np.abs(colours[~above] - BLUE).max() < 8


@pytest.mark.parametrize(
    ("scale", "unit"), [(1.0, ""), (100.0, "centimetres"), (1000.0, "millimetres"), (9.0, "1.7 m")]
)
@pytest.mark.parametrize("up", [1, 2])
def test_an_obj_with_its_texture_stands_upright_in_metres(tmp_path, scale: float, unit: str, up: int) -> None:
    picture().save(tmp_path / "Skin.PNG")  # capitals are lost where files come from
    found = read_mesh(obj(tmp_path, scale=scale, up=up))
    upright(found.surface)
    said = " ".join(found.remarks)
    assert unit in said and ("Z axis" in said) == (up == 2)
    assert bool(found.remarks) == (scale != 1.0 or up == 2)


def test_a_known_height_counts_more_than_any_guess(tmp_path) -> None:
    picture().save(tmp_path / "skin.png")
    found = read_mesh(obj(tmp_path, scale=9.0), height=1.6)
    assert np.ptp(found.surface.vertices[:, 1]) == pytest.approx(1.6) and found.remarks == ()
    with pytest.raises(OutOfRangeError, match="metres"):
        read_mesh(tmp_path / "box.obj", height=175.0)


def test_an_archive_holds_mesh_and_texture(tmp_path) -> None:
    (tmp_path / "in" / "maps").mkdir(parents=True)
    picture().save(tmp_path / "in" / "maps" / "skin.png")
    obj(tmp_path / "in", image="maps\\skin.png")
    with zipfile.ZipFile(tmp_path / "box.zip", "w") as archive:
        for file in sorted((tmp_path / "in").rglob("*.*")):
            archive.write(file, f"Box/{file.relative_to(tmp_path / 'in')}")
    upright(read_mesh(tmp_path / "box.zip").surface)
    upright(read_mesh((tmp_path / "box.zip").read_bytes(), "mine.zip").surface)


def test_nothing_outside_the_folder_is_opened(tmp_path) -> None:
    (tmp_path / "in").mkdir()
    picture().save(tmp_path / "secret.png")
    (tmp_path / "in" / "link.png").symlink_to(tmp_path / "secret.png")
    for name in ("../secret.png", str(tmp_path / "secret.png"), "link.png", "https://example.org/skin.png"):
        found = read_mesh(obj(tmp_path / "in", image=name))
        assert found.surface.texture is None
        assert found.remarks == (f"What it refers to as {name!r} was not found and is left out.",)
    found = read_mesh((tmp_path / "in" / "box.obj").read_bytes(), "box.obj")
    assert "box.mtl" in found.remarks[0]


def test_a_picture_that_repeats_is_unrolled(tmp_path) -> None:
    picture().save(tmp_path / "skin.png")
    upright(read_mesh(obj(tmp_path, shift=-3.0)).surface)


@pytest.mark.parametrize("kind", ["glb", "ply"])
def test_what_other_programs_write_is_read(tmp_path, kind: str) -> None:
    mesh = trimesh.Trimesh(BOX.vertices, BOX.faces, process=False)
    above = BOX.vertices[:, 1] > 0
    if kind == "glb":
        uv = np.stack([np.full(8, 0.5), np.where(above, 0.8, 0.2)], axis=-1)
        mesh.visual = trimesh.visual.TextureVisuals(uv, image=picture())
    else:
        mesh.visual.vertex_colors = np.where(above[:, None], RED, BLUE)
    scene = trimesh.Scene()
    scene.add_geometry(mesh, transform=trimesh.transformations.translation_matrix([3, 7, -2]))
    made = scene if kind == "glb" else mesh
    made.export(tmp_path / f"box.{kind}")
    found = read_mesh(tmp_path / f"box.{kind}")
    upright(found.surface)
    assert (found.surface.texture is None) == (kind == "ply")


def test_pieces_of_many_pictures_share_one_texture() -> None:
    vertices, faces = np.array(BOX.vertices), np.array(BOX.faces)
    place = np.where(vertices[:, 1] > 0, 0.2, 0.8)
    uv = np.stack([np.full(8, 0.5), place], axis=-1)
    pieces = [
        Piece(vertices, faces, uv=uv, picture=np.asarray(picture())),
        Piece(vertices + 2, faces, uv=uv, picture=np.asarray(picture(GREEN, RED))),
        Piece(vertices + 4, faces, colour=GREEN),
        Piece(vertices + 6, faces, uv=uv, picture=np.asarray(picture())),
        Piece(vertices[:0], faces[:0]),
    ]
    surface = joined(pieces)
    assert len(surface.faces) == 48 and surface.texture.shape == (2048, 2048, 3)
    colours = surface.coloured().colours.reshape(4, 8, 3).astype(int)
    for number, (above, below) in enumerate([(RED, BLUE), (GREEN, RED), (GREEN, GREEN), (RED, BLUE)]):
        wanted = np.where(vertices[:, 1:2] > 0, above, below)
        assert np.abs(colours[number] - wanted).max() < 8
    alone = joined([pieces[0], pieces[3]])
    assert alone.texture.shape == (16, 16, 3), "one picture stays as it is"
    assert joined([pieces[2]]).texture is None and (joined([pieces[2]]).colours == GREEN).all()
    assert joined([Piece(vertices, faces)]).colours is None


def archive_of(**files: bytes) -> bytes:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name.replace("_", "."), data)
    return held.getvalue()


AXES = b"".join(b"property float %c\n" % axis for axis in b"xyz")
FACELESS = b"ply\nformat ascii 1.0\nelement vertex 1\n" + AXES + b"end_header\n0 1 2\n"
REFUSED = {
    "empty": (b"", "box.obj", "no readable|no faces"),
    "of another kind": (b"solid", "box.stl", r"\.obj, \.ply, \.glb"),
    "no glb": (b"glTF but not really, whatever it says", "box.glb", "glTF"),
    "broken off": (trimesh.Scene(BOX).export(file_type="glb")[:-200], "box.glb", "breaks off"),
    "points alone": (FACELESS, "box.ply", "no faces"),
    "no numbers": (b"v nan 0 0\nv 0 1 0\nv 1 0 nan\nf 1 2 3\n", "box.obj", "finite|height"),
    "flat": (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "box.obj", "flat"),
    "a claim": (b"ply\nformat ascii 1.0\nelement face 5000000\nend_header\n", "box.ply", "5,000,000 faces"),
    "no archive": (b"PK\x03\x04 and nothing", "box.zip", r"\.zip"),
    "nothing in it": (archive_of(readme_txt=b"hello"), "box.zip", "no mesh"),
    "too many in it": (archive_of(**{f"a{i}_png": b"" for i in range(MAX_FILES + 1)}), "box.zip", "at most 500"),
}


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_what_is_no_mesh_is_refused_in_words(name: str) -> None:
    data, file, words = REFUSED[name]
    with pytest.raises((FormatError, MeshError), match=words):
        read_mesh(data, file)


def test_sizes_are_looked_at_before_anything_is_unpacked(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(meshes, "MAX_FACES", 11)
    box = obj(tmp_path)
    for data, name in ((box.read_bytes(), "box.obj"), (trimesh.Scene(BOX).export(file_type="glb"), "box.glb")):
        with pytest.raises(MeshError, match="12 faces; accepted: at most 11"):
            read_mesh(data, name)
    monkeypatch.setattr(meshes, "MAX_BYTES", 5000)
    with pytest.raises(FormatError, match="20,000 bytes; accepted: at most 5,000"):
        read_mesh(archive_of(box_obj=bytes(20_000)), "bomb.zip")
    (tmp_path / "big.obj").write_bytes(bytes(5001))
    for source in (tmp_path / "big.obj", bytes(5001)):
        with pytest.raises(FormatError, match="at most 5,000"):
            read_mesh(source, "big.obj")
