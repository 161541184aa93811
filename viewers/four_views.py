"""Four pictures in one: the same moment from four sides, each going along with the body or standing still."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import numpy as np

from engines.errors import OutOfRangeError
from viewers.camera import Camera
from viewers.gl.marks import text_image
from viewers.moderngl_renderer import RING, Renderer
from viewers.scene import Scene, hex_to_rgb

VIEWS: tuple[tuple[str, Camera], ...] = (
    ("front", Camera("front")),
    ("side", Camera("left")),
    ("top", Camera("orbit", yaw=0.0, pitch=np.pi / 2)),
    ("orbit", Camera("follow")),
)
"""Name and camera of each, in reading order."""
AROUND: tuple[tuple[str, Camera], ...] = tuple(
    (name, Camera("follow", *Camera(name).angles)) for name in ("front", "back", "left", "right")
)
"""The same of a character that is to be seen from all around, as large wherever it goes."""
SEAM = 2
"""Pixels between the pictures."""


class FourViews:
    """Draws scenes as `moderngl_renderer.Renderer` does, four times in one picture, each with its name in a corner.

    Args:
        width: of its pictures, pixels.
        height: likewise.
        samples: a pixel.
        views: names and cameras of the four.

    Raises:
        OutOfRangeError: a size or number of samples that cannot be.
        NoGraphicsError: no OpenGL here; the message says what to install.
    """

    def __init__(
        self, width: int, height: int, samples: int = 4, views: tuple[tuple[str, Camera], ...] = VIEWS
    ) -> None:
        self.views = views
        self.width, self.height = width, height
        across, down = (width - SEAM) // 2, (height - SEAM) // 2
        if min(across, down) < 1:
            raise OutOfRangeError("size of four views", f"{width} x {height}", "4 x 4 pixels or more")
        self._close = ExitStack()
        self._renderers = [self._close.enter_context(Renderer(across, down, samples)) for _ in views]
        right, low = width - across, height - down
        self._corners = [(0, 0), (0, right), (low, 0), (low, right)]

    def __enter__(self) -> FourViews:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the pictures."""
        self._close.close()

    def pictures(self, scene: Scene, times: np.ndarray) -> Iterator[np.ndarray]:
        """(H, W, 4) uint8 pictures at `times` (N,) seconds, each valid until RING - 1 more were asked for.

        The scene's own camera is left out.
        """
        colour = (0, 0, 0, 0) if scene.transparent else (*_bytes(scene.colours.edge), 255)
        ring = [np.full((self.height, self.width, 4), colour, np.uint8) for _ in range(min(RING, len(times)))]
        views = [
            renderer.pictures(scene.replaced(camera=camera), times)
            for renderer, (_, camera) in zip(self._renderers, self.views, strict=True)
        ]
        for number, parts in enumerate(zip(*views, strict=True)):
            whole = ring[number % len(ring)]
            for (top, left), part, (name, _) in zip(self._corners, parts, self.views, strict=True):
                here = whole[top : top + part.shape[0], left : left + part.shape[1]]
                here[:] = part
                _write(here, name, scene.colours.ink)
            yield whole


def _write(picture: np.ndarray, text: str, colour: str) -> None:
    """Text in the upper left corner of a picture (H, W, 4), in place."""
    letters = text_image(text, max(9, picture.shape[0] // 22))
    margin = max(4, picture.shape[0] // 36)
    here = picture[margin : margin + letters.shape[0], margin : margin + letters.shape[1]]
    share = letters[: here.shape[0], : here.shape[1], None] / 255.0
    under = here[..., 3:] / 255.0
    alpha = share + under * (1 - share)
    mixed = share * np.array(_bytes(colour)) + (1 - share) * under * here[..., :3]
    here[..., :3] = np.round(mixed / np.maximum(alpha, 1e-6))
    here[..., 3:] = np.round(255 * alpha)


def _bytes(colour: str) -> tuple[int, int, int]:
    red, green, blue = hex_to_rgb(colour)
    return round(255 * red), round(255 * green), round(255 * blue)
