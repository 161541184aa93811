"""The tools of the player on a plain page: what the mouse draws is told, and what is pinned is shown."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from PIL import Image

from engines.skeletons import SMPL22
from tests.viewers.web.conftest import PlayerPage
from tests.viewers.web.synthetic import walk

pytestmark = [pytest.mark.ui, pytest.mark.timeout(240)]
Open = Callable[..., PlayerPage]
SEEN = (
    "(() => { const { stage, pins } = player, v = stage.camera.position.clone().set(...argument)"
    ".add(pins.object.position).project(stage.camera), b = stage.canvas.getBoundingClientRect();"
    "return [b.left + (v.x + 1) / 2 * b.width, b.top + (1 - v.y) / 2 * b.height]; })()"
)
"""Where on the page a place beside the picked figure is seen."""


def drag(player: PlayerPage, spots: Sequence[Sequence[float]]) -> None:
    mouse = player.page.mouse
    mouse.move(*spots[0])
    mouse.down()
    for spot in spots[1:]:
        mouse.move(*spot, steps=6)
    mouse.up()


def joint(player: PlayerPage, name: str) -> list[float]:
    """Where a joint of the picked figure is, in the figure's own place."""
    at = SMPL22.index(name) * 3
    return player.js(f"Array.from(player.tools.figure.pose.places.slice({at}, {at + 3}))")


def pinned(motion: Any, frame: int) -> dict[str, Any]:
    turns, root = motion.rotations[frame], motion.translation[frame]
    pose = {"frame": frame, "rotations": turns.ravel().tolist(), "root": root.tolist()}
    return {
        "fps": 20, "path": [[0, 0], [0, 1], [1, 1]], "poses": [pose], "stretches": [[0, 10]],
        "joints": [{"joint": "head", "frame": 4, "place": [0.5, 1.5, 0.0]}],
    }  # fmt: skip


def test_a_line_on_the_floor_of_the_picked_figure_is_told_in_metres(open_player: Open):
    player = open_player([walk(2.0), walk(2.0)], selected=1, mirror=True, playing=True, camera="front")
    player.set("tool", "path")
    assert (player.get("playing"), player.get("mirror")) == (False, False), "nothing moves or is shown elsewhere"
    player.still()
    before = player.js("player.stage.camera.position.toArray()")
    corners = [(-0.4, 0.3), (0.5, 0.3), (0.5, 1.2)]
    drag(player, [player.js(SEEN, [x, 0, z]) for x, z in corners])
    drawn = player.get("drawn")
    points = np.array(drawn["points"])
    assert drawn["kind"] == "path"
    assert np.linalg.norm(points[[0, -1]] - [corners[0], corners[-1]], axis=1).max() < 0.03
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert (steps.max() <= 0.125, steps.min() > 0.05) == (True, True), "even steps, a hand's tremble taken out"
    assert player.get("tool") == "none"
    assert player.js("player.stage.camera.position.toArray()") == before


def test_above_the_horizon_there_is_no_floor(open_player: Open):
    player = open_player(walk(1.0), tool="path", camera="front")
    player.still()
    drag(player, [(300, 130), (400, 130), (500, 135)])
    assert player.get("drawn") == {} or player.get("drawn") is None
    assert player.get("tool") == "path", "one may try again"
    assert "too short" in player.page.locator(".hint").inner_text()
    player.focus()
    player.press("Escape")
    assert player.get("tool") == "none"
    assert player.page.locator(".hint").is_hidden()


def test_a_joint_follows_the_mouse_in_the_plane_that_faces_the_camera(open_player: Open):
    player = open_player(walk(2.0), tool="joint", camera="left", frame=13)
    player.still()
    place = joint(player, "right_wrist")
    x, y = player.js(SEEN, place)
    player.page.mouse.move(x + 2, y + 2)
    assert player.page.locator(".hint").inner_text().startswith("Right wrist: drag it to its place")
    drag(player, [(x, y), (x + 50, y - 60)])
    drawn = player.get("drawn")
    assert (drawn["kind"], drawn["joint"], drawn["frame"], drawn["fps"]) == ("joint", "right_wrist", 13, 20)
    assert math.dist(player.js(SEEN, drawn["place"]), (x + 50, y - 60)) < 2
    away = player.js("player.stage.camera.getWorldDirection(player.stage.camera.position.clone()).toArray()")
    assert abs(np.dot(np.subtract(drawn["place"], place), away)) < 0.002
    assert player.get("tool") == "joint", "for the next one"


def test_a_joint_stays_above_the_floor_and_a_click_pins_it_where_it_is(open_player: Open):
    player = open_player(walk(2.0), tool="joint", camera="front")
    player.still()
    place = joint(player, "left_ankle")
    x, y = player.js(SEEN, place)
    drag(player, [(x, y)])
    assert math.dist(player.get("drawn")["place"], place) < 0.002
    drag(player, [(x, y), (x, y + 90)])
    assert player.get("drawn")["place"][1] == 0


def test_beside_the_joints_the_mouse_turns_the_camera(open_player: Open):
    player = open_player(walk(1.0), tool="joint", camera="front")
    player.still()
    before = player.js("player.stage.camera.position.toArray()")
    drag(player, [(60, 200), (120, 200)])
    assert player.js("player.stage.camera.position.toArray()") != before
    assert not player.get("drawn")


def test_the_root_is_not_pinned_by_hand(open_player: Open):
    player = open_player(walk(1.0), tool="joint", camera="front")
    player.still()
    assert player.js("player.tools.dots.children.map((dot) => dot.visible)") == [False] + [True] * 21


@pytest.mark.parametrize("body", ["anny", "stick"])
def test_what_is_pinned_is_shown_where_it_is(open_player: Open, body: str):
    motion = walk(2.0, turn=0.5)
    player = open_player([walk(2.0), motion], selected=1, body=body)
    player.set("pinned", pinned(motion, 30))
    player.pictures(2)
    ghosts = player.js("player.pins.ghosts.map((g) => [g.object.visible, Array.from(g.pinned.places)])")
    assert len(ghosts) == 1
    assert ghosts[0][0]
    assert np.abs(np.reshape(ghosts[0][1], (-1, 3)) - motion.positions[30]).max() < 5e-4
    assert player.js("player.pins.object.position.toArray()") == player.js("player.actors[1].object.position.toArray()")
    assert player.js("player.pins.line.object.visible && player.pins.balls.length") == 1
    player.set("selected", 0)
    player.pictures(2)
    assert player.js("player.pins.object.position.x") == player.js("player.actors[0].object.position.x")
    player.set("pinned", {})
    player.pictures(2)
    assert player.js("[player.pins.line.object.visible, player.pins.balls.length, player.pins.ghosts.length]") == [
        False, 0, 0,
    ]  # fmt: skip


def marked(player: PlayerPage) -> set[int]:
    """The fortieths of the ruler that hold something amber."""
    shot = player.page.locator(".motion-player .ruler").first.screenshot()
    pixels = np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=np.int64)
    amber = (pixels[..., 0] > 200) & (pixels[..., 1] > 140) & (pixels[..., 2] < 110)
    return {int(40 * x / pixels.shape[1]) for x in np.flatnonzero(amber.any(axis=0))}


def test_pins_are_marked_on_the_ruler(open_player: Open):
    player = open_player(walk(2.0))
    assert marked(player) == set()
    player.set("pinned", pinned(walk(2.0), 30))
    player.pictures(2)
    found = marked(player)
    assert set(range(10)) <= found, "a bar over the frames that are kept"
    assert 30 in found, "a diamond at the pose"
    assert not found & set(range(13, 28))


def test_pins_stay_with_other_takes(open_player: Open):
    player = open_player(walk(2.0))
    player.set("pinned", pinned(walk(2.0), 30))
    player.js("player.setTakes(model.get('take_data'))")
    player.pictures(2)
    assert player.js("[player.pins.ghosts.length, player.pins.line.object.visible]") == [1, True]
