"""Pictures of a Scene by OpenGL, with no window: stills, thumbnails, the frames of a video."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np

from engines.errors import MotionloomError, OutOfRangeError
from engines.motion import Motion
from viewers.camera import CameraTrack
from viewers.gl import stage as staging
from viewers.gl.context import GraphicsContext, context, put
from viewers.gl.stage import Figure, Stage
from viewers.gl.targets import Targets
from viewers.scene import Scene, hex_to_rgb, thumbnail

LARGEST = 8192
"""Longest side of a picture, pixels."""
RING = 6
"""Pictures of a video kept in memory at a time: those that wait for the encoder, and those at work."""
MOST_LINES = 60
"""Floor lines on either side of the middle, at most."""
_COVERAGE, _ALPHA_TO_ONE, _CLIP = 0x809E, 0x809F, 0x3000  # OpenGL's names for these switches


class Renderer:
    """Draws scenes into pictures of one size. Use it in the thread that made it; threads do not share pictures.

    All renderers of one thread share one OpenGL context and the bodies uploaded in it, so making one is cheap.
    Close it, or use it in a `with` block, to give its pictures' memory back.

    Args:
        width: of its pictures, pixels.
        height: likewise.
        samples: a pixel.
        graphics: a context of one's own (a window's), in place of this thread's.

    Raises:
        OutOfRangeError: a size or number of samples that cannot be.
        NoGraphicsError: no OpenGL here; the message says what to install.
    """

    def __init__(self, width: int, height: int, samples: int = 4, graphics: GraphicsContext | None = None) -> None:
        for name, value in (("width", width), ("height", height)):
            if not 1 <= value <= LARGEST:
                raise OutOfRangeError(name, value, f"1 to {LARGEST} pixels")
        if samples not in (1, 2, 4, 8):
            raise OutOfRangeError("samples", samples, "1, 2, 4 or 8 a pixel")
        self.width, self.height = int(width), int(height)
        self.graphics: GraphicsContext = graphics or context()
        self.samples = min(samples, self.graphics.gl.max_samples) if samples > 1 else 1
        self.targets = Targets(self.graphics, self.width, self.height, self.samples)

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the pictures. The context stays for other renderers of this thread."""
        if self.graphics.take_up():
            self.targets.release()

    # ---- pictures ---------------------------------------------------------------------------------------------

    def frame(self, scene: Scene, t: float = 0.0) -> np.ndarray:
        """(H, W, 3) uint8 sRGB picture of the scene at `t` seconds; (H, W, 4) with alpha if it is transparent."""
        with self.staged(scene, np.array([float(t)])) as stage:
            self.draw(stage, 0)
            if scene.transparent:
                return straight(self.targets.read_into(self._empty()))
            return self.targets.read_rgb()

    def frames(self, scene: Scene, fps: float = 30.0) -> Iterator[np.ndarray]:
        """(H, W, 3) uint8 pictures of the whole scene at `fps`; poses between the motion's own frames are slerped.

        A transparent scene gives (H, W, 4), colours not multiplied by alpha.
        """
        for picture in self.pictures(scene, scene.times(fps)):
            yield picture.copy() if scene.transparent else np.ascontiguousarray(picture[..., :3])

    def pictures(self, scene: Scene, times: np.ndarray) -> Iterator[np.ndarray]:
        """(H, W, 4) uint8 pictures at `times` (N,) seconds, each valid until RING - 1 more were asked for.

        A picture is read back while the next is being drawn. Alpha is 255 unless the scene is transparent.
        """
        finished = straight if scene.transparent else np.asarray
        ring = [self._empty() for _ in range(min(RING, len(times)))]
        with self.staged(scene, times) as stage:
            for moment in range(len(times)):
                self.targets.next_picture()
                self.draw(stage, moment)
                if moment:
                    yield finished(self.targets.read_into(ring[(moment - 1) % len(ring)], previous=True))
            self._take_up()
            yield finished(self.targets.read_into(ring[(len(times) - 1) % len(ring)]))

    def thumbnail(self, motion: Motion, **options) -> np.ndarray:
        """(H, W, 3) uint8 still of the motion's most telling frame; options as `scene.thumbnail`."""
        return self.frame(thumbnail(motion, **options))

    def staged(self, scene: Scene, times: np.ndarray, track: CameraTrack | None = None) -> _Staged:
        """The scene made ready for `times` (N,) seconds: `with ... as stage: renderer.draw(stage, i)`.

        Args:
            scene: the scene.
            times: (N,) seconds.
            track: the camera at these times, in place of the scene's own.
        """
        self._check_thread()
        if not self.graphics.alive():
            self.graphics = context()
            self.targets = Targets(self.graphics, self.width, self.height, self.samples)
        return _Staged(self.graphics, staging.build(self.graphics, scene, times, (self.width, self.height), track))

    # ---- one picture, pass by pass ----------------------------------------------------------------------------

    def draw(self, stage: Stage, moment: int) -> None:
        """Draw one moment of a stage into `targets.picture`."""
        self._take_up()
        matrix = stage.view_projections[moment]
        self._figures(stage, moment, matrix)
        if stage.scene.floor:
            self._shadow_atlas(stage, moment)
        gl = self.graphics.gl
        gl.disable(gl.DEPTH_TEST | gl.BLEND | gl.CULL_FACE)
        self._backdrop(stage, moment, matrix)
        gl.enable(gl.BLEND)
        gl.blend_func = _over(gl)
        if stage.scene.floor:
            self._floor_marks(stage, moment, matrix)
        gl.blend_func = gl.ONE, gl.ONE_MINUS_SRC_ALPHA
        self.targets.compose_layer(stage.strips[moment])
        gl.blend_func = _over(gl)
        self._labels(stage, moment, matrix)

    def _figures(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        """The bodies and their ghosts, on their own multisampled layer, within the box they may touch."""
        gl = self.graphics.gl
        self.targets.open_layer(tuple(stage.boxes[moment]), stage.largest_box)
        gl.enable_only(gl.DEPTH_TEST | gl.CULL_FACE)
        gl.front_face = "cw"  # the picture is drawn upside down
        gl.enable_direct(_CLIP)
        for program in {figure.mesh.program for figure in stage.figures}:
            self._set_light(program, stage, moment, matrix)
        for figure, height in zip(stage.figures, stage.heights[moment], strict=True):
            self._draw_figure(figure, moment, float(height))
        gl.disable_direct(_CLIP)

    def _set_light(self, program: moderngl.Program, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        light = stage.scene.light
        put(
            program,
            view_projection=matrix,
            floor_clip=stage.floor_clip,
            eye=stage.track.eye[moment],
            key_direction=light.direction,
            key_light=np.array([0.86, 0.81, 0.74]) * light.key,
            sky_light=np.array([0.40, 0.44, 0.51]) * light.sky,
            ground_light=np.array([0.17, 0.165, 0.17]) * light.sky,
            faded=np.square(hex_to_rgb(stage.scene.colours.centre)),
        )

    def _draw_figure(self, figure: Figure, moment: int, height: float) -> None:
        array, faint = figure.mesh.level(height), figure.mesh.level(0.3 * height)
        program = figure.mesh.program
        if figure.mesh.texture is not None:
            figure.mesh.texture.use(0)
        if figure.ghost_poses is not None:
            for ghost in figure.ghosts[moment]:
                self._see_through(ghost.alpha)
                put(program, alpha=ghost.alpha, fade=ghost.fade)
                figure.ghost_poses.bind(ghost.pose)
                faint.render()
        self._see_through(figure.alpha)
        put(program, alpha=figure.alpha, fade=0.0)
        figure.poses.bind(moment)
        array.render()
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
        gl.enable_only(gl.BLEND | gl.CULL_FACE)  # what faces the light casts the whole shadow
        gl.front_face = "cw"  # seen from above, x right and z up the tile is a mirrored view
        gl.blend_equation = gl.MAX, gl.MAX
        gl.blend_func = gl.ONE, gl.ONE
        light = stage.scene.light.direction
        for tile, index in enumerate(casting):
            figure = stage.figures[index]
            put(figure.mesh.flat.program, patch_area=stage.shadow_areas[moment, index], slant=light[[0, 2]] / light[1])
            gl.viewport = targets.tile(tile)
            figure.poses.bind(moment)
            figure.mesh.flat.render()
        gl.blend_equation = gl.FUNC_ADD, gl.FUNC_ADD
        gl.disable(gl.BLEND | gl.CULL_FACE)
        targets.blur_atlas()

    def _backdrop(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        """Sky, floor and its lines: all kept while the camera stands still, but for the lines while it goes along."""
        if stage.scene.transparent:
            self.targets.empty_backdrop()
            return
        eye, target = stage.track.eye[moment], stage.track.target[moment]
        arm, scene = np.round(eye - target, 6), stage.scene
        grain = {"GRAIN": 1} if len(stage.times) == 1 else {}  # an encoder would only wash grain out again
        light = (scene.colours, scene.floor, stage.track.fov, arm.tobytes(), round(float(eye[1]), 6), len(grain))
        there, lines = self.targets.keep_backdrop(light, (*light, eye.tobytes()))
        reach = staging.floor_reach(float(np.linalg.norm(arm)))
        if not there:
            self._sky_and_floor(stage, moment, matrix, self.graphics.program("backdrop", "backdrop", **grain))
            self.targets.backdrop_drawn(lines=False)
        if not lines:
            if scene.floor and eye[1] > 0:
                self._grid(stage, moment, matrix, reach)
            self.targets.backdrop_drawn(lines=True)

    def _sky_and_floor(self, stage: Stage, moment: int, matrix: np.ndarray, program: moderngl.Program) -> None:
        eye, target, colours = stage.track.eye[moment], stage.track.target[moment], stage.scene.colours
        around = np.eye(4)
        around[:3, 3] = eye
        reach = staging.floor_reach(float(np.linalg.norm(eye - target)))
        put(
            program,
            unproject=np.linalg.inv(matrix @ around),
            eye=eye,
            focus=target[[0, 2]],
            reach=reach**-2 if stage.scene.floor else 0.0,
            aspect=self.width / self.height,
            centre=hex_to_rgb(colours.centre),
            edge=hex_to_rgb(colours.edge),
            ground=hex_to_rgb(colours.floor),
        )
        self.targets.net(program)

    def _grid(self, stage: Stage, moment: int, matrix: np.ndarray, reach: float) -> None:
        gl, program = self.graphics.gl, self.graphics.program("grid", "grid")
        count = int(min(np.ceil(reach), MOST_LINES))
        pieces = max(8, 2 * count // 3)
        put(
            program,
            view_projection=matrix,
            focus=stage.track.target[moment, [0, 2]],
            reach=reach**-2,
            count=count,
            pieces=pieces,
            size=(float(self.width), float(self.height)),
            near=stage.track.near,
            lines=hex_to_rgb(stage.scene.colours.grid),
        )
        gl.enable(gl.BLEND)
        gl.blend_func = _over(gl)
        self.targets.strips(program, 2 * (2 * count + 1) * pieces)
        gl.disable(gl.BLEND)

    def _floor_marks(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        patch = self.graphics.program("patch", "patch")
        casting = [i for i, figure in enumerate(stage.figures) if figure.casts_shadow]
        for tile, index in enumerate(casting):
            area = stage.shadow_areas[moment, index]
            put(patch, view_projection=matrix, patch_area=area, tile=self.targets.tile_place(tile), strength=1.0)
            self.targets.draw_patch(patch)
        for marks in stage.marks:
            put(
                marks.program,
                view_projection=matrix,
                now=stage.times[moment],
                opacity=marks.opacity,
                least=marks.least,
                pixel=2 * np.tan(stage.track.fov / 2) / self.height,
                colour=marks.colour,
            )
            marks.draw()

    def _labels(self, stage: Stage, moment: int, matrix: np.ndarray) -> None:
        if stage.labels:
            put(self.graphics.program("label", "label"), colour=hex_to_rgb(stage.scene.colours.ink))
        for label in stage.labels:
            label.draw(moment, matrix)

    def _empty(self) -> np.ndarray:
        return np.empty((self.height, self.width, 4), np.uint8)

    def _check_thread(self) -> None:
        if threading.get_ident() != self.graphics.thread:
            raise MotionloomError(
                "a Renderer was used in another thread than the one that made it; OpenGL contexts belong to one "
                "thread, so make a Renderer in each thread that draws."
            )

    def _take_up(self) -> None:
        self._check_thread()
        if not self.graphics.take_up():
            raise MotionloomError(
                "another library (PyVista?) shut OpenGL down while a scene was being drawn; draw it again, and close "
                "that library's windows before or after."
            )


def _over(gl: moderngl.Context) -> Any:  # four numbers; moderngl's annotation knows two
    """Blending of something see-through over a picture, whose alpha grows by it."""
    return gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA


def straight(picture: np.ndarray) -> np.ndarray:
    """Divide the colours of a picture (H, W, 4) uint8 by its alpha, in place, as PNG and WebM hold them."""
    pixels = picture.reshape(-1, 4)
    edges = np.flatnonzero((pixels[:, 3] > 0) & (pixels[:, 3] < 255))
    few = pixels[edges].astype(np.uint16)
    pixels[edges, :3] = np.minimum((few[:, :3] * 255 + few[:, 3:] // 2) // few[:, 3:], 255)
    return picture


class _Staged:
    """A stage that gives its memory back at the end of the block."""

    def __init__(self, graphics: GraphicsContext, stage: Stage) -> None:
        self._graphics, self._stage = graphics, stage

    def __enter__(self) -> Stage:
        return self._stage

    def __exit__(self, *_: object) -> None:
        if self._graphics.take_up():
            self._stage.release()
