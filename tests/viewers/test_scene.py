"""Scenes, cameras and framing: no graphics here."""

from __future__ import annotations

import numpy as np
import pytest

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.viewers import poses
from viewers.camera import MODES, Camera, frame_points, projection_matrix, view_matrix
from viewers.scene import LAYOUTS, PALETTE, Actor, Backdrop, Scene, hex_to_rgb, sample, telling_frame, thumbnail

TIMES = np.linspace(0, 1.9, 12)


def seen(scene: Scene, points: np.ndarray, aspect: float, times: np.ndarray = TIMES) -> np.ndarray:
    """Where points (N, P, 3) come to lie in the picture, -1 to 1."""
    track = scene.track(times, aspect)
    whole = track.projection(aspect) @ track.views()
    clip = np.einsum("nab,npb->npa", whole, np.pad(points, ((0, 0), (0, 0), (0, 1)), constant_values=1.0))
    assert (clip[..., 3] > 0).all(), "nothing may lie behind the camera"
    return clip[..., :3] / clip[..., 3:]


@pytest.mark.parametrize("aspect", [16 / 9, 1.0, 9 / 16])
@pytest.mark.parametrize("mode", MODES)
def test_every_camera_keeps_the_whole_motion_in_the_picture(mode, aspect: float) -> None:
    motion = poses.stride(40)
    frames = np.round(TIMES * motion.fps).astype(int)
    places = seen(Scene.of(motion, camera=Camera(mode)), motion.positions[frames], aspect)
    assert np.abs(places).max() < 1.0
    if mode != "follow":
        everything = seen(
            Scene.of(motion, camera=Camera(mode)), np.tile(motion.positions.reshape(1, -1, 3), (12, 1, 1)), aspect
        )
        assert np.abs(everything[..., :2]).max() > 0.55, "and not lose it in the distance"


def test_named_sides_show_the_named_side() -> None:
    motion = poses.stand()
    for mode, axis, sign in (("front", 2, 1), ("back", 2, -1), ("left", 0, 1), ("right", 0, -1)):
        track = Scene.of(motion, camera=Camera(mode)).track(np.zeros(1), 1.0)
        assert sign * (track.eye - track.target)[0, axis] > 1.0
    nose = motion.positions[:, [SMPL22.index("head")]] + np.array([0, 0.08, 0.1])
    left = motion.positions[:, [SMPL22.index("left_wrist")]]
    scene = Scene.of(motion, camera=Camera("front"))
    assert seen(scene, left, 1.0, np.zeros(1))[0, 0, 0] > 0.1, "the figure's left hand is on the right of the picture"
    assert abs(seen(scene, nose, 1.0, np.zeros(1))[0, 0, 0]) < 0.05


def test_a_following_camera_goes_along_smoothly() -> None:
    motion = poses.stride(60)
    jolts = np.array(motion.translation)
    jolts[:, 0] += 0.05 * (-1.0) ** np.arange(60)
    motion = motion.replaced(translation=jolts)
    track = Scene.of(motion, camera=Camera("follow")).track(np.arange(60) / 20, 1.5)
    assert np.ptp(track.target[:, 2]) > 1.5
    assert np.abs(np.diff(track.eye[:, 0], 2)).max() < 0.002, "jolts of the root do not reach the camera"
    assert np.allclose(track.eye - track.target, (track.eye - track.target)[0])


def test_a_still_camera_stands_still() -> None:
    track = Scene.of(poses.stride(30), camera=Camera("orbit")).track(TIMES, 1.5)
    assert np.ptp(track.eye, axis=0).max() == 0.0


def test_what_is_asked_of_a_camera_is_done() -> None:
    camera = Camera("orbit", yaw=0.3, pitch=0.1, distance=4.0, target=(1.0, 1.0, 0.0))
    track = Scene.of(poses.stand(), camera=camera).track(np.zeros(1), 1.0)
    assert np.allclose(track.target[0], (1, 1, 0))
    away = track.eye[0] - track.target[0]
    assert np.linalg.norm(away) == pytest.approx(4.0)
    assert np.arctan2(away[0], away[2]) == pytest.approx(0.3)
    assert np.arcsin(away[1] / 4.0) == pytest.approx(0.1)


def test_view_and_projection_agree_with_the_textbook() -> None:
    view = view_matrix(np.array([0.0, 0.0, 5.0]), np.zeros(3))
    assert np.allclose(view @ [1, 2, 0, 1], [1, 2, -5, 1])
    clip = projection_matrix(np.pi / 2, 2.0, 1.0, 9.0) @ [2.0, 1.0, -1.0, 1.0]
    assert np.allclose(clip[:2] / clip[3], [1.0, 1.0]), "a corner of the picture"
    for depth, wanted in ((-1.0, -1.0), (-9.0, 1.0)):
        place = projection_matrix(0.6, 1.0, 1.0, 9.0) @ [0, 0, depth, 1]
        assert place[2] / place[3] == pytest.approx(wanted)
    down = view_matrix(np.array([0.0, 5.0, 0.0]), np.zeros(3))
    assert np.allclose(down[:3, :3] @ down[:3, :3].T, np.eye(3)), "looking straight down is possible"


def test_framing_is_tight() -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(200, 3)) * [1.0, 0.5, 0.2]
    look = np.array([0.0, 0.0, 1.0])
    target, distance = frame_points(points, look, 0.6, 1.3, fill=0.9)
    away = points - target
    across = np.abs(away[:, 0]) / (distance - away[:, 2]) / (1.3 * np.tan(0.3))
    high = np.abs(away[:, 1]) / (distance - away[:, 2]) / np.tan(0.3)
    assert max(across.max(), high.max()) == pytest.approx(0.9, abs=0.02)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_place_every_motion(layout) -> None:
    motions = [poses.stride(20 + 5 * i).moved((3.0 * i, 0, -i)) for i in range(5)]
    scene = Scene.of(motions, layout)
    starts = np.array([a.motion.positions[0, 0] + a.offset for a in scene.actors])
    assert [a.colour for a in scene.actors] == list(PALETTE[:5])
    assert np.allclose(starts[:, 1], [m.positions[0, 0, 1] for m in motions]), "heights are kept"
    if layout == "overlaid":
        assert np.allclose(starts[:, [0, 2]], 0.0)
        return
    boxes = [(a.motion.positions.reshape(-1, 3) + a.offset) for a in scene.actors]
    for i, one in enumerate(boxes):
        for other in boxes[:i]:
            apart = (one.min(0) > other.max(0)) | (other.min(0) > one.max(0))
            assert apart[[0, 2]].any(), "no two motions share ground"
    if layout == "side_by_side":
        assert (np.diff(starts[:, 0]) > 0).all(), "in order from the left of the picture"
    else:
        assert len(np.unique(np.round(starts[:, 2], 1))) >= 2


def test_one_motion_stays_where_it_is_in_its_own_colours() -> None:
    (actor,) = Scene.of(poses.stride(5).moved((2.0, 0.0, 1.0)), ghosts=3).actors
    assert actor.offset == (0.0, 0.0, 0.0) and actor.colour is None and actor.ghosts == 3


def test_frames_of_a_video_cover_the_longest_motion() -> None:
    scene = Scene.of([poses.stride(20), poses.stride(40)])
    assert scene.duration == pytest.approx(2.0)
    assert len(scene.times(30)) == 60
    assert len(Scene.of(poses.stand()).times(5)) == 1, "a single frame is a video of one"
    with pytest.raises(OutOfRangeError, match="fps"):
        scene.times(0)


def test_poses_between_frames_turn_evenly() -> None:
    """30 pictures a second out of 20 frames: constant turning must stay constant, not stutter."""
    turns = np.tile(rotations.IDENTITY, (41, 22, 1))
    angle = np.linspace(0, 2.0, 41)
    turns[:, 4] = rotations.rotvec_to_quaternion(np.stack([angle, 0 * angle, 0 * angle], axis=-1))
    path = np.stack([angle, 0 * angle, angle**2], axis=-1)
    motion = Motion(SMPL22, turns, path, 20.0)
    drawn, places = sample(motion, np.arange(60) / 30)
    steps = np.diff(rotations.quaternion_to_rotvec(drawn[:, 4])[:, 0])
    assert np.allclose(steps, 2.0 / 40 * 20 / 30, atol=1e-9)
    assert np.allclose(np.diff(places[:, 0]), steps)
    held, _ = sample(motion, np.array([-1.0, 99.0]))
    assert np.allclose(held, turns[[0, -1]])


def test_a_thumbnail_shows_the_telling_frame_from_the_front() -> None:
    parts = [poses.stand(), poses.arms_up(), poses.stand()]
    motion = parts[0].concat(parts[0], parts[1], parts[2])
    assert telling_frame(motion) == 2
    turned = motion.moved(yaw=1.0)
    scene = thumbnail(turned)
    track = scene.track(np.zeros(1), 1.0)
    away = (track.eye - track.target)[0]
    assert 0 < np.arctan2(away[0], away[2]) - 1.0 < 1.0, "three quarters from the body's own front"
    assert len(scene.actors[0].motion) == 1


def test_wrong_words_and_numbers_are_refused() -> None:
    motion = poses.stand()
    for make, word in (
        (lambda: Actor(motion, show="bones"), "show"),  # type: ignore[arg-type]
        (lambda: Camera("foloww"), "camera"),  # type: ignore[arg-type]
        (lambda: Scene.of(motion, "pile"), "layout"),  # type: ignore[arg-type]
        (lambda: Scene((Actor(motion),), backdrop="drak"), "backdrop"),
    ):
        with pytest.raises(UnknownLabelError, match=word):
            make()
    for make, word in (
        (lambda: Actor(motion, colour="#12"), "colour"),
        (lambda: Actor(motion, ghosts=-1), "ghosts"),
        (lambda: Scene(()), "actors"),
        (lambda: Scene.of([]), "actors"),
        (lambda: Camera(fov=0.0), "fov"),
        (lambda: Camera(distance=-1.0), "distance"),
    ):
        with pytest.raises(OutOfRangeError, match=word):
            make()


def test_colours_are_read_and_the_palette_is_told_apart() -> None:
    assert hex_to_rgb("#ff8000") == (1.0, 128 / 255, 0.0)
    assert hex_to_rgb("#f80") == (1.0, 136 / 255, 0.0)
    colours = np.array([hex_to_rgb(c) for c in PALETTE])
    apart = np.linalg.norm(colours[:, None] - colours[None], axis=-1)[np.triu_indices(len(colours), 1)]
    assert apart.min() > 0.08
    own = Backdrop(centre="#ffffff")
    assert Scene((Actor(poses.stand()),), backdrop=own).colours is own
