"""Another body for the motions that are shown."""

from __future__ import annotations

import pytest

from engines.errors import UnknownLabelError
from tests.viewers.web.synthetic import walk
from viewers import bodies
from viewers.web.payload import unpack
from viewers.web.player import PanelPlayer


def test_a_player_wears_another_body_and_plays_on():
    player = PanelPlayer([walk(1.0), walk(0.5)], labels=["one", "two"], frame=7)
    usual = player.body_data
    heavy = bodies.get("anny").shaped(weight=1.0)
    player.wear(heavy)
    header, arrays = unpack(player.body_data)
    assert header["kind"] == "body"
    assert arrays["vertices"].shape == unpack(usual)[1]["vertices"].shape
    assert player.body_data != usual
    assert [actor["name"] for actor in unpack(player.take_data)[0]["actors"]] == ["one", "two"]
    assert player.frame == 7
    player.wear("anny")
    assert player.body_data == usual


def test_a_body_that_is_none_changes_nothing():
    player = PanelPlayer(walk(1.0))
    before = player.body_data, player.take_data
    with pytest.raises(UnknownLabelError):
        player.wear("anney")
    assert (player.body_data, player.take_data) == before
    player.motions = walk(0.5)
    assert player.body_data == before[0]
