"""Small pictures of motions without a background, drawn on the one thread that owns the OpenGL context."""

from __future__ import annotations

import base64
import io
import threading
from typing import Any

import numpy as np

from engines import Motion

SIZE = 128
"""Pixels a side; shown at half of that, for dense screens."""

_own = threading.local()


def thumbnail(motion: Motion, colour: str | None = None, body: Any = "anny") -> str:
    """The most telling frame of a motion as a data URI (WebP, transparent around the body).

    Args:
        motion: of any skeleton.
        colour: of the clothes, "#rrggbb"; the first of the stage's if none.
        body: name of a body, or a `viewers.bodies.Body`.

    Raises:
        SkeletonError: that body cannot wear the motion.

    Call it from the "still" lane of the job queue only: the renderer belongs to the thread that made it.
    """
    from PIL import Image

    from viewers import scene

    if not hasattr(_own, "renderer"):
        from viewers.moderngl_renderer import Renderer

        _own.renderer = Renderer(SIZE, SIZE)
    image = Image.fromarray(cut_out(_own.renderer, scene.thumbnail(motion, body, colour)))
    file = io.BytesIO()
    image.save(file, format="WEBP", quality=85)
    return "data:image/webp;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def cut_out(renderer: Any, shown: Any, t: float = 0.0) -> np.ndarray:
    """(H, W, 4) uint8 picture of a scene's bodies alone.

    Drawn before black and before white: where the two differ, the background shows through by that much.
    """
    from viewers.scene import Backdrop

    def before(grey: str) -> np.ndarray:
        plain = Backdrop(centre=grey, edge=grey, floor=grey, grid=grey)
        return renderer.frame(shown.replaced(backdrop=plain, floor=False), t).astype(np.float64)

    black, white = before("#000000"), before("#ffffff")
    opaque = np.clip(1.0 - (white - black).mean(-1, keepdims=True) / 255.0, 0.0, 1.0)
    colour = np.where(opaque > 1e-3, black / np.maximum(opaque, 1e-3), 0.0)
    return np.concatenate([np.clip(colour, 0, 255), opaque * 255.0], axis=-1).round().astype(np.uint8)
