"""A textured body in a real browser."""

from __future__ import annotations

import base64
import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tests.viewers import poses
from tests.viewers.textured import gradient, textured
from viewers.web import payload

pytestmark = [pytest.mark.ui, pytest.mark.timeout(240)]


def picture(page) -> np.ndarray:
    page.still()
    return np.asarray(Image.open(io.BytesIO(page.page.locator("canvas").first.screenshot())).convert("RGB")).astype(int)


def test_a_texture_looks_as_the_same_colours_at_the_vertices(open_player) -> None:
    body = textured(gradient())
    page = open_player(poses.stand(), body=body, camera="front", controls="none", floor=False)
    flipped = replace(body, uv=body.uv * [1, -1] + [0, 1])
    seen = {"texture": picture(page)}
    for name, other in (("colours", replace(body, uv=None, texture=None)), ("flipped", flipped)):
        data = base64.b64encode(payload.encode_body(other)).decode()
        page.page.evaluate(
            """async (data) => {
                const { player } = document.querySelector('.motion-player');
                player.setBody(Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)));
                await player.geometry.arrived;
                player.stage.invalidate();
            }""",
            data,
        )
        seen[name] = picture(page)
    figure = np.abs(seen["colours"] - seen["flipped"]).max(-1) > 12
    assert 0.02 < figure.mean() < 0.5
    assert np.abs(seen["texture"] - seen["colours"])[figure].mean() < 4.0
    assert np.abs(seen["texture"] - seen["colours"])[~figure].mean() < 0.5


def test_a_picture_no_browser_reads_leaves_the_colours_of_the_vertices(open_player) -> None:
    page = open_player(poses.stand(), body="anny", camera="front", controls="none")
    body = textured(gradient())
    header, arrays = payload.unpack(payload.encode_body(body))
    arrays["texture"] = arrays["texture"][:40]
    data = base64.b64encode(payload.pack({k: v for k, v in header.items() if k != "arrays"}, arrays)).decode()
    page.page.evaluate(
        """async (data) => {
            const { player } = document.querySelector('.motion-player');
            player.setBody(Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)));
            await player.geometry.arrived;
        }""",
        data,
    )
    shown = picture(page)
    assert np.ptp(shown[..., 1]) > 80
    assert page.js("player.geometry.painting.arrived.value") == 0
