"""Points in metres and pixels."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from engines.character.view import View

sizes = st.floats(1, 1000)
places = st.tuples(*[st.floats(-10, 10)] * 3)


def test_the_persons_left_and_up_are_the_pictures_right_and_top() -> None:
    view = View(100.0, (300.0, 400.0))
    assert view.project(np.array([0.0, 0.0, 5.0])).tolist() == [300, 400]
    assert view.project(np.array([1.0, 2.0, 0.0])).tolist() == [400, 200]


@given(sizes, places)
def test_a_pixel_goes_back_to_its_point_at_the_points_depth(scale: float, place: tuple[float, float, float]) -> None:
    view, point = View(scale, (12.0, -7.0)), np.array([place])
    assert np.allclose(view.unproject(view.project(point), point[:, 2]), point, atol=1e-9)
