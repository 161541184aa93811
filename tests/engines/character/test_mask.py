"""Coarse silhouettes refined, without the networks."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image, ImageDraw

from engines.character import mask
from engines.character.models import Body, Crop
from engines.evaluation.characters import overlap


def drawn(size: int) -> np.ndarray:
    """(size, size) a star: thin rays, which a coarse silhouette loses."""
    image = Image.new("L", (size, size))
    angles = np.linspace(0, 2 * np.pi, 15)[:-1]
    reach = np.where(np.arange(14) % 2, 0.14, 0.4) * size
    points = np.stack([size / 2 + reach * np.sin(angles), size / 2 - reach * np.cos(angles)], axis=1)
    ImageDraw.Draw(image).polygon([*map(tuple, points)], fill=1)
    return np.asarray(image, dtype=bool)


def seen_coarsely(truth: np.ndarray, cells: int = 256, lost: int = 12) -> Body:
    """What a network would say that sees `cells` cells and no detail below `lost` pixels."""
    small = Image.fromarray(truth.astype(np.float32)).resize((len(truth) // lost,) * 2, Image.Resampling.BOX)
    inside = np.asarray(small.resize((cells, cells), Image.Resampling.BILINEAR))
    crop = Crop(np.full(2, len(truth) / 2), float(len(truth)), 0.0)
    nothing = np.zeros((33, 2))
    return Body(1.0, nothing, np.zeros(33), np.zeros((33, 3)), inside, crop, crop)


@pytest.mark.parametrize("size", [600, 1500], ids=["as it is", "shrunk and enlarged"])
def test_edges_of_the_picture_are_found_within_a_coarse_silhouette(size: int) -> None:
    truth = drawn(size)
    noise = np.random.default_rng(0).normal(0, 12, (size, size, 3))
    pixels = (np.where(truth[..., None], (190, 120, 90), (80, 110, 150)) + noise).clip(0, 255).astype(np.uint8)
    body = seen_coarsely(truth, lost=size // 50)
    coarse = mask._coarse(body, truth.shape, 1.0) > 0.5
    fine = mask.silhouette(pixels, [body])
    assert fine.dtype == np.float32 and fine.shape == truth.shape
    assert fine.min() >= 0 and fine.max() <= 1
    assert overlap(coarse, truth) < 0.97
    assert overlap(fine > 0.5, truth) > 0.985


def test_limbs_in_plain_sight_are_person_even_where_the_network_sees_none() -> None:
    truth = drawn(512)
    body = seen_coarsely(truth)
    elbow, wrist = (mask.landmarks.index(name) for name in ("left_elbow", "left_wrist"))
    body.points[elbow], body.points[wrist], body.seen[[elbow, wrist]] = (20, 20), (20, 120), 1.0
    assert mask._coarse(body, (512, 512), 1.0)[70, 20] == 1
    body.seen[wrist] = 0.3
    assert mask._coarse(body, (512, 512), 1.0)[70, 20] == 0


def test_where_the_network_sees_nobody_there_is_no_silhouette() -> None:
    nobody = seen_coarsely(np.zeros((300, 300), bool))
    assert not mask.silhouette(np.zeros((300, 300, 3), np.uint8), [nobody]).any()
