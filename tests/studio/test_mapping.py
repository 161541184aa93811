"""The map of an action: where draws stand, what a place stands for, and what a session makes of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from studio import tasks
from studio.mapping import DRAWS, MARGIN, Place, Plane, poses, stands_for
from studio.settings import BLEND_STEPS
from tests.studio.fakes import sway
from tests.studio.test_varying import varied  # noqa: F401 - a fixture

PLACES = arrays(np.float64, st.tuples(st.integers(2, 12), st.just(2)), elements=st.floats(0, 1, width=32))


@given(PLACES, st.tuples(st.floats(0, 1), st.floats(0, 1)))
@settings(max_examples=60, deadline=None)
def test_a_place_stands_for_what_is_as_near_as_any_two_near_draws_come(points, at):
    place, here = stands_for(points, at), np.array(at)

    def off(found: Place) -> float:
        return float(
            np.linalg.norm((1 - found.share) * points[found.first] + found.share * points[found.second] - here)
        )

    nearest = float(np.linalg.norm(points - here, axis=1).min())
    widest = max(np.linalg.norm(points[:, None] - points[None], axis=-1).max(), 1e-9)
    rounding = widest / (BLEND_STEPS - 1) / 2
    assert off(place) <= nearest + rounding + 1e-9
    assert (place.first == place.second) == (place.share == 0.0)
    assert place.share < 1.0


def test_on_a_draw_and_between_two():
    points = np.array([[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]])
    assert stands_for(points, (0.11, 0.1)) == Place(0, 0, 0.0)
    assert stands_for(points, (0.3, 0.1)) == Place(0, 1, 0.25)
    assert stands_for(points, (0.7, 0.5)) in (Place(1, 2, 0.5), Place(2, 1, 0.5))
    assert stands_for(points, (0.0, 0.0)) == Place(0, 0, 0.0), "beyond them all: the nearest"


def test_like_stands_beside_like_within_the_margins():
    near = [sway(seed=1, index=0).moved((0.01 * i, 0, 0)) for i in range(4)]
    far = [sway(seed=1, index=0).moved((2 + 0.01 * i, 0, 0.001 * i * i)) for i in range(4)]
    plane = Plane(poses([*near, *far]))
    places = plane.places(poses([*near, *far]))
    assert places.min() == pytest.approx(MARGIN)
    assert places.max() == pytest.approx(1 - MARGIN)
    assert np.ptp(places[:4, 0]) < 0.05
    assert abs(places[0, 0] - places[4, 0]) > 0.8
    np.testing.assert_array_equal(Plane(poses([*near, *far])).places(poses(near)), places[:4])
    halfway = plane.places(poses([near[0].moved((1.0, 0, 0))]))
    assert halfway[0, 0] == pytest.approx(0.5, abs=0.02)


@pytest.fixture
def mapped(varied, settle):  # noqa: F811
    """A session with its map drawn."""
    varied.state.seed = 11
    varied.varying.map.draw()
    settle(varied)
    return varied


def test_forty_draws_are_put_on_it_with_pictures(mapped):
    drawn = mapped.varying.map.state
    assert [(call["seed"], call["count"]) for call in mapped.fake.calls] == [(11, 20), (12, 20)]
    assert (drawn.subject, len(drawn.points), drawn.busy, drawn.error) == ("walk", DRAWS, False, "")
    assert drawn.pictures == ["data:image/webp;base64, anny"] * DRAWS
    assert mapped.state.preview == ()


def test_a_draw_on_it_is_shown_at_once_and_kept_as_it_is(mapped, settle):
    mapping = mapped.varying.map
    mapping.move(*mapping.state.points[23])
    first = mapping.state.ends[0]
    ((words, motion),) = mapped.state.preview
    assert words == f"Draw {first + 1}"
    mapping.keep()
    settle(mapped)
    take = mapped.takes.get("take-5")
    assert mapped.state.selected == "take-5"
    assert (take.settings.blend, take.settings.count) == ({}, 20)
    assert take.settings.take == first % 20 + 1
    (again,) = tasks.generate(take.settings)
    np.testing.assert_array_equal(again.rotations, motion.rotations)


def between(mapping) -> tuple[float, float]:
    """A place that is no draw."""
    points = np.array(mapping.state.points)
    grid = ((x, y) for x in np.linspace(0.2, 0.8, 13) for y in np.linspace(0.2, 0.8, 13))
    return next(at for at in grid if 0.2 < stands_for(points, at).share < 0.8)


def test_what_lies_between_is_worked_out_shown_and_kept(mapped, settle):
    mapping, calls = mapped.varying.map, mapped.fake.calls
    calls.clear()
    mapping.move(*between(mapping))
    assert len(mapped.state.preview) == 1, "the nearer draw until then"
    settle(mapped)
    place = stands_for(np.array(mapping.state.points), mapping.state.at)
    assert [call["steps"] for call in calls] == [BLEND_STEPS]
    assert calls[0]["a"] == ("walk", 11 + place.first // 20, 60, place.first % 20)
    ((words, motion),) = mapped.state.preview
    assert words.startswith(f"{100 * place.share:.0f} % from draw {place.first + 1} to {place.second + 1}")
    assert motion.translation[0, 0] == round(place.share * (BLEND_STEPS - 1))
    assert len(mapping.state.line) == BLEND_STEPS
    mapping.move(*mapping.state.at)
    settle(mapped)
    assert len(calls) == 1, "worked out once"
    mapping.keep()
    settle(mapped)
    take = mapped.takes.get("take-5")
    assert take.settings.blend["share"] == place.share
    (again,) = tasks.generate(take.settings)
    np.testing.assert_array_equal(again.translation, motion.translation)


def test_a_drag_works_out_only_where_it_ends(mapped, settle):
    mapping, calls = mapped.varying.map, mapped.fake.calls
    calls.clear()
    for x in np.linspace(0.1, 0.9, 40):
        mapping.move(x, 0.5)
    settle(mapped)
    assert len(calls) <= 12
    assert mapped.state.preview[0][0] == mapping.state.words


def test_leaving_the_tab_shows_the_takes_again(mapped):
    mapping = mapped.varying.map
    mapping.move(0.5, 0.5)
    assert mapped.state.preview
    mapped.state.compose_tab = "action"
    assert mapped.state.preview == ()


def test_it_can_be_cancelled(varied, settle):  # noqa: F811
    varied.fake.slow = 0.02
    varied.varying.map.draw()
    assert varied.varying.map.state.busy
    varied.varying.map.cancel()
    settle(varied)
    drawn = varied.varying.map.state
    assert (drawn.busy, drawn.points, drawn.error) == (False, [], "")
    varied.varying.map.keep()
    varied.varying.map.move(0.5, 0.5)
    settle(varied)
    assert len(varied.takes) == 4


def test_why_there_is_none_is_said(varied, settle, monkeypatch):  # noqa: F811
    mapping, state = varied.varying.map, varied.state
    state.action = "moonwalk"
    mapping.draw()
    assert mapping.state.error == "Choose an action that this engine knows."
    state.action = "walk"
    monkeypatch.setattr(varied.fake, "generate_many", lambda *_a, **_k: 1 / 0)
    mapping.draw()
    settle(varied)
    assert "ZeroDivisionError" in mapping.state.error
    state.capabilities = frozenset({"actions"})
    assert mapping.problem() == f"{state.engine} cannot go over from one draw to another."


def test_it_is_drawn_as_the_controls_ask(varied, settle):  # noqa: F811
    varied.state.param.update(action="Wave  left hand", frames=40, bone_scale={"left_knee": 1.1}, seed=0)
    varied.varying.map.draw()
    settle(varied)
    call = varied.fake.calls[0]
    assert (call["action"], call["frames"], call["bone_scale"]) == ("wave left hand", 40, {"left_knee": 1.1})
    assert [call["seed"] for call in varied.fake.calls] == [0, 1]
    varied.varying.map.draw()
    settle(varied)
    third = varied.fake.calls[2]["seed"]
    assert third not in (0, 1), "another map is of other draws"
    varied.state.param.update(seed_locked=True)
    varied.varying.map.draw()
    settle(varied)
    assert varied.fake.calls[4]["seed"] == 0


def test_where_draws_share_names_the_map_shows_how_the_names_differ():
    draw = np.random.default_rng(3)
    means = {"old": [1.0, 0.0], "proud": [-1.0, 0.0], "sad": [0.0, 1.5]}
    names = [name for name in means for _ in range(6)]
    noise = draw.normal(0, 10.0, (len(names), 1)) * [0, 0, 1]  # far more than what tells them apart
    rows = np.array([[*means[name], 0.0] for name in names]) + noise
    rows[:, 2] -= rows[:, 2].reshape(3, 6).mean(axis=1).repeat(6)
    places = Plane(rows, names).places(rows)
    for kind in np.split(places, 3):
        assert np.ptp(kind, axis=0).max() < 1e-6
    assert np.ptp(Plane(rows).places(rows)[:6], axis=0).max() > 0.3
