"""Pictures: against small references, and against what must be true of any renderer."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from engines.errors import MotionloomError, OutOfRangeError
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton
from tests.viewers import poses
from tests.viewers.pictures import same_picture
from viewers import bodies
from viewers.camera import Camera
from viewers.gl import context as contexts
from viewers.gl import extent
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene

SIZE = (160, 120)


@pytest.fixture(scope="module")
def renderer():
    with Renderer(*SIZE) as made:
        yield made


def scene(motion: Motion, camera: Camera | None = None, **options) -> Scene:
    return Scene((Actor(motion, **options),), camera or Camera("orbit"))


REFERENCES = {
    "t-pose": lambda: scene(poses.t_pose()),
    "squat": lambda: scene(poses.squat()),
    "squat-behind": lambda: scene(poses.squat(), Camera("orbit", yaw=2.6)),
    "arms-up": lambda: scene(poses.arms_up(), Camera("orbit", yaw=0.2)),
    "arms-up-behind": lambda: scene(poses.arms_up(), Camera("back")),
    "seated": lambda: scene(poses.seated()),
    "stick": lambda: scene(poses.seated(), body="stick"),
    "both": lambda: scene(poses.stand(), show="both", colour="#cc79a7"),
    "marks": lambda: scene(poses.stride(), Camera("follow"), ghosts=8, trail=True, contacts=True),
    "row": lambda: Scene.of([poses.stand(), poses.squat(), poses.arms_up()]).replaced(backdrop="light"),
}


@pytest.mark.parametrize("name", sorted(REFERENCES))
def test_pictures_look_like_their_references(renderer: Renderer, name: str, tmp_path) -> None:
    same_picture(renderer.frame(REFERENCES[name](), 1.0), name, tmp_path)


def test_a_small_change_of_pose_is_noticed(renderer: Renderer, tmp_path) -> None:
    bent = poses.pose(**poses.both("shoulder", 0, 0, -12))
    with pytest.raises(AssertionError, match="differs from its reference"):
        same_picture(renderer.frame(scene(bent), 1.0), "t-pose", tmp_path)
    assert (tmp_path / "t-pose-difference.png").exists()


def test_a_thumbnail_is_a_picture_of_the_figure(renderer: Renderer) -> None:
    picture = renderer.thumbnail(poses.stand().concat(poses.arms_up()))
    assert picture.shape == (120, 160, 3) and picture.dtype == np.uint8
    empty = renderer.frame(scene(poses.stand().moved((500.0, 0.0, 0.0)), Camera(distance=5.0, target=(0, 1, 0))))
    rows = np.flatnonzero((np.abs(picture.astype(int) - empty).max(-1) > 25).any(1))
    assert np.ptp(rows) > 0.7 * 120, "it fills the height"


def test_skinning_on_the_gpu_is_skinning_on_the_cpu(renderer: Renderer) -> None:
    body, motion = bodies.get("anny"), poses.squat()
    still = replace(body, vertices=body.posed(motion), name="frozen")
    frozen = Motion(SMPL22, np.tile(rotations.IDENTITY, (1, 22, 1)), np.zeros((1, 3)), 20.0)
    camera = Camera("orbit", distance=3.2, target=(0.0, 0.6, 0.0))
    one = renderer.frame(scene(motion, camera, body=body))
    other = renderer.frame(scene(frozen, camera, body=still))
    shape = np.abs(one.astype(int) - other).max(-1) > 90  # normals are not reposed, so shades differ, outlines do not
    assert shape.mean() < 0.005


def test_nothing_of_a_figure_is_cut_off_by_the_strips() -> None:
    """Every vertex in large poses must project into the strips that are composed."""
    size, body = (320, 240), bodies.get("anny")
    for motion in (poses.squat(), poses.arms_up(), poses.seated(), poses.t_pose()):
        track = scene(motion).track(np.zeros(1), size[0] / size[1])
        matrices = np.diag([1.0, -1, 1, 1]) @ track.projection(size[0] / size[1]) @ track.views()
        points = extent.outline(SMPL22, motion.positions, motion.global_rotations)
        discs = extent.project(points, extent.reach(body), matrices, track.fov, size)
        boxes, strips = extent.bands(*discs, size)
        vertices = body.posed(motion)
        clip = np.c_[vertices, np.ones(len(vertices))] @ matrices[0].T
        pixels = (clip[:, :2] / clip[:, 3:] + 1) / 2 * size
        left, top, right, bottom = np.moveaxis(strips[0][:, :, None], 1, 0)
        x, y = pixels.T
        inside = (x >= left) & (x <= right) & (y >= top) & (y <= bottom)
        assert inside.any(0).all()
        assert boxes[0, 2] <= size[0] and boxes[0, 3] <= size[1]
        assert ((strips[0][:, 2] - strips[0][:, 0]) * (strips[0][:, 3] - strips[0][:, 1])).sum() < 0.75 * 320 * 240


def test_a_frame_of_a_video_is_the_still_of_its_time(renderer: Renderer) -> None:
    walk = scene(poses.stride(20), Camera("follow"))
    frames = list(renderer.frames(walk, 30.0))
    assert len(frames) == 30
    for moment in (0, 7, 29):
        still = renderer.frame(walk, moment / 30.0)
        apart = np.abs(frames[moment].astype(int) - still)
        assert apart.max() <= 12 and apart.mean() < 0.6, "only grain and the shadow's sampling may differ"
    assert np.abs(frames[0].astype(int) - frames[7]).max() > 50


def test_a_still_camera_keeps_its_backdrop_and_nothing_else(renderer: Renderer) -> None:
    walk = scene(poses.stride(12), Camera("left"))
    frames = list(renderer.frames(walk, 20.0))
    for moment in (1, 4, 11):
        still = renderer.frame(walk, moment / 20.0)
        apart = np.abs(frames[moment].astype(int) - still)
        assert apart.max() <= 12 and apart.mean() < 0.6
    other = renderer.frame(walk.replaced(backdrop="light"), 0.0)
    assert other.mean() > frames[0].mean() + 60


def test_pictures_stay_valid_while_later_ones_are_drawn(renderer: Renderer) -> None:
    walk = scene(poses.stride(12), Camera("left"))
    held = []
    for picture in renderer.pictures(walk, walk.times(20.0)):
        held.append((picture, picture.copy()))
        assert all((view == copy).all() for view, copy in held[-4:])


def test_figures_below_the_floor_are_hidden_by_it(renderer: Renderer) -> None:
    camera = Camera("orbit", distance=4.0, target=(0.0, 0.8, 0.0), pitch=0.15)
    sunk = scene(poses.stand().moved((0, -0.1, 0)), camera)
    seen = np.abs(renderer.frame(sunk).astype(int) - renderer.frame(sunk.replaced(floor=False))).max(-1) > 40
    assert seen[90:].any(), "without a floor the shoes are seen"
    assert not seen[:60].any()


def test_a_camera_close_up_sees_no_holes(renderer: Renderer) -> None:
    """Faces cut off by the edges of the view keep their colours (a driver once painted them black)."""
    neck = poses.t_pose().positions[0, SMPL22.index("neck")]
    for yaw in (-0.5, 0.6, 2.0):
        camera = Camera("orbit", yaw=yaw, pitch=0.25, target=tuple(neck), distance=0.6, fov=0.5)
        picture = renderer.frame(scene(poses.t_pose(), camera))
        assert picture.max(-1).min() > 12


def test_ghosts_are_fainter_than_the_figure_and_behind_it(renderer: Renderer) -> None:
    motion = poses.stride(24, speed=3.0)
    camera = Camera("left", distance=6.0, target=(0.0, 0.9, 1.8))
    plain = renderer.frame(scene(motion, camera), 1.1).astype(int)
    ghosts = renderer.frame(scene(motion, camera, ghosts=8), 1.1).astype(int)
    changed = np.abs(plain - ghosts).max(-1) > 12
    assert 0.01 < changed.mean() < 0.3
    assert not changed[:, :40].any(), "ghosts stand where the figure was, not where it will be"


def test_a_colour_changes_the_clothes(renderer: Renderer) -> None:
    plain = renderer.frame(scene(poses.stand()))
    red = renderer.frame(scene(poses.stand(), colour="#ff2010"))
    assert (red[..., 0].astype(int) - plain[..., 0] > 60).mean() > 0.01


def test_text_stands_under_an_actor(renderer: Renderer) -> None:
    apart = renderer.frame(scene(poses.stand(), label="Take 2")).astype(int) - renderer.frame(scene(poses.stand()))
    rows, columns = np.nonzero(np.abs(apart).max(-1) > 40)
    assert len(rows) and rows.min() > 80 and abs(columns.mean() - 80) < 20


@pytest.mark.parametrize("samples", [1, 2, 4])
def test_any_number_of_samples_draws_the_same_figure(samples: int) -> None:
    with Renderer(80, 61, samples) as small:
        picture = small.frame(scene(poses.stand(), ghosts=3, show="both"))
    assert picture.shape == (61, 80, 3)
    assert np.ptp(picture) > 120


def test_a_single_joint_and_a_snake_can_be_drawn(renderer: Renderer) -> None:
    for count in (1, 3, 100):
        offsets = np.tile([0.0, 1.2 / count, 0.6 / count], (count, 1))
        parents = tuple(range(-1, count - 1))
        snake = Skeleton("snake", tuple(f"j{i}" for i in range(count)), parents, offsets)
        motion = Motion(snake, np.tile(rotations.IDENTITY, (2, count, 1)), np.tile([0, 0.5, 0], (2, 1)), 10.0)
        picture = renderer.frame(Scene.of(motion))
        assert (picture.max(-1) > 110).sum() > 15, f"{count} joints leave nothing to see"


def test_a_stretched_body_is_drawn_taller(renderer: Renderer) -> None:
    camera = Camera("front", distance=5.0, target=(0.0, 1.0, 0.0))
    tall = poses.stand().scale_bones({"*": 1.25})
    heights = []
    for motion in (poses.stand(), tall):
        skin = np.abs(renderer.frame(scene(motion, camera)).astype(int) - [214, 163, 132]).max(-1) < 60
        heights.append(np.flatnonzero(skin.any(1)).min())
    assert heights[1] < heights[0] - 5


def test_threads_draw_each_with_their_own_renderer() -> None:
    def work(yaw: float) -> np.ndarray:
        with Renderer(64, 48) as mine:
            return mine.frame(scene(poses.stand(), Camera("orbit", yaw=yaw)))

    with ThreadPoolExecutor(3) as pool:
        drawn = list(pool.map(work, [0.0, 1.0, 0.0, 1.0]))
    assert (drawn[0] == drawn[2]).all() and (drawn[1] == drawn[3]).all()
    assert np.abs(drawn[0].astype(int) - drawn[1]).max() > 50


def test_the_context_of_a_thread_that_ended_is_used_again() -> None:
    seen: list[object] = []

    def work() -> None:
        with Renderer(16, 16) as mine:
            mine.frame(scene(poses.stand()))
            seen.append(mine.graphics)

    for _ in range(3):
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
    assert seen[0] is seen[1] is seen[2]
    assert contexts.context() is not seen[0], "a living thread keeps its own"


def test_a_renderer_of_another_thread_is_refused(renderer: Renderer) -> None:
    caught: list[BaseException] = []

    def misuse() -> None:
        try:
            renderer.frame(scene(poses.stand()))
        except MotionloomError as problem:
            caught.append(problem)

    thread = threading.Thread(target=misuse)
    thread.start()
    thread.join()
    assert len(caught) == 1 and "thread" in str(caught[0])


def test_renderers_of_one_thread_share_their_context_and_bodies(renderer: Renderer) -> None:
    with Renderer(32, 32) as other:
        assert other.graphics is renderer.graphics
        renderer.frame(scene(poses.stand(), colour="#123456"))
        before = len(other.graphics.meshes)
        other.frame(scene(poses.stand(), colour="#123456"))
        assert len(other.graphics.meshes) == before


def test_bodies_no_longer_used_leave_the_gpu(renderer: Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    from viewers.gl import figures

    monkeypatch.setattr(figures, "MOST_MESHES", 3)
    pictures = [renderer.frame(scene(poses.stand(), colour=f"#{shade:02x}0000")) for shade in range(20, 220, 20)]
    monkeypatch.undo()
    again = renderer.frame(scene(poses.stand(), colour="#140000"))
    assert (again == pictures[0]).all(), "and come back when they are needed"


def test_without_opengl_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import moderngl

    tried = []

    def refuse(**options) -> None:
        tried.append(options.get("backend"))
        raise OSError("libEGL.so.1: cannot open shared object file")

    monkeypatch.setattr(moderngl, "create_context", refuse)
    with pytest.raises(contexts.NoGraphicsError, match=r"apt-get install libegl1 .*") as error:
        contexts.open_context()
    assert tried[0] == "egl" and tried[-1] is None, "EGL first, the window system last"
    assert "libEGL.so.1" in str(error.value)


@pytest.mark.parametrize(("size", "samples"), [((0, 10), 4), ((10, 99999), 4), ((10, 10), 3)])
def test_sizes_that_cannot_be_are_refused(size: tuple[int, int], samples: int) -> None:
    with pytest.raises(OutOfRangeError, match="accepted"):
        Renderer(*size, samples)


def test_drawing_goes_on_after_another_library_shut_opengl_down() -> None:
    """VTK closes EGL's display with its windows, and every context of the process is lost with it."""
    pyvista = pytest.importorskip("pyvista")
    wanted = scene(poses.squat())
    with Renderer(*SIZE) as renderer:
        before, lost = renderer.frame(wanted), renderer.graphics
        for _ in range(2):
            plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
            plotter.add_mesh(pyvista.Sphere())
            plotter.screenshot(return_img=True)
            assert (renderer.frame(wanted) == before).all(), "while its window is there"
            plotter.close()
            assert (renderer.frame(wanted) == before).all(), "and when it is closed"
        if not lost.alive():
            assert renderer.graphics is not lost
            with renderer.staged(wanted, np.zeros(1)) as stage:
                renderer.graphics = lost
                with pytest.raises(MotionloomError, match="another library"):
                    renderer.draw(stage, 0)
            renderer.graphics = contexts.context()
