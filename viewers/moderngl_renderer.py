"""Pictures of a Scene by OpenGL, with no window: stills, thumbnails, the frames of a video."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import moderngl
import numpy as np

from engines.errors import MotionloomError, OutOfRangeError
from engines.motion import Motion
from viewers.gl import stage as staging
from viewers.gl.context import GraphicsContext, context
from viewers.gl.stage import Figure, Stage
from viewers.gl.targets import Targets
from viewers.scene import Scene, hex_to_rgb, thumbnail

LARGEST = 8192
"""Longest side of a picture, pixels."""
_COVERAGE, _ALPHA_TO_ONE, _CLIP = 0x809E, 0x809F, 0x3000  # OpenGL's names for these switches


class Renderer:
    """Draws scenes into pictures of one size. Use it in the thread that made it; threads do not share pictures.

    All renderers of one thread share one OpenGL context and the bodies uploaded in it, so making one is cheap.
    Close it, or use it in a `with` block, to give its pictures' memory back.

    Raises:
        OutOfRangeError: a size or number of samples that cannot be.
        NoGraphicsError: no OpenGL here; the message says what to install.
    """

    def __init__(self, width: int, height: int, samples: int = 4) -> None:
        for name, value in (("width", width), ("height", height)):
            if not 1 <= value <= LARGEST:
                raise OutOfRangeError(name, value, f"1 to {LARGEST} pixels")
        if samples not in (1, 2, 4, 8):
            raise OutOfRangeError("samples", samples, "1, 2, 4 or 8 a pixel")
        self.width, self.height = int(width), int(height)
        self.graphics: GraphicsContext = context()
        self.samples = min(samples, self.graphics.gl.max_samples) if samples > 1 else 1
        self.targets = Targets(self.graphics, self.width, self.height, self.samples)

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the pictures. The context stays for other renderers of this thread."""
        self.targets.release()

    # ---- pictures ---------------------------------------------------------------------------------------------

    def frame(self, scene: Scene, t: float = 0.0) -> np.ndarray:
        """(H, W, 3) uint8 sRGB picture of the scene at `t` seconds."""
        with self.staged(scene, np.array([float(t)])) as stage:
            self.draw(stage, 0)
            return self.targets.read_rgb()

    def frames(self, scene: Scene, fps: float = 30.0) -> Iterator[np.ndarray]:
        """(H, W, 3) uint8 pictures of the whole scene at `fps`; poses between the motion's own frames are slerped."""
        with self.staged(scene, scene.times(fps)) as stage:
            for moment in range(len(stage.times)):
                self.draw(stage, moment)
                yield self.targets.read_rgb()

    def thumbnail(self, motion: Motion, **options) -> np.ndarray:
        """(H, W, 3) uint8 still of the motion's most telling frame; options as `scene.thumbnail`."""
        return self.frame(thumbnail(motion, **options))

    def staged(self, scene: Scene, times: np.ndarray) -> _Staged:
        """The scene made ready for `times` (N,) seconds: `with renderer.staged(...) as stage: renderer.draw(stage, i)`."""
        self._check_thread()
        return _Staged(staging.build(self.graphics, scene, times, (self.width, self.height)))

    # ---- one picture, pass by pass ----------------------------------------------------------------------------

    def draw(self, stage: Stage, moment: int) -> None:
        """Draw one moment of a stage into `targets.picture`."""
        self._check_thread()
        matrix = stage.view_projections[moment]
        self._figures(stage, moment, matrix)
        if stage.scene.floor:
            self._shadow_atlas(stage, moment)
        gl = self.graphics.gl
        self.targets.picture.use()
        gl.viewport = (0, 0, self.width, self.height)
        gl.disable(gl.DEPTH_TEST | gl.BLEND | gl.CULL_FACE)
        self._backdrop(stage, moment, matrix)
        gl.enable(gl.BLEND)
        gl.blend_func = gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA
        if stage.scene.floor:
            self._floor_marks(stage, moment, matrix)
        gl.blend_func = gl.ONE, gl.ONE_MINUS_SRC_ALPHA
        self.targets.picture.scissor = tuple(stage.boxes[moment])
        self.targets.compose_layer()
        self.targets.picture.scissor = None
        gl.blend_func = gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA
        self._labels(stage, moment, matrix)

    def _figures(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        """The bodies and their ghosts, on their own multisampled layer, within the box they may touch."""
        gl, layer = self.graphics.gl, self.targets.layer
        layer.use()
        layer.scissor = tuple(stage.boxes[moment])
        layer.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)
        gl.enable_only(gl.DEPTH_TEST | gl.CULL_FACE)
        gl.front_face = "cw"  # the picture is drawn upside down
        gl.enable_direct(_CLIP)
        for rows in {figure.mesh.rows for figure in stage.figures}:
            self._set_light(self.graphics.program("figure", "figure", rows), stage, moment, matrix)
        for figure in stage.figures:
            self._draw_figure(figure, moment)
        gl.disable_direct(_CLIP)
        layer.scissor = None

    def _set_light(self, program: moderngl.Program, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        light, colours = stage.scene.light, stage.scene.colours
        program["view_projection"].write(np.ascontiguousarray(matrix.T))
        program["floor_clip"].value = stage.floor_clip
        program["eye"].value = tuple(stage.track.eye[moment])
        program["key_direction"].value = tuple(light.direction)
        program["key_light"].value = tuple(np.array([0.86, 0.81, 0.74]) * light.key)
        program["sky_light"].value = tuple(np.array([0.40, 0.44, 0.51]) * light.sky)
        program["ground_light"].value = tuple(np.array([0.17, 0.165, 0.17]) * light.sky)
        program["fade"].value = (*np.square(hex_to_rgb(colours.centre)), 0.0)

    def _draw_figure(self, figure: Figure, moment: int) -> None:
        program = figure.mesh.shaded.program
        faded = program["fade"].value[:3]
        ghosts = figure.ghosts[moment] if figure.ghosts else ()
        for pose, alpha, fade, poses in [
            *((ghost.pose, ghost.alpha, ghost.fade, figure.ghost_poses) for ghost in ghosts),
            (moment, figure.alpha, 0.0, figure.poses),
        ]:
            self._see_through(alpha)
            program["alpha"].value = alpha
            program["fade"].value = (*faded, fade)
            poses.bind(pose)
            figure.mesh.shaded.render()
        self._see_through(1.0)

    def _see_through(self, alpha: float) -> None:
        """Let a figure cover only a share of each pixel's samples: no sorting, and never two layers of one body."""
        switch = self.graphics.gl.enable_direct if alpha < 1 and self.samples > 1 else self.graphics.gl.disable_direct
        switch(_COVERAGE)
        switch(_ALPHA_TO_ONE)

    def _shadow_atlas(self, stage: Stage, moment: int) -> None:
        gl, targets = self.graphics.gl, self.targets
        casting = [i for i, figure in enumerate(stage.figures) if figure.casts_shadow]
        targets.open_atlas(len(casting))
        gl.enable_only(gl.BLEND)
        gl.blend_equation = gl.MAX
        gl.blend_func = gl.ONE, gl.ONE
        light = stage.scene.light.direction
        for tile, index in enumerate(casting):
            figure = stage.figures[index]
            program = figure.mesh.flat.program
            program["patch_area"].value = tuple(stage.shadow_areas[moment, index])
            program["slant"].value = (light[0] / light[1], light[2] / light[1])
            gl.viewport = targets.tile(tile)
            figure.poses.bind(moment)
            figure.mesh.flat.render()
        gl.blend_equation = gl.FUNC_ADD
        gl.disable(gl.BLEND)
        targets.blur_atlas()

    def _backdrop(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        program = self.graphics.program("backdrop", "backdrop")
        colours, target = stage.scene.colours, stage.track.target[moment]
        around = np.eye(4)
        around[:3, 3] = stage.track.eye[moment]
        program["unproject"].write(np.ascontiguousarray(np.linalg.inv(matrix @ around).T, np.float32))
        program["eye"].value = tuple(stage.track.eye[moment])
        program["focus"].value = (target[0], target[2])
        program["reach"].value = 2.0 + 1.1 * float(np.linalg.norm(stage.track.eye[moment] - target))
        program["aspect"].value = self.width / self.height
        program["has_floor"].value = float(stage.scene.floor)
        for name, colour in (("centre", colours.centre), ("edge", colours.edge), ("ground", colours.floor)):
            program[name].value = hex_to_rgb(colour)
        program["lines"].value = hex_to_rgb(colours.grid)
        self.targets.screen(program)

    def _floor_marks(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        patch = self.graphics.program("patch", "patch")
        patch["view_projection"].write(np.ascontiguousarray(matrix.T))
        patch["strength"].value = 1.0
        casting = [i for i, figure in enumerate(stage.figures) if figure.casts_shadow]
        for tile, index in enumerate(casting):
            patch["patch_area"].value = tuple(stage.shadow_areas[moment, index])
            patch["tile"].value = self.targets.tile_place(tile)
            self.targets.draw_patch(patch)
        for marks in stage.marks:
            program = marks.program
            program["view_projection"].write(np.ascontiguousarray(matrix.T))
            program["now"].value = float(stage.times[moment])
            program["opacity"].value = marks.opacity
            program["least"].value = marks.least
            program["pixel"].value = 2 * float(np.tan(stage.track.fov / 2)) / self.height
            program["colour"].value = marks.colour
            marks.draw()

    def _labels(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        if stage.labels:
            self.graphics.program("label", "label")["colour"].value = hex_to_rgb(stage.scene.colours.ink)
        for label in stage.labels:
            label.draw(moment, matrix)

    def _check_thread(self) -> None:
        if threading.get_ident() != self.graphics.thread:
            raise MotionloomError(
                "a Renderer was used in another thread than the one that made it; OpenGL contexts belong to one "
                "thread, so make a Renderer in each thread that draws."
            )


class _Staged:
    """A stage that gives its memory back at the end of the block."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def __enter__(self) -> Stage:
        return self._stage

    def __exit__(self, *_: object) -> None:
        self._stage.release()
