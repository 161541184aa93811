"""Several figures in one place, and changes to a take that somebody else carries out."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from PIL import Image
from playwright.sync_api import expect

from tests.viewers.web.conftest import PlayerPage
from tests.viewers.web.synthetic import walk

Open = Callable[..., PlayerPage]
CHANGES = "feet=Foot clean-up,mirror=Mirror"


def test_overlay_by_key_and_button(open_player: Open):
    player = open_player([walk(1.0), walk(1.0), walk(1.0)])
    places = "player.actors.map((actor) => actor.object.position.x)"
    assert len(set(player.js(places))) == 3
    player.focus()
    player.press("v")
    assert player.get("arrangement") == "overlay"
    assert player.js(places) == [0, 0, 0]
    shown = "player.actors.map((actor) => [actor.shadows.object.visible, actor.solid.castShadow])"
    player.js("player.set('selected', 1)")
    assert player.js(shown) == [[False, False], [True, True], [False, False]], "shadows do not pile up"
    button = player.page.get_by_role("button", name="Overlay")
    expect(button).to_have_attribute("aria-pressed", "true")
    button.click()
    assert player.get("arrangement") == "side"
    assert player.js(shown) == [[True, True]] * 3


def test_one_figure_has_nothing_to_overlay(open_player: Open):
    player = open_player(walk(1.0))
    expect(player.page.get_by_role("button", name="Overlay")).to_be_hidden()
    player.focus()
    player.press("v")
    assert player.get("arrangement") == "side"


def test_changes_offered_take_the_place_of_those_of_the_view(open_player: Open):
    player = open_player([walk(1.0), walk(1.0)], labels=["Take 1", "Take 2"], editable=CHANGES, edits="mirror")
    page = player.page
    group = page.get_by_role("group", name="Changes to Take 1")
    feet, mirror = (group.get_by_role("button", name=name, exact=True) for name in ("Foot clean-up", "Mirror"))
    expect(mirror).to_have_attribute("aria-pressed", "true")
    expect(feet).to_have_attribute("aria-pressed", "false")
    expect(page.get_by_role("button", name="In place")).to_have_count(0)
    expect(page.get_by_role("button", name="Floor")).to_be_visible()
    feet.click()
    assert player.get("edits") == "mirror,feet"
    mirror.click()
    assert player.get("edits") == "feet"
    assert player.get("mirror") is False, "the view is left alone"
    player.js("player.set('selected', 1)")
    expect(page.get_by_role("group", name="Changes to Take 2")).to_be_visible()


def test_without_an_offer_the_view_changes(open_player: Open):
    player = open_player(walk(1.0))
    player.page.get_by_role("button", name="Mirror").click()
    assert player.get("mirror") is True
    assert player.get("edits") == ""


def test_who_part_ways_begin_in_one_picture_and_the_picked_one_is_followed(open_player: Open):
    """Eight in a row, of whom one walks away."""
    still = walk(14.0).in_place()
    player = open_player([walk(14.0), *[still] * 7], camera="follow")
    player.js("player.set('selected', 7)")
    wide = (
        "(() => { player.stage.camera.updateMatrixWorld(); return player.actors.map((actor) => "
        "actor.root.clone().project(player.stage.camera)).every(({ x }) => Math.abs(x) < 1); })()"
    )
    assert player.js("player.together") is False
    player.still()
    assert player.js(wide), "all are seen where they begin"
    player.js("player.seek(player.clock.frames - 1)")
    player.still()
    target = player.js("[player.cameraman.controls.target.x, player.actors[7].root.x]")
    assert abs(target[0] - target[1]) < 0.2


def test_all_figures_of_an_overlay_are_seen(open_player: Open):
    player = open_player([walk(3.0), walk(3.0, turn=0.6), walk(3.0, turn=-0.6)], arrangement="overlay", frame=45)
    player.js("player.cameraman.home(false)")
    player.still()

    def picture() -> np.ndarray:
        return np.asarray(Image.open(io.BytesIO(player.page.screenshot())).convert("RGB"), dtype=float)

    before = picture()
    for other in (1, 2):
        player.js(f"(player.actors[{other}].solid.visible = false, player.actors[{other}].depth.visible = false)")
    player.pictures()
    player.still()
    changed = (np.abs(picture() - before).max(axis=-1) > 12).sum()
    assert changed > 1500, "two bodies more than the picked one"
