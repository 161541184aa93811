"""Crops, the detector's anchors and the merging of its answers, without the networks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engines.character import models
from engines.character.models import Crop
from engines.errors import MissingDependencyError

crops = st.builds(
    lambda x, y, side, angle: Crop(np.array([x, y]), side, angle),
    st.floats(-500, 500),
    st.floats(-500, 500),
    st.floats(1, 2000),
    st.floats(-3, 3),
)


@given(crops, st.tuples(st.floats(-1, 2), st.floats(-1, 2)))
def test_a_point_of_a_crop_goes_to_the_picture_and_back(crop: Crop, point: tuple[float, float]) -> None:
    there = crop.to_picture(np.array([point]))
    assert np.allclose(crop.from_picture(there), [point], atol=1e-9)
    assert np.hypot(*(there[0] - crop.centre)) == pytest.approx(np.hypot(*(np.array(point) - 0.5)) * crop.side)


def test_a_crop_about_someone_lying_has_the_head_at_its_top() -> None:
    crop = Crop.about(np.array([100.0, 100.0]), np.array([180.0, 100.0]))  # the head is at the picture's right
    assert crop.side == pytest.approx(200.0)
    assert np.allclose(crop.from_picture(np.array([180.0, 100.0])), (0.5, 0.1))


def test_a_crop_is_cut_where_it_lies_and_its_border_goes_on() -> None:
    y, x = np.mgrid[:90, :120].astype(np.uint8)
    pixels = np.stack([x, y, np.zeros_like(x)], axis=-1)
    cut = Crop(np.array([60.0, 45.0]), 64.0, 0.0).cut(pixels, 64) * 255
    assert np.allclose(cut[..., :2], pixels[13:77, 28:92, :2], atol=1e-3)
    turned = Crop(np.array([60.0, 45.0]), 64.0, np.pi / 2).cut(pixels, 64) * 255  # its right is the picture's bottom
    assert np.allclose(turned[..., :2], np.rot90(pixels[13:77, 28:92, :2]), atol=1e-3)
    beyond = Crop(np.array([-200.0, 45.0]), 64.0, 0.0).cut(pixels, 64) * 255
    assert np.allclose(beyond[..., 0], 0, atol=1e-3)


def test_there_is_an_anchor_for_each_of_the_detectors_answers() -> None:
    anchors = models._anchors()
    assert anchors.shape == (2254, 2)
    assert np.allclose(anchors[:3], [[4 / 224, 4 / 224], [4 / 224, 4 / 224], [12 / 224, 4 / 224]])
    assert np.allclose(anchors[-1], [208 / 224, 208 / 224])


def test_detections_of_one_person_are_one_and_the_surest_comes_first() -> None:
    def box(x: float, key: float) -> list[list[float]]:
        return [[x, 0.5], [0.2, 0.2], *([[key, key]] * 4)]

    values = np.array([box(0.30, 0.0), box(0.70, 5.0), box(0.32, 1.0)])
    first, second = models._merged(values, np.array([0.6, 0.7, 0.9]))
    assert first[2] == pytest.approx(0.9 / 1.5) and first[0, 0] == pytest.approx((0.30 * 0.6 + 0.32 * 0.9) / 1.5)
    assert second[2] == pytest.approx(5.0)


def test_a_landmark_goes_to_the_middle_of_the_heat_around_it() -> None:
    heat = np.zeros((64, 64, 2))
    heat[20, 31:33, 0] = 0.9
    heat[:, :, 1] = 0.1  # not sure of anything
    flat = np.array([[30.4 / 64, 21.2 / 64], [0.25, 0.75]])
    refined = models._refined(flat, heat)
    assert np.allclose(refined[0] * 64, (31.5, 20.0))
    assert np.array_equal(refined[1], flat[1])


def test_without_the_networks_it_is_said_how_to_get_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(models.importlib.util, "find_spec", lambda name: None)
    models._network.cache_clear()
    assert not models.installed()
    with pytest.raises(MissingDependencyError, match=r"make character.*mediapipe==0\.10\.21"):
        models.detect(np.zeros((300, 300, 3), np.uint8))
