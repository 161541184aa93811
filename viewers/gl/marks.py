"""Flat marks on the floor (trails, foot prints) and text labels."""

from __future__ import annotations

from functools import lru_cache

import moderngl
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from viewers.gl.context import GraphicsContext, put
from viewers.marks import CONTACT_COLOUR, CONTACT_OPACITY, TRAIL_COLOUR, TRAIL_OPACITY, contact_prints, trail
from viewers.scene import Actor, hex_to_rgb, sample


class Marks:
    """Flat ellipses on the floor, each holding for a span of time."""

    def __init__(
        self,
        graphics: GraphicsContext,
        instances: np.ndarray,
        colour: str,
        opacity: tuple[float, float, float],
        least: float = 0.0,
    ) -> None:
        """Upload instances (M, 8): centre x z, direction x z, radii along and across, seconds from and to.

        Args:
            graphics: this thread's context.
            instances: the marks.
            colour: sRGB hex.
            opacity: before, during and after a mark's span.
            least: smallest radius in pixels.
        """
        self.colour, self.opacity, self.least, self.count = hex_to_rgb(colour), opacity, least, len(instances)
        program = graphics.program("marks", "marks")
        self._buffer = graphics.gl.buffer(np.ascontiguousarray(instances, np.float32).tobytes())
        layout = [(self._buffer, "2f 2f 2f 2f/i", "in_centre", "in_along", "in_radii", "in_span")]
        self._array = graphics.gl.vertex_array(program, layout)
        self.program = program

    def draw(self) -> None:
        """Draw all, with the program's uniforms as they are."""
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self.count)

    def release(self) -> None:
        """Free the memory on the GPU."""
        self._array.release()
        self._buffer.release()


def actor_marks(graphics: GraphicsContext, actor: Actor) -> list[Marks]:
    """The marks an actor leaves on the floor, in the order of drawing."""
    made = []
    if actor.trail:
        made.append(
            Marks(graphics, trail(actor.motion, actor.offset), actor.colour or TRAIL_COLOUR, TRAIL_OPACITY, 1.6)
        )
    if actor.contacts:
        prints = contact_prints(actor.motion, actor.offset)
        if len(prints):
            made.append(Marks(graphics, prints, CONTACT_COLOUR, CONTACT_OPACITY))
    return made


class Label:
    """Text that stands below an actor's feet."""

    def __init__(self, graphics: GraphicsContext, actor: Actor, times: np.ndarray, size: tuple[int, int]) -> None:
        picture = text_image(actor.label or "", max(10, round(size[1] / 34)))
        self.texture = graphics.gl.texture(
            (picture.shape[1], picture.shape[0]), 1, np.ascontiguousarray(picture).tobytes(), alignment=1
        )
        self.extent = np.array([picture.shape[1] / size[0], picture.shape[0] / size[1]]) * 2
        _, path = sample(actor.motion, times)
        self.anchors = (path + actor.motion.skeleton.offsets[0] + actor.offset) * [1, 0, 1]
        self._array = graphics.gl.vertex_array(graphics.program("label", "label"), [])

    def draw(self, moment: int, view_projection: np.ndarray) -> None:
        """Draw it under where the actor is at that moment."""
        clip = view_projection @ np.append(self.anchors[moment], 1.0)
        if clip[3] <= 0.05:
            return
        middle = clip[:2] / clip[3] + [0.0, 0.11]
        limit = 1.0 - self.extent[1] * 0.7
        corner = [middle[0] - self.extent[0] / 2, min(middle[1], limit) - self.extent[1] / 2]
        put(self._array.program, box=(*corner, *self.extent))
        self.texture.use(0)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4)

    def release(self) -> None:
        """Free the memory on the GPU."""
        self.texture.release()
        self._array.release()


@lru_cache(maxsize=128)
def text_image(text: str, height: int) -> np.ndarray:
    """(H, W) uint8 coverage of a line of text, letters about `height` pixels tall."""
    font = ImageFont.load_default(size=height)
    left, top, right, bottom = font.getbbox(text)
    image = Image.new("L", (int(right - left) + 4, int(bottom - top) + 4))
    ImageDraw.Draw(image).text((2 - left, 2 - top), text, fill=255, font=font)
    return np.asarray(image)


@lru_cache(maxsize=16)
def text_block(lines: tuple[tuple[str, str], ...], height: int) -> np.ndarray:
    """(H, W) uint8 coverage of lines in two columns, letters about `height` pixels tall."""
    font = ImageFont.load_default(size=height)
    step, gap = round(1.5 * height), height
    first = max((font.getlength(left) for left, right in lines if right), default=0.0)
    width = max(font.getlength(left) if not right else first + gap + font.getlength(right) for left, right in lines)
    image = Image.new("L", (int(width) + 4, step * len(lines)))
    draw = ImageDraw.Draw(image)
    for number, (left, right) in enumerate(lines):
        draw.text((1, number * step), left, fill=255, font=font)
        draw.text((1 + first + gap, number * step), right, fill=255, font=font)
    return np.ascontiguousarray(image)
