"""The pictures drawn into, and the way back from them to memory."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from viewers.gl.context import GraphicsContext, put

TILE = 128
"""Pixels along a side of one actor's shadow."""


CELL = (64, 16)
"""Pixels across and down of a cell of the net that carries the backdrop's colours; software rasterisers work in
blocks of such sizes."""
LEAST_CELLS = (12, 24)


@dataclass(eq=False)
class _Slot:
    """A picture that is kept while the same is asked for."""

    buffer: moderngl.Framebuffer
    key: object = None
    kept: bool = False

    def asked(self, key: object) -> bool:
        """Note what is asked for now; True if it should be kept once it is drawn."""
        again, self.key = key == self.key, key
        self.kept = self.kept and again
        return again and not self.kept


class Targets:
    """The figures' multisampled layer, the picture, the shadow atlas, and the planes of video frames."""

    def __init__(self, graphics: GraphicsContext, width: int, height: int, samples: int) -> None:
        gl = graphics.gl
        self.graphics, self.width, self.height, self.samples = graphics, width, height, samples
        self.layer: moderngl.Framebuffer | None = None
        self.layer_place = (0, 0)
        self._pictures = [gl.framebuffer([gl.texture((width, height), 4)]) for _ in range(2)]
        self._slots = [_Slot(gl.framebuffer([gl.texture((width, height), 4)])) for _ in range(2)]
        self._pending: list[_Slot] = []
        self._across = 0
        self._atlas: list[moderngl.Framebuffer] = []

    def screen(self, program: moderngl.Program) -> None:
        """Run a program over the whole current target."""
        self._array(program).render(moderngl.TRIANGLES, vertices=3)

    def net(self, program: moderngl.Program) -> None:
        """Run a program over the whole target, its vertices on a net."""
        cache, gl = self.graphics.cache, self.graphics.gl
        key = ("net", program, self.width, self.height)
        if key not in cache:
            across, down = (
                max(-(-size // cell), least) for size, cell, least in zip(key[2:], CELL, LEAST_CELLS, strict=True)
            )
            x, y = np.meshgrid(np.linspace(-1, 1, across + 1), np.linspace(-1, 1, down + 1))
            places = gl.buffer(np.stack([x, y], axis=-1).astype(np.float32).tobytes())
            number = np.arange(x.size).reshape(x.shape)
            a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
            index = gl.buffer(np.stack([a, b, c, b, d, c], axis=-1).astype(np.uint32).tobytes())
            cache[key] = gl.vertex_array(program, [(places, "2f", "in_place")], index)
        cache[key].render(moderngl.TRIANGLES)

    def strips(self, program: moderngl.Program, count: int) -> None:
        """Run a program on quads that know only their number."""
        self._array(program).render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)

    def quad(self, program: moderngl.Program) -> None:
        """Run a program on one quad that knows only its corners' numbers."""
        self._array(program).render(moderngl.TRIANGLE_STRIP, vertices=4)

    def show_picture(self) -> None:
        """Draw the picture, upright, over the whole current target."""
        program = self.graphics.program("screen", "upright")
        self._image(self.picture).use(0)
        self.screen(program)

    def draw_patch(self, program: moderngl.Program) -> None:
        """Draw a quad of floor that shows a tile of the atlas."""
        self._image(self._atlas[0]).use(0)
        self._array(program).render(moderngl.TRIANGLE_STRIP, vertices=4)

    # ---- the figures' layer ---------------------------------------------------------------------------------------

    def open_layer(self, box: tuple[int, int, int, int], largest: tuple[int, int]) -> None:
        """Clear the layer for figures within a box of the picture (left, top, width, height) and make it the target.

        The layer is only as large as the boxes of a stage (`largest`), since clearing samples costs time.
        """
        gl = self.graphics.gl
        if self.layer is None or self.layer.width < largest[0] or self.layer.height < largest[1]:
            self._close_layer()
            size = (min(-(-largest[0] // 64) * 64, self.width), min(-(-largest[1] // 64) * 64, self.height))
            many = self.samples if self.samples > 1 else 0
            image, depth = gl.texture(size, 4, samples=many), gl.depth_renderbuffer(size, samples=many)
            self.layer = gl.framebuffer([image], depth)
        layer = self.layer
        layer.use()
        self.layer_place = (box[0], box[1])
        gl.viewport = (-box[0], -box[1], self.width, self.height)
        layer.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)

    def compose_layer(self, strips: np.ndarray) -> None:
        """Lay the figures over strips (BANDS, 4) of the picture (left, top, right, bottom), samples averaged."""
        assert self.layer is not None
        many = {"SAMPLES": self.samples} if self.samples > 1 else {}
        program = self.graphics.program("strips", "layer" if many else "layer_single", **many)
        places = strips.reshape(-1, 2) / np.array([self.width, self.height]) * 2 - 1
        put(program, corner=self.layer_place, strips=[tuple(strip) for strip in places.reshape(-1, 4).tolist()])
        self._image(self.layer).use(0)
        self.strips(program, len(strips))

    def _close_layer(self) -> None:
        if self.layer is not None:
            depth = self.layer.depth_attachment
            for part in (self._image(self.layer), depth, self.layer):
                if part is not None:
                    part.release()
            self.layer = None

    # ---- the backdrop, kept while it stays the same ---------------------------------------------------------------

    def keep_backdrop(self, light: object, lines: object) -> tuple[bool, bool]:
        """Make the picture the target, with as much of the backdrop in it as was kept.

        What is asked for twice in a row is kept; what is asked for once costs nothing extra.

        Args:
            light: key of sky and floor: the same while the camera only goes along.
            lines: key of all with the floor's lines: the same while the camera stands still.

        Returns:
            Are sky and floor there; are the lines there too.
        """
        self._pending = [slot for slot, key in zip(self._slots, (light, lines), strict=True) if slot.asked(key)]
        self.picture.use()
        self.graphics.gl.viewport = (0, 0, self.width, self.height)
        kept = [slot.kept for slot in self._slots]
        if any(kept):
            self.graphics.gl.copy_framebuffer(self.picture, self._slots[kept[1]].buffer)
            self.picture.use()
        return any(kept), kept[1]

    def empty_backdrop(self) -> None:
        """Make the picture the target, with nothing in it."""
        self.keep_backdrop(object(), object())
        self.picture.clear(0.0, 0.0, 0.0, 0.0)

    def backdrop_drawn(self, lines: bool) -> None:
        """Called when sky and floor are in the picture, and again when the `lines` are: keep it if it was asked."""
        slot = self._slots[lines]
        if slot in self._pending:
            self.graphics.gl.copy_framebuffer(slot.buffer, self.picture)
            self.picture.use()
            slot.kept = True

    # ---- shadows ----------------------------------------------------------------------------------------------

    def open_atlas(self, tiles: int) -> None:
        """Clear the atlas and make it the target; it grows to hold that many tiles."""
        across = int(np.ceil(np.sqrt(max(tiles, 1))))
        if across > self._across:
            self._free(self._atlas)
            gl, side = self.graphics.gl, across * TILE
            self._atlas = [gl.framebuffer([gl.texture((side, side), 2)]) for _ in range(2)]
            self._across = across
        self._atlas[0].use()
        self._atlas[0].clear()

    def tile(self, index: int) -> tuple[int, int, int, int]:
        """Viewport of one tile."""
        return (index % self._across * TILE, index // self._across * TILE, TILE, TILE)

    def tile_place(self, index: int) -> tuple[float, float, float, float]:
        """Corner and size of one tile in texture coordinates."""
        side = 1.0 / self._across
        return (index % self._across * side, index // self._across * side, side, side)

    def blur_atlas(self) -> None:
        """Soften the shadows, across and then along."""
        program = self.graphics.program("screen", "blur")
        texel = 1.0 / (self._across * TILE)
        for here, there, step in ((0, 1, (texel, 0.0)), (1, 0, (0.0, texel))):
            self._atlas[there].use()
            self.graphics.gl.viewport = (0, 0, self._across * TILE, self._across * TILE)
            self._image(self._atlas[here]).use(0)
            put(program, step_size=step)
            self.screen(program)

    # ---- reading ------------------------------------------------------------------------------------------------

    @property
    def picture(self) -> moderngl.Framebuffer:
        """What is being drawn."""
        return self._pictures[0]

    def next_picture(self) -> None:
        """Draw into the other picture from now on, so that the last can be read meanwhile."""
        self._pictures.reverse()

    def read_rgb(self) -> np.ndarray:
        """(H, W, 3) uint8 copy of the picture."""
        return np.ascontiguousarray(self.read_into(np.empty((self.height, self.width, 4), np.uint8))[..., :3])

    def read_into(self, pixels: np.ndarray, previous: bool = False) -> np.ndarray:
        """Copy the picture, or the previous one, into (H, W, 4) uint8 `pixels`, and return them."""
        self._pictures[previous].read_into(pixels, components=4, alignment=1)
        return pixels

    def release(self) -> None:
        """Free everything."""
        self._close_layer()
        self._free(self._atlas)
        self._free(self._pictures)
        self._free([slot.buffer for slot in self._slots])

    # ---- helpers --------------------------------------------------------------------------------------------------

    def _array(self, program: moderngl.Program) -> moderngl.VertexArray:
        cache = self.graphics.cache
        if program not in cache:
            cache[program] = self.graphics.gl.vertex_array(program, [])
        return cache[program]

    @staticmethod
    def _image(buffer: moderngl.Framebuffer) -> moderngl.Texture:
        image = buffer.color_attachments[0]
        assert isinstance(image, moderngl.Texture)
        return image

    def _free(self, buffers: list[moderngl.Framebuffer]) -> None:
        for buffer in buffers:
            self._image(buffer).release()
            buffer.release()
        buffers.clear()
