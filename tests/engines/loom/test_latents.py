"""Every motion of a draw has noise of its own, from which one may go over to another's."""

from __future__ import annotations

import numpy as np
import pytest

from engines.errors import OutOfRangeError
from tests.engines.loom.tiny import engine as tiny_engine


def test_each_motion_of_a_draw_can_be_an_end() -> None:
    engine = tiny_engine()
    draw = engine.generate_many("walk", count=3, frames=40, seed=5)
    a, b = engine.latents("walk", 5, 40, index=2), engine.latents("walk", 5, 40, index=1)
    between = engine.interpolate("walk", a, b, steps=3)
    np.testing.assert_allclose(between[0].positions, draw[2].positions, atol=1e-4)
    np.testing.assert_allclose(between[-1].positions, draw[1].positions, atol=1e-4)
    with pytest.raises(OutOfRangeError):
        engine.latents("walk", 5, 40, index=-1)
