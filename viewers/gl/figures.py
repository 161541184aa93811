"""Bodies on the GPU: a mesh once, and the joint matrices of a whole clip in one buffer, bound a range a frame."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from engines.errors import OutOfRangeError
from viewers.bodies.body import Body, eight_bit_weights
from viewers.gl.context import GraphicsContext

LEVEL_HEIGHTS = (900, 190)
"""Figures less tall than this many pixels are drawn with the second, the third level of their body."""
MOST_MESHES = 96
"""Bodies kept uploaded in a context."""
_BLOCK = 64
"""Programs are compiled for multiples of so many joints, so that most skeletons share one."""
_LAYOUT = np.dtype(
    [("position", "<f4", 3), ("normal", "<f2", 4), ("joints", "<u2", 4), ("weights", "u1", 4), ("colour", "u1", 4)]
)
_FULL = ("3f 3f2 x2 4u2 4f1 4f1", ("in_position", "in_normal", "in_joints", "in_weights", "in_colour"))
_SHADOW = ("3f 4x2 4u2 4f1 4x1", ("in_position", "in_joints", "in_weights"))


@dataclass
class Mesh:
    """A body uploaded in one thread's context."""

    rows: int
    """Rows of joint matrices its programs expect."""
    shaded: list[moderngl.VertexArray]
    """Draw it in colour, the finest level first."""
    flat: moderngl.VertexArray
    """Draws its shadow, coarsely."""

    buffers: list[moderngl.Buffer]
    """What the arrays read."""
    texture: moderngl.Texture | None = None
    """What it is painted with, where its colours do not say."""

    @property
    def program(self) -> moderngl.Program:
        """The one that draws it in colour."""
        return self.shaded[0].program

    def release(self) -> None:
        """Free the memory on the GPU."""
        for part in (*self.shaded, self.flat, *self.buffers, *([self.texture] if self.texture else [])):
            part.release()

    def level(self, height: float) -> moderngl.VertexArray:
        """What to draw for a figure `height` pixels tall."""
        return self.shaded[sum(height < limit for limit in LEVEL_HEIGHTS[: len(self.shaded) - 1])]


def rows_for(joints: int) -> int:
    """Rows (three a joint) of the smallest program that holds so many joints."""
    return 3 * _BLOCK * -(-joints // _BLOCK)


def mesh(graphics: GraphicsContext, body: Body, colour: tuple[float, float, float] | None) -> Mesh:
    """The body in that colour, uploaded once per context.

    Raises:
        OutOfRangeError: more joints than the graphics driver has room for.
    """
    colour = colour if body.tint.any() else None  # else it would be the same once more
    key = (body, colour)  # bodies are told apart by identity
    held = graphics.meshes.pop(key, None) or _upload(graphics, body, colour)
    graphics.meshes[key] = held  # the latest used is the last
    if len(graphics.meshes) > MOST_MESHES:
        graphics.meshes.pop(next(iter(graphics.meshes))).release()
    return held


def _upload(graphics: GraphicsContext, body: Body, colour: tuple[float, float, float] | None) -> Mesh:
    rows = rows_for(len(body.skeleton))
    room = graphics.gl.info["GL_MAX_UNIFORM_BLOCK_SIZE"] // 48
    if rows * 16 > graphics.gl.info["GL_MAX_UNIFORM_BLOCK_SIZE"]:
        raise OutOfRangeError("number of joints", len(body.skeleton), f"at most {room - room % _BLOCK}")
    packed = np.zeros(len(body.vertices), _LAYOUT)
    packed["position"] = body.vertices
    packed["normal"][:, :3] = body.normals
    packed["joints"] = body.skin_indices
    packed["weights"] = eight_bit_weights(body.skin_weights)
    packed["colour"] = _paint(body, colour)
    buffer = graphics.gl.buffer(packed.tobytes())
    levels = [graphics.gl.buffer(faces.astype(np.uint32).tobytes()) for faces in (body.faces, *body.coarse)]
    content: list[tuple] = [(buffer, _FULL[0], *_FULL[1])]
    buffers, kind, texture = [buffer, *levels], {"ROWS": rows}, None
    if body.texture is not None and body.uv is not None:
        buffers.append(graphics.gl.buffer(body.uv.tobytes()))
        content.append((buffers[-1], "2f", "in_uv"))
        kind["TEXTURED"], texture = 1, _texture(graphics, body.texture)
    shaded = graphics.program("figure", "figure", **kind)
    flat = graphics.program("shadow", "shadow", ROWS=rows)
    for program in (shaded, flat):
        block = program["Pose"]
        assert isinstance(block, moderngl.UniformBlock)
        block.binding = 0
    return Mesh(
        rows,
        [graphics.gl.vertex_array(shaded, content, level) for level in levels],
        graphics.gl.vertex_array(flat, [(buffer, _SHADOW[0], *_SHADOW[1])], levels[-1]),
        buffers,
        texture,
    )


def _paint(body: Body, colour: tuple[float, float, float] | None) -> np.ndarray:
    """(V, 4) uint8 colours, and how much of a texture they cover."""
    made = np.zeros((len(body.vertices), 4), np.uint8)
    if body.texture is None:
        made[:, :3] = body.painted(colour)
    elif colour is not None:
        made[:, :3] = np.round(255 * np.array(colour))
        made[:, 3] = np.round(255 * body.tint)
    return made


def _texture(graphics: GraphicsContext, pixels: np.ndarray) -> moderngl.Texture:
    """A picture (h, w, 3) with smaller ones of itself; its first row is at v = 0, as uv has it."""
    height, width = pixels.shape[:2]
    made = graphics.gl.texture((width, height), 3, pixels.tobytes(), alignment=1)
    made.build_mipmaps()
    made.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    made.repeat_x = made.repeat_y = False
    return made


class Poses:
    """Joint matrices of N moments of one body, on the GPU."""

    def __init__(self, graphics: GraphicsContext, matrices: np.ndarray, rows: int) -> None:
        """Upload matrices (N, J, 3, 4) for programs that take `rows` rows."""
        count, joints = matrices.shape[:2]
        align = max(graphics.gl.info.get("GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT", 256), 16)
        self._stride = -(-joints * 48 // align) * align
        self._size = rows * 16
        data = np.zeros((count, self._stride // 4), np.float32)
        data[:, : joints * 12] = matrices.reshape(count, -1)
        tail = np.zeros(self._size, np.uint8)  # the last range must be as long as the block
        self._buffer = graphics.gl.buffer(data.tobytes() + tail.tobytes())

    def bind(self, moment: int) -> None:
        """Make programs read the matrices of one moment."""
        self._buffer.bind_to_uniform_block(0, offset=moment * self._stride, size=self._size)

    def release(self) -> None:
        """Free the memory on the GPU."""
        self._buffer.release()
