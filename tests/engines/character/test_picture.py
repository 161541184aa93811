"""Files that people bring, opened or refused in words."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageCms

from engines.character.picture import LONGEST, open_picture
from engines.errors import FormatError

LEFT, RIGHT = (200, 40, 30), (30, 60, 190)


def halves(width: int = 400, height: int = 300) -> Image.Image:
    """Red on the left, blue on the right."""
    image = Image.new("RGB", (width, height), LEFT)
    image.paste(RIGHT, (width // 2, 0, width, height))
    return image


def encoded(image: Image.Image, kind: str = "PNG", **options) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "WEBP"])
def test_each_kind_is_the_same_from_a_file_its_bytes_and_an_open_image(tmp_path: Path, kind: str) -> None:
    data = encoded(halves(), kind, quality=95) if kind != "PNG" else encoded(halves())
    path = tmp_path / "me.picture"
    path.write_bytes(data)
    for source in (path, str(path), data, Image.open(path)):
        pixels = open_picture(source).pixels
        assert pixels.shape == (300, 400, 3)
        assert np.abs(pixels[150, 100].astype(int) - LEFT).max() < 12
        assert np.abs(pixels[150, 300].astype(int) - RIGHT).max() < 12
    assert open_picture(path).name == "me.picture"
    assert open_picture(data, name="upload").name == "upload"


def test_a_picture_is_turned_as_the_camera_was_held() -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera's right is up
    upright = open_picture(encoded(halves(), "JPEG", exif=exif, quality=95))
    assert upright.size == (300, 400)
    assert upright.pixels[100, 150, 0] > 150 > upright.pixels[300, 150, 0]


@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_what_is_transparent_is_white(mode: str) -> None:
    image = halves().convert(mode)
    image.putalpha(Image.fromarray(np.repeat(np.uint8([[0, 255]]), [150, 250], axis=1).repeat(300, axis=0)))
    pixels = open_picture(encoded(image)).pixels
    assert (pixels[:, :140] == 255).all()
    assert not (pixels[:, 160:] == 255).all(axis=-1).any()


def test_sixteen_bits_grey_and_cmyk_become_eight_bits_of_three_colours() -> None:
    ramp = np.linspace(0, 65535, 300 * 400).reshape(300, 400).astype(np.uint16)
    deep = open_picture(encoded(Image.fromarray(ramp))).pixels
    assert deep[0, 0].tolist() == [0, 0, 0] and deep[-1, -1].tolist() == [255, 255, 255]
    assert abs(int(deep[150, 200, 0]) - 128) <= 1
    assert np.ptp(open_picture(encoded(halves().convert("L"))).pixels, axis=-1).max() == 0
    printed = open_picture(encoded(halves().convert("CMYK"), "JPEG", quality=95)).pixels
    assert np.abs(printed[150, 100].astype(int) - LEFT).max() < 12


def test_colours_of_another_profile_are_brought_to_srgb() -> None:
    lab = ImageCms.createProfile("LAB")
    unusable = ImageCms.ImageCmsProfile(lab).tobytes()
    assert np.array_equal(open_picture(encoded(halves(), icc_profile=unusable)).pixels, np.asarray(halves()))
    same = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    close = open_picture(encoded(halves(), icc_profile=same)).pixels.astype(int)
    assert np.abs(close - np.asarray(halves(), int)).max() <= 2


def test_large_pictures_are_shrunk_and_keep_their_shape() -> None:
    width, height = open_picture(encoded(halves(6000, 4500), "JPEG")).size
    assert width == LONGEST and abs(height - LONGEST * 3 / 4) <= 1


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "empty"),
        (b"hello", "JPEG, PNG or WebP"),
        (b"\0\0\0\x18ftypheic" + bytes(40), "HEIC"),
        (b"%PDF-1.7", "PDF"),
        (encoded(halves(), "GIF"), "JPEG, PNG or WebP"),
        (encoded(halves())[:300], "cut off"),
        (encoded(halves(1000, 1000), "JPEG")[:3000], "cut off"),
        (encoded(halves(300, 200)), "256"),
        (encoded(Image.new("1", (10_000, 10_000))), "100 megapixels"),
        (encoded(Image.new("1", (20_000, 20_000))), "40 megapixels"),
    ],
    ids=["empty", "text", "heic", "pdf", "gif", "cut png", "cut jpeg", "small", "100 Mpx", "400 Mpx"],
)
def test_what_is_no_use_is_refused_in_words(data: bytes, told: str) -> None:
    with pytest.raises(FormatError, match=told):
        open_picture(data)


def test_missing_files_and_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"me\.jpg: is not there"):
        open_picture(tmp_path / "me.jpg")
    with pytest.raises(FormatError, match="is a folder"):
        open_picture(tmp_path)


@settings(max_examples=60)
@given(
    st.sampled_from(["PNG", "JPEG", "WEBP"]), st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 255)), min_size=1)
)
def test_damage_is_opened_or_refused_and_nothing_else(kind: str, damage: list[tuple[int, int]]) -> None:
    data = bytearray(encoded(halves(256, 256), kind))
    for at, value in damage:
        data[at % len(data)] = value
    try:
        assert open_picture(bytes(data)).pixels.dtype == np.uint8
    except FormatError as problem:
        assert "accepted" in str(problem) or "again" in str(problem)
