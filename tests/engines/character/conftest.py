"""A body of which everything is known, small, for all that is made from its picture."""

from __future__ import annotations

import numpy as np
import pytest

from engines.character.template import posed_vertices
from engines.character.texture import Front
from engines.evaluation.characters import Known, framed, standing
from viewers import bodies


@pytest.fixture(scope="session")
def known() -> Known:
    body = bodies.get("anny")
    pose, root = standing(body, arms=1.1), np.array([0.05, 0.9, 0.0])
    view, size = framed(posed_vertices(body, pose, root), 420)
    return Known(body, body.painted((0.2, 0.4, 0.3)), pose, root, view, size)


@pytest.fixture(scope="session")
def front(known: Known) -> Front:
    picture, mask = known.front
    return Front.of(known.surface, picture, mask, known.view)
