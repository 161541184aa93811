"""Shapes of bodies, the mannequin, and people's own SMPL files (made up here in the same layout)."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from engines.errors import FormatError, MissingDependencyError, OutOfRangeError, UnknownLabelError
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.viewers import poses
from viewers import bodies
from viewers.bodies import anny, packed, smpl
from viewers.bodies.seating import seated
from viewers.camera import Camera
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene
from viewers.web.controls import dress


def sole(body: bodies.Body, motion: Motion) -> float:
    """Height of the lowest point of the body in the motion's first frame."""
    worn, played = bodies.body_for(motion, body)
    return float(worn.posed(played)[:, 1].min())


# ---- the default body's sliders ---------------------------------------------------------------------------------


def test_sliders_do_what_they_are_called() -> None:
    body = bodies.get("anny")
    assert {slider.name for slider in body.sliders} == {"gender", "age", "muscle", "weight", "height"}

    def girth(one: bodies.Body) -> float:
        belly = one.vertices[np.abs(one.vertices[:, 1] - one.skeleton.rest_positions[3, 1]) < 0.03]
        belly = belly[np.abs(belly[:, 0]) < 0.3]
        return float(np.ptp(belly[:, 0]) + np.ptp(belly[:, 2]))

    def shoulders(one: bodies.Body) -> float:
        places = one.skeleton.rest_positions
        return float(places[one.skeleton.index("left_shoulder"), 0] * 2)

    assert body.shaped(height=0.8).height > body.height + 0.2 > body.shaped(height=0.2).height + 0.3
    assert girth(body.shaped(weight=1.0)) > 1.03 * girth(body) > 1.05 * girth(body.shaped(weight=0.0))
    assert shoulders(body.shaped(gender=0.0)) > shoulders(body) > shoulders(body.shaped(gender=1.0))
    assert body.shaped(age=0.33).height < 1.45
    assert body.shaped(height=0.8).skeleton.bone_lengths[4] > 1.1 * SMPL22.bone_lengths[4]


def test_a_shape_is_set_and_taken_back() -> None:
    body = bodies.get("anny")
    heavy = body.shaped(weight=0.9)
    both = heavy.shaped(gender=1.0)
    assert dict(both.shape) == {"weight": 0.9, "gender": 1.0}
    assert np.allclose(both.vertices, body.shaped(gender=1.0, weight=0.9).vertices)
    assert np.array_equal(heavy.shaped(weight=0.45).vertices, body.vertices)
    assert body.shaped() is body and body.shape == {}
    assert np.allclose(np.linalg.norm(both.normals, axis=1), 1, atol=1e-4)
    half = body.shaped(weight=0.675).vertices - body.vertices
    assert np.allclose(2 * half, body.shaped(weight=0.9).vertices - body.vertices, atol=1e-6), "in proportion"


def test_hems_are_shaded_as_they_are_however_heavy_the_body_is() -> None:
    """Where cloth ends its normals are those of the cloth, and not of the rim under it too."""
    body = bodies.get("anny")
    hem = (body.tint > 0.9) & (body.vertices[:, 1] < 0.0)
    for weight, turned in ((0.4501, 0.1), (0.7, 12.0), (1.0, 20.0)):
        cosine = np.einsum("va,va->v", body.shaped(weight=weight).normals, body.normals)[hem]
        assert np.degrees(np.arccos(cosine.clip(-1, 1))).max() < turned


@pytest.mark.parametrize("values", [{"height": 0.8}, {"age": 0.33}, {"gender": 1.0, "weight": 1.0}])
def test_every_shape_stands_on_the_floor_and_keeps_its_skin(values: dict) -> None:
    body = bodies.get("anny").shaped(**values)
    for pose in (poses.stand(), poses.arms_up()):
        assert abs(sole(body, pose)) < 0.004
    corners = body.vertices[body.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    usual = bodies.get("anny").vertices[body.faces]
    before = np.cross(usual[:, 1] - usual[:, 0], usual[:, 2] - usual[:, 0])
    area, turned = np.linalg.norm(flat, axis=1), np.einsum("fa,fa->f", flat, before) < 0
    assert area[turned].sum() < 2e-4 * area.sum(), "no part is turned inside out, but for slivers on the soles"


def test_wrong_shapes_are_told() -> None:
    with pytest.raises(UnknownLabelError, match="unknown shape of body 'anny' 'wieght'; did you mean 'weight'"):
        bodies.get("anny").shaped(wieght=0.4)
    with pytest.raises(OutOfRangeError, match=r"height is 3; accepted: 0\.1 to 0\.8"):
        bodies.get("anny").shaped(height=3)
    with pytest.raises(UnknownLabelError, match="one shape only"):
        bodies.get("stick").shaped(weight=1.0)


def test_the_sliders_are_small_and_come_back_from_their_file(tmp_path: Path) -> None:
    assert anny.SHAPES.stat().st_size < 400_000
    rng = np.random.default_rng(0)
    moves = [
        packed.Moves(name, value, rng.normal(0, 0.3, (50, 3)), rng.normal(0, 0.1, (22, 3)))
        for name, value in (("a", 0.0), ("a", 1.0), ("b", 0.33))
    ]
    packed.save_moves(moves, tmp_path / "moves.npz")
    assert [p.name for p in tmp_path.iterdir()] == ["moves.npz"]
    for one, other in zip(moves, packed.read_moves(tmp_path / "moves.npz"), strict=True):
        assert (one.slider, one.value) == (other.slider, other.value)
        assert np.abs(one.vertices - other.vertices).max() <= packed.STEP / 2 + 1e-9
        assert np.allclose(one.offsets, other.offsets, atol=1e-6)


def test_a_shaped_body_is_drawn_larger_and_wholly_in_the_picture() -> None:
    tall = bodies.get("anny").shaped(height=0.8)
    camera = Camera("front", distance=6.0, target=(0.0, 1.0, 0.0))
    with Renderer(120, 120) as renderer:
        rows = []
        for body in ("anny", tall):
            picture = renderer.frame(Scene((Actor(poses.stand(), body),), camera, floor=False)).astype(int)
            empty = renderer.frame(Scene((Actor(poses.stand().moved((99.0, 0, 0)), body),), camera, floor=False))
            rows.append(np.ptp(np.flatnonzero((np.abs(picture - empty).max(-1) > 30).any(1))))
        framed = renderer.frame(Scene((Actor(poses.arms_up(), tall),), floor=False)).astype(int)
    assert rows[1] > 1.1 * rows[0]
    assert np.abs(framed[:3] - np.median(framed[:3], axis=1, keepdims=True)).max() < 25, "the hands are not cut off"


# ---- bodies with bones of their own ------------------------------------------------------------------------------


def test_the_mannequin_takes_smpl_rotations_as_its_package_does() -> None:
    mannequin = pytest.importorskip("mannequin", reason="pip install 'motionloom[mannequin]'")
    body = bodies.get("mannequin")
    assert "mannequin" in bodies.available() and body.own_bones
    motion = poses.squat()
    worn, played = bodies.body_for(motion, "mannequin")
    assert np.allclose(played.rotations, motion.rotations)
    model = mannequin.Mannequin("wooden")
    pose = model.rest_pose()
    turns = rotations.quaternion_to_rotvec(motion.rotations[0])
    pose["body_pose"], pose["pelvis_rotation"] = turns[1:], turns[0]
    wanted = model.vertices(pose)
    drawn = worn.posed(played)
    moved = (drawn - drawn.mean(0)) - (wanted - wanted.mean(0))
    assert np.abs(moved).max() < 0.02 and np.abs(moved).mean() < 0.001, "but for hands, which hang on the wrists"
    assert abs(sole(body, poses.stand())) < 0.02
    tall = body.shaped(beta1=3.0)
    assert tall.height > body.height + 0.1 and dict(tall.shape) == {"beta1": 3.0}
    with pytest.raises(OutOfRangeError, match="-5 to 5"):
        body.shaped(beta1=9.0)


def test_without_its_package_the_mannequin_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    from viewers.bodies import mannequin

    monkeypatch.setitem(sys.modules, "mannequin", None)
    mannequin.load.cache_clear()
    with pytest.raises(MissingDependencyError, match=r"pip install 'motionloom\[mannequin\]'"):
        mannequin.load()


def model_arrays(joints: int, vertices: int = 300, betas: int = 12) -> dict[str, np.ndarray]:
    """A made-up body in the layout of SMPL (24 joints), SMPL-H (52) or SMPL-X (55): points around stretched joints."""
    rng = np.random.default_rng(joints)
    parents = [-1, *SMPL22.parents[1:]]
    if joints == 24:
        parents += [20, 21]
    elif joints == 52:
        parents += [
            p
            for wrist, first in ((20, 22), (21, 37))
            for f in range(5)
            for p in (wrist, first + 3 * f, first + 3 * f + 1)
        ]
    else:
        parents += [15, 15, 15]
        parents += [
            p
            for wrist, first in ((20, 25), (21, 40))
            for f in range(5)
            for p in (wrist, first + 3 * f, first + 3 * f + 1)
        ]
    places = np.zeros((joints, 3))
    places[:22] = 1.1 * SMPL22.rest_positions
    for joint in range(22, joints):
        places[joint] = places[parents[joint]] + [0.03 * np.sign(places[parents[joint], 0]), 0, 0]
    places += [0.003, -0.35, 0.012]
    home = np.concatenate([np.arange(joints), rng.integers(0, joints, vertices - joints)])
    points = places[home] + np.concatenate([np.zeros((joints, 3)), rng.normal(0, 0.03, (vertices - joints, 3))])
    weights = np.full((vertices, joints), 0.1 / joints)
    weights[np.arange(vertices), home] += 0.9
    regressor = np.zeros((joints, vertices))
    regressor[np.arange(joints), np.arange(joints)] = 1.0  # the first points are the joints
    directions = np.zeros((vertices, 3, betas))
    directions[..., 0] = 0.05 * points  # the first coefficient is size
    directions[..., 1:] = 0.002 * rng.normal(size=(vertices, 3, betas - 1))
    return {
        "v_template": points, "f": rng.integers(0, vertices, (500, 3)).astype(np.uint32), "weights": weights,
        "kintree_table": np.array([[2**32 - 1, *parents[1:]], range(joints)], np.uint32), "J_regressor": regressor,
        "shapedirs": directions, "posedirs": np.zeros((vertices, 3, 9)),
    }  # fmt: skip


def model_file(folder: Path, joints: int = 55, **changes: np.ndarray | None) -> Path:
    arrays = {**model_arrays(joints), **changes}
    path = folder / f"model{joints}.npz"
    np.savez(path, part2num=np.array({"left": 1}, dtype=object), **{k: v for k, v in arrays.items() if v is not None})
    return path


@pytest.mark.parametrize(("joints", "name"), [(24, "smpl"), (52, "smplh"), (55, "smplx")])
def test_own_model_files_become_bodies(tmp_path: Path, joints: int, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path, raw = model_file(tmp_path, joints), model_arrays(joints)
    body = bodies.get(str(path))
    assert body.name == name and body.skeleton.joints == SMPL22.joints
    assert np.allclose(body.skeleton.rest_positions, 1.1 * SMPL22.rest_positions, atol=1e-6)
    assert np.allclose(body.vertices, raw["v_template"] - raw["v_template"][0], atol=1e-6)
    assert np.allclose(body.skin_weights.sum(1), 1, atol=1e-5)
    fingers = np.flatnonzero(raw["weights"][:, 22:].max(1) > 0.8)
    homes = {20, 21} if joints != 55 else {15, 20, 21}
    assert len(fingers) and set(body.skin_indices[fingers, 0]) == homes, "fingers hang on wrists, eyes on the head"
    bigger = body.shaped(beta1=2.0)
    assert np.allclose(bigger.skeleton.bone_lengths, 1.1 * body.skeleton.bone_lengths, rtol=1e-5)
    smaller = body.shaped(beta1=-2.0)
    assert np.allclose(smaller.vertices - body.vertices, body.vertices - bigger.vertices, atol=1e-6)
    assert len(body.sliders) == 10
    monkeypatch.setenv(smpl.VARIABLES[name], str(path))
    assert name in bodies.available() and np.array_equal(bodies.get(name).vertices, body.vertices)
    with Renderer(64, 64) as renderer:
        assert np.ptp(renderer.frame(Scene((Actor(poses.squat(), str(path)),)))) > 60


def test_a_replaced_file_is_read_again(tmp_path: Path) -> None:
    import os

    path = model_file(tmp_path)
    before = bodies.get(str(path)).vertices
    model_file(tmp_path, v_template=2 * model_arrays(55)["v_template"])
    os.utime(path, ns=(1, 1))
    assert np.allclose(bodies.get(str(path)).vertices, 2 * before, atol=1e-5)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"weights": None}, "has no 'weights'"),
        ({"J_regressor": np.zeros((55, 9))}, "'J_regressor' is float64 of shape"),
        ({"J_regressor": np.array([None, 1], dtype=object)}, "no readable .npz of plain arrays"),
        ({"kintree_table": np.zeros((2, 7), int)}, "has 7 joints.*accepted: smpl with 24"),
        ({"kintree_table": np.full((2, 55), 54)}, "make no body"),
        ({"v_template": np.full((300, 3), np.nan)}, "make no body"),
        ({"f": np.full((10, 3), 300)}, "make no body"),
        ({"weights": np.zeros((300, 55))}, "make no body"),
        ({"v_template": np.array("text")}, "accepted"),
        ({"shapedirs": np.zeros((300, 3))}, "'shapedirs' is float64"),
    ],
)
def test_files_that_are_no_models_say_why(tmp_path: Path, changes: dict, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        bodies.get(str(model_file(tmp_path, **changes)))


def test_missing_files_and_pickles_say_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MOTIONLOOM_SMPLX", raising=False)
    with pytest.raises(FormatError, match=r"\$MOTIONLOOM_SMPLX: is not set.*your own licensed model file"):
        bodies.get("smplx")
    with pytest.raises(FormatError, match="there is no such file"):
        bodies.get(str(tmp_path / "SMPLX_NEUTRAL.npz"))
    trap = tmp_path / "SMPL_NEUTRAL.pkl"
    trap.write_bytes(b"cos\nsystem\n(S'touch trapped'\ntR.")
    with pytest.raises(FormatError, match=r"pickle files are not opened.*accepted: \.npz"):
        bodies.get(str(trap))
    (tmp_path / "junk.npz").write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(FormatError, match="no readable"):
        bodies.get(str(tmp_path / "junk.npz"))
    assert not (Path.cwd() / "trapped").exists()


def test_seating_keeps_poses_and_scales_the_way() -> None:
    motion = poses.stride(20)
    body = bodies.get("anny").shaped(height=0.8)
    _, played = bodies.body_for(motion, body)
    legs = body.skeleton.rest_positions[:, 1].min() / SMPL22.rest_positions[:, 1].min()
    assert legs > 1.1
    assert np.ptp(played.translation[:, 2]) == pytest.approx(legs * np.ptp(motion.translation[:, 2]))
    assert np.array_equal(played.rotations, motion.rotations)
    again = seated(motion, bodies.get("anny"), poses.TOE)
    assert np.allclose(again.translation, motion.translation, atol=1e-3), "on its own body nothing changes"


def test_the_browser_is_given_the_seated_motion() -> None:
    body = bodies.get("anny").shaped(age=0.33)
    worn, (played,) = dress([poses.stride(10)], body)
    assert worn is body and played.skeleton == body.skeleton
    worn, (plain,) = dress([poses.stride(10)], "anny")
    assert plain.skeleton == SMPL22 and worn is not None


def test_what_was_asked_for_is_what_actors_take() -> None:
    assert bodies.wanted() == "anny" and bodies.wanted("stick") == "stick"
    made = bodies.wanted(None, {"weight": 0.8})
    assert isinstance(made, bodies.Body) and dict(made.shape) == {"weight": 0.8}
    with pytest.raises(UnknownLabelError, match="unknown body 'ann'"):
        bodies.wanted("ann", {"weight": 0.8})
