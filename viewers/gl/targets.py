"""The pictures drawn into, and the way back from them to memory."""

from __future__ import annotations

import moderngl
import numpy as np

from viewers.gl.context import GraphicsContext

TILE = 192
"""Pixels along a side of one actor's shadow."""


class Targets:
    """The figures' multisampled layer, the picture, the shadow atlas, and the planes of video frames."""

    def __init__(self, graphics: GraphicsContext, width: int, height: int, samples: int) -> None:
        gl = graphics.gl
        self.graphics, self.width, self.height, self.samples = graphics, width, height, samples
        many = samples if samples > 1 else 0
        self._layer_image = gl.texture((width, height), 4, samples=many)
        depth = gl.depth_renderbuffer((width, height), samples=many)
        self.layer = gl.framebuffer([self._layer_image], depth)
        self._picture_image = gl.texture((width, height), 4)
        self.picture = gl.framebuffer([self._picture_image])
        self._owned = [self.layer, depth, self._layer_image, self.picture, self._picture_image]
        self._across = 0
        self._atlas: list[moderngl.Framebuffer] = []
        self._planes: list[moderngl.Framebuffer] = []

    def screen(self, program: moderngl.Program) -> None:
        """Run a program over the whole current target."""
        self._array(program).render(moderngl.TRIANGLES, vertices=3)

    def draw_patch(self, program: moderngl.Program) -> None:
        """Draw a quad of floor that shows a tile of the atlas."""
        self._image(self._atlas[0]).use(0)
        self._array(program).render(moderngl.TRIANGLE_STRIP, vertices=4)

    def compose_layer(self) -> None:
        """Lay the figures over the picture, samples averaged."""
        program = self.graphics.program("screen", "layer" if self.samples > 1 else "layer_single")
        if self.samples > 1:
            program["samples"].value = self.samples
        self._layer_image.use(0)
        self.screen(program)

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
            program["step_size"].value = step
            self.screen(program)

    # ---- reading ------------------------------------------------------------------------------------------------

    def read_rgb(self) -> np.ndarray:
        """(H, W, 3) uint8 copy of the picture."""
        pixels = np.frombuffer(self.picture.read(components=4, alignment=1), np.uint8)
        return np.ascontiguousarray(pixels.reshape(self.height, self.width, 4)[..., :3])

    def release(self) -> None:
        """Free everything."""
        self._free(self._atlas)
        self._free(self._planes)
        for part in self._owned:
            part.release()
        self._owned = []

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
