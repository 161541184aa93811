"""A picture as it comes from a person: a file, its bytes or an open image, made upright sRGB of bounded size."""

from __future__ import annotations

import io
import logging
import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image, ImageCms, ImageOps, UnidentifiedImageError

from engines.errors import FormatError

log = logging.getLogger(__name__)

SHORTEST = 256
"""Pixels of the shorter side, at least."""
MOST = 40_000_000
"""Pixels, at most; told by a file's header before it is decoded."""
LONGEST = 3072
"""Pixels of the longer side that are kept: more than a body's texture can hold."""
KINDS = ("JPEG", "PNG", "WEBP")
_ACCEPTED = "accepted: JPEG, PNG or WebP"
_DAMAGE = (OSError, SyntaxError, ValueError, TypeError, KeyError, IndexError, EOFError, struct.error, zlib.error)
"""What Pillow's decoders raise over damaged files."""


@dataclass(frozen=True, eq=False)
class Picture:
    """An upright picture without transparency."""

    pixels: UInt8[np.ndarray, "H W 3"]
    """(H, W, 3) sRGB."""
    name: str = "picture"
    """The file's name, for messages and provenance."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]


def open_picture(source: str | Path | bytes | Image.Image, name: str | None = None) -> Picture:
    """A picture made ready: turned as the camera was held, sRGB, transparency on white, no longer than `LONGEST`.

    Args:
        source: a file, the bytes of one, or an open image.
        name: for messages; default: the file's own.

    Raises:
        FormatError: no picture of an accepted kind or size, damaged or cut off.
    """
    title = name or (Path(source).name if isinstance(source, str | Path) else "picture")
    try:
        if isinstance(source, Image.Image):
            return _made(source, title)
        stream = io.BytesIO(source) if isinstance(source, bytes) else Path(source)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # the size is looked at below
            opened = Image.open(stream, formats=KINDS)
        with opened as image:
            return _made(image, title)
    except FileNotFoundError as problem:
        raise FormatError(title, "is not there.") from problem
    except IsADirectoryError as problem:
        raise FormatError(title, f"is a folder; {_ACCEPTED}.") from problem
    except Image.DecompressionBombError as problem:
        raise FormatError(title, f"is far too large; accepted: up to {MOST // 1_000_000} megapixels.") from problem
    except UnidentifiedImageError as problem:
        raise FormatError(title, f"is no picture that can be read{_hint(source)}; {_ACCEPTED}.") from problem
    except _DAMAGE as problem:
        raise FormatError(title, f"is damaged or cut off ({problem}); save or copy it again.") from problem


def _made(image: Image.Image, name: str) -> Picture:
    width, height = image.size
    if width * height > MOST:
        raise FormatError(
            name,
            f"has {width} x {height} pixels ({width * height / 1e6:.0f} megapixels); accepted: up to "
            f"{MOST // 1_000_000} megapixels. Make it smaller first.",
        )
    if min(width, height) < SHORTEST:
        raise FormatError(name, f"has {width} x {height} pixels; accepted: {SHORTEST} or more on the shorter side.")
    image.draft(None, (LONGEST, LONGEST))  # a JPEG is decoded at a half or a quarter where that is enough
    image = _without_depth(ImageOps.exif_transpose(image))
    image.thumbnail((LONGEST, LONGEST), Image.Resampling.LANCZOS)
    return Picture(np.ascontiguousarray(_as_srgb(image)), name)


def _without_depth(image: Image.Image) -> Image.Image:
    """8 bits a channel, of palettes the colours."""
    if image.mode.startswith("I"):
        return Image.fromarray((np.asarray(image) // 257).astype(np.uint8))
    if image.mode == "P" or "transparency" in image.info:
        return image.convert("RGBA")
    return image if image.mode in ("RGB", "RGBA", "LA", "L", "CMYK") else image.convert("RGB")


def _as_srgb(image: Image.Image) -> Image.Image:
    """RGB in sRGB, laid on white."""
    profile = image.info.get("icc_profile")
    alpha = image.getchannel("A") if "A" in image.getbands() else None
    if alpha is not None:
        image = image.convert("RGB" if image.mode == "RGBA" else "L")
    if profile:
        try:
            given = ImageCms.ImageCmsProfile(io.BytesIO(profile))
            srgb = ImageCms.createProfile("sRGB")
            image = ImageCms.profileToProfile(image, given, srgb, outputMode="RGB") or image
        except (ImageCms.PyCMSError, OSError, ValueError, TypeError) as problem:
            log.info("the picture's colour profile is left out: %s", problem)
    image = image.convert("RGB")
    if alpha is not None:
        image = Image.composite(image, Image.new("RGB", image.size, "white"), alpha)
    return image


def _hint(source: str | Path | bytes | Image.Image) -> str:
    """What the file is instead, where its first bytes tell."""
    head = source if isinstance(source, bytes) else b""
    if isinstance(source, str | Path):
        with Path(source).open("rb") as file:
            head = file.read(32)
    if not head:
        return " (it is empty)"
    if head[4:8] == b"ftyp":
        apple = head[8:12] in (b"heic", b"heix", b"mif1", b"msf1")
        return " (a HEIC photo: export it as JPEG)" if apple else " (a video or an AVIF picture)"
    return " (a PDF)" if head.startswith(b"%PDF") else ""
