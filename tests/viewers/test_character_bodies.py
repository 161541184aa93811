"""People's own characters: kept, found by name, and shown and exported like any other body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from engines.character.character import Character
from engines.character.mesh import Surface
from engines.errors import FormatError, OutOfRangeError, UnknownLabelError
from engines.formats.gltf import Gltf
from engines.skeletons import SMPL22, roles
from engines.skeletons.skeleton import Skeleton
from studio import tasks
from studio.settings import ExportSettings
from tests.viewers import poses
from tests.viewers.textured import checkers, textured
from viewers import bodies
from viewers.bodies import character
from viewers.bodies.body import LARGEST_TEXTURE
from viewers.web import payload, standalone


def made(skeleton: Skeleton = SMPL22, texture: np.ndarray | None = None) -> Character:
    """The default body in numbered checkers, a little taller than the house skeleton."""
    body = textured(checkers())
    tall = skeleton.scaled({"*": 1.05})
    surface = Surface(
        1.05 * body.vertices.astype(float), body.faces, uv=body.uv, texture=body.texture if texture is None else texture
    )
    return Character("Ada", surface, body.skin_indices, body.skin_weights, np.ones(len(body.vertices)), tall)


@pytest.fixture
def ada(tmp_path, monkeypatch) -> str:
    monkeypatch.setenv("MOTIONLOOM_CHARACTERS", str(tmp_path / "mine"))
    assert character.saved() == ()
    return character.save(made(), "Ada")


def test_a_kept_character_is_a_body_by_name_and_by_file(ada: str, tmp_path) -> None:
    assert ada == "character:Ada" and ada in bodies.available()
    body = bodies.get(ada)
    wanted = made()
    assert body.name == ada and body.own_bones and body.licence
    np.testing.assert_allclose(body.vertices, wanted.surface.vertices, atol=1e-6)
    np.testing.assert_array_equal(body.texture, wanted.surface.texture)
    np.testing.assert_array_equal(body.colours, wanted.surface.coloured().colours)
    assert bodies.get(str(tmp_path / "mine" / "Ada.npz")).name == ada
    assert bodies.get(ada) is body, "read once"
    character.save(made(texture=np.zeros((8, 8, 3), np.uint8)), "Ada")
    assert not bodies.get(ada).colours.any(), "and again once it was replaced"


def test_names_that_cannot_be_are_refused_in_words(ada: str, tmp_path) -> None:
    with pytest.raises(UnknownLabelError, match="character:Ada"):
        bodies.get("character:Ida")
    for name in ("", "../Ada", "a/b", "x" * 61, ".hidden"):
        with pytest.raises(OutOfRangeError, match="letters"):
            character.save(made(), name)
    (tmp_path / "mine" / "broken.npz").write_bytes(b"PK but no more")
    with pytest.raises(FormatError, match="broken"):
        bodies.get("character:broken")
    (tmp_path / "taken").write_text("a file")
    with pytest.MonkeyPatch.context() as elsewhere, pytest.raises(FormatError, match="cannot be made"):
        elsewhere.setenv("MOTIONLOOM_CHARACTERS", str(tmp_path / "taken" / "in"))
        character.save(made(), "Ada")


def test_a_coarser_level_keeps_shape_and_seams(ada: str) -> None:
    body, surface = bodies.get(ada), made().surface
    (coarse,) = body.coarse
    assert len(coarse) < 0.6 * len(body.faces)
    few = surface.replaced(faces=coarse.astype(np.int64))
    assert few.open_edges <= surface.open_edges, "no hole is torn"
    assert few.areas.sum() == pytest.approx(surface.areas.sum(), rel=0.01)
    middles = few.vertices[few.faces].mean(1)
    assert KDTree(surface.vertices).query(middles)[0].max() < 0.03
    turned = []
    for one in (surface, few):
        flat = np.cross(*np.diff(one.vertices[one.faces], axis=1).transpose(1, 0, 2))
        turned.append((np.einsum("fa,fa->f", flat, surface.normals[one.faces].sum(1)) <= 0).mean())
    assert turned[1] < turned[0] + 0.02, "no face is turned over (linings are from the start)"
    seams = np.bincount(surface.groups)[surface.groups] > 1
    used = np.isin(np.arange(len(seams)), coarse)
    assert used[seams & np.isin(np.arange(len(seams)), surface.faces)].all()
    assert used[~seams].mean() < 0.5
    assert character.body_of(made(texture=None)).coarse[0].shape == coarse.shape


def test_large_textures_are_made_smaller() -> None:
    body = character.body_of(made(texture=np.full((600, 3000, 3), 77, np.uint8)))
    assert body.texture.shape == (round(600 * LARGEST_TEXTURE / 3000), LARGEST_TEXTURE, 3)
    assert (body.texture == 77).all()


def test_takes_are_exported_with_it(ada: str, tmp_path) -> None:
    walk = poses.stride(6)
    how = ExportSettings(body=ada, width=96, height=64, fps=10.0)
    for ending in ("mp4", "png", "glb"):
        assert tasks.export(walk, tmp_path / f"walk.{ending}", how).stat().st_size > 500
    gltf = Gltf(tmp_path / "walk.glb", (tmp_path / "walk.glb").read_bytes())
    assert gltf.document["images"] and gltf.document["nodes"][-1]["name"] == ada
    page = standalone.page(walk, body=ada)
    assert len(page) > 1_000_000
    header, arrays = payload.unpack(payload.encode_body(bodies.get(ada)))
    assert header["texture"] == "image/webp" and len(arrays["uv"]) == len(arrays["vertices"])


def test_a_character_with_joints_of_its_own_walks_on_the_floor() -> None:
    names = [f"mixamorig:{joint}" for joint in SMPL22.joints]
    own = roles.with_roles(Skeleton("own", tuple(names), SMPL22.parents, SMPL22.offsets))
    body = character.body_of(made(own))
    walk = poses.stride(12).moved((0.0, 0.0, 1.0))
    worn, played = bodies.body_for(walk, body)
    assert worn is body and played.skeleton == body.skeleton and len(played) == 12
    usual, usually = bodies.body_for(walk, "anny")
    for frame in (0, 5, 11):
        lowest = body.posed(played, frame)[:, 1].min()
        assert lowest == pytest.approx(1.05 * usual.posed(usually, frame)[:, 1].min(), abs=0.012)
    assert played.translation[-1, 2] == pytest.approx(1.05 * walk.translation[-1, 2], rel=0.02)
    other = poses.stride(3).retarget(own)
    assert bodies.body_for(other, "anny")[1].skeleton.joints == SMPL22.joints
