"""The studio in a notebook, without a kernel and without a browser."""

from __future__ import annotations

import numpy as np
import pytest

from engines import registry
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from studio import captions, notebook, tasks
from studio.captions import Description
from tests.studio.fakes import ConstrainedEngine, FakeEngine, FakeStyliser, sway

widgets = pytest.importorskip("ipywidgets")


def within(widget):
    """A widget and all in it."""
    yield widget
    for child in getattr(widget, "children", ()):
        yield from within(child)


def named(panel, text, kind=None):
    """The control of that name."""
    kind = kind or widgets.Widget
    found = [w for w in within(panel) if isinstance(w, kind) and getattr(w, "description", "") == text]
    assert len(found) == 1, f"{len(found)} controls are called {text!r}"
    return found[0]


def names(panel) -> set[str]:
    return {getattr(w, "description", "") for w in within(panel)} - {""}


def said(panel, words: str) -> bool:
    return any(words in w.value for w in within(panel) if isinstance(w, widgets.HTML))


@pytest.fixture(autouse=True)
def nothing_said(monkeypatch):
    """Captions have tests of their own."""
    monkeypatch.setattr(registry, "captioners", dict)
    monkeypatch.setattr(captions, "judge", lambda: None)


@pytest.fixture
def panel():
    return notebook.panel(ConstrainedEngine(), height=200)


def test_controls_are_those_the_engine_can_be_told():
    plain = names(notebook.panel(FakeEngine()))
    assert {"Action", "Seconds", "Ways", "Seed", "Legs", "Generate", "Cancel"} <= plain
    more = names(notebook.panel(ConstrainedEngine())) - plain
    assert {"Prompt", "Style", "Guidance", "Best of", "Pin this pose", "Draw a path", "Loop: end as it began"} <= more


def test_what_is_set_is_what_the_engine_is_told_and_comes_out(panel):
    named(panel, "Action").value = "wave left hand"
    named(panel, "Style").value = "old"
    named(panel, "Seconds").value = 1.5
    named(panel, "Ways").value = 2
    named(panel, "Guidance").value = 5.0
    named(panel, "Seed").value = 11
    named(panel, "Generate").click()
    assert [motion.frames for motion in panel.motions] == [30, 30], "waits for the draw"
    (call,) = panel.maker.engine.calls
    assert (call["action"], call["style"], call["guidance"], call["seed"]) == ("wave left hand", "old", 5.0, 11)
    assert (panel.settings.take, panel.settings.seed) == (1, 11)
    again = panel.maker.engine.generate_many("wave left hand", 2, 30, 11)
    np.testing.assert_array_equal(panel.motion.rotations, again[0].rotations)


def test_takes_are_chosen_by_name_or_in_the_player(panel):
    panel.generate().wait()
    panel.generate().wait()
    seeds = [call["seed"] for call in panel.maker.engine.calls]
    assert seeds[0] == 7
    assert panel.maker.state.selected == "take-5", "the first of the new draw"
    panel.player.selected = 2
    assert panel.take.title == "Take 7"
    named(panel, "Take").value = "take-2"
    assert (panel.take.title, panel.settings.seed) == ("Take 2", 7)
    assert panel.player.selected == 1
    np.testing.assert_array_equal(panel.player.motions[3].rotations, panel.motions[3].rotations)
    named(panel, "keep").value = True
    panel.generate().wait()
    assert [call["seed"] for call in panel.maker.engine.calls][-1] == seeds[1]


def test_a_draw_shows_how_far_it_is_and_can_be_cancelled():
    panel = notebook.panel(ConstrainedEngine(slow=0.2), count=8)
    bar = next(w for w in within(panel) if isinstance(w, widgets.FloatProgress))
    seen = []
    bar.observe(lambda change: seen.append(change["new"]), "value")
    named(panel, "Generate").click()
    assert named(panel, "Generate").disabled
    assert bar.layout.visibility == "visible"
    while not seen:
        assert not panel.maker.wait(0.02), "the draw ended without a word"
    named(panel, "Cancel").click()
    panel.wait(20)
    assert 0 < max(seen) < 1
    assert len(panel.maker.takes) == 0
    assert not named(panel, "Generate").disabled
    assert said(panel, "Cancelled: 8 × walk")
    named(panel, "Ways").value = 2
    assert not said(panel, "Cancelled"), "something else is asked"
    with pytest.raises(MotionloomError, match="there is no take yet"):
        panel.motion  # noqa: B018


def test_what_goes_wrong_is_said(panel, monkeypatch):
    with pytest.raises(MotionloomError, match=r"not done after 0\.01 s"):
        notebook.panel(ConstrainedEngine(slow=0.3)).generate().wait(0.01)
    named(panel, "Action").value = "moonwalk"
    assert said(panel, "“moonwalk” is not an action this engine knows")
    assert named(panel, "Generate").disabled
    with pytest.raises(MotionloomError, match="moonwalk"):
        panel.generate()
    named(panel, "Action").value = "walk"
    monkeypatch.setattr(panel.maker.engine, "generate_many", lambda *_a, **_k: 1 / 0)
    with pytest.raises(MotionloomError, match="ZeroDivisionError"):
        panel.generate().wait()
    with pytest.raises(MotionloomError, match="ZeroDivisionError"):
        panel.motion  # noqa: B018


def test_pins_are_listed_shown_taken_away_and_told(panel):
    assert named(panel, "Pin this pose").disabled, "nothing to pin yet"
    panel.generate().wait()
    panel.player.frame = 20
    named(panel, "Pin this pose").click()
    named(panel, "Path x,z").value = "0,0 0,2"
    panel.player.drawn = {"kind": "joint", "joint": "left_wrist", "place": [0.3, 1.2, 0.4], "frame": 30, "fps": 20.0}
    named(panel, "Draw a path").value = True
    assert panel.player.tool == "path"
    panel.player.tool = "none"
    assert named(panel, "Draw a path").value is False

    def listed() -> list[str]:
        return [w.value for w in within(panel) if isinstance(w, widgets.Label)]

    assert listed() == ["pose of take 1 at 1.0 s", "path of 2.0 m", "left wrist at 1.5 s"]
    assert len(panel.player.pinned["poses"]) == 1
    next(w for w in within(panel) if getattr(w, "tooltip", "") == "Remove path of 2.0 m").click()
    assert listed() == ["pose of take 1 at 1.0 s", "left wrist at 1.5 s"]
    panel.generate().wait()
    told = panel.maker.engine.calls[-1]["constraints"]
    assert (told.kept[0].at, told.pins[0].joint, told.path) == (20, "left_wrist", None)
    named(panel, "at x, y, z").value = "here"
    assert said(panel, "“here” is no place")


def test_words_are_asked_in_place_of_an_action():
    panel = notebook.panel(ConstrainedEngine(), prompt="a person waves", count=1)
    assert named(panel, "Action").layout.display == "none"
    panel.generate().wait()
    assert panel.maker.engine.calls[0]["action"] is None
    assert panel.settings.prompt == "a person waves"


REFUSED = [
    ({"speed": 2}, UnknownLabelError, "unknown setting 'speed'"),
    ({"style": "grumpy"}, UnknownLabelError, "unknown style 'grumpy'"),
    ({"count": 99}, OutOfRangeError, "count is 99"),
    ({"seconds": 1000}, OutOfRangeError, "frames is 20000"),
    ({"seconds": 30}, MotionloomError, "at most 20 s"),
    ({"action": "moonwalk"}, MotionloomError, "Nearest"),
    ({"action": "walk", "prompt": "a person walks"}, MotionloomError, "cannot be asked at once"),
]


@pytest.mark.parametrize(("settings", "kind", "words"), REFUSED)
def test_beginnings_that_cannot_be(settings, kind, words):
    with pytest.raises(kind, match=words):
        notebook.panel(ConstrainedEngine(), **settings)


def test_what_an_engine_cannot_be_told_is_refused():
    with pytest.raises(MotionloomError, match="fake takes no style"):
        notebook.panel(FakeEngine(), style="old")
    with pytest.raises(UnknownLabelError, match="engine"):
        notebook.panel("nobody")


def test_another_variant_is_loaded_by_name(monkeypatch):
    monkeypatch.setattr(tasks, "load_engine", lambda _name, variant="": FakeEngine(variant or "plain"))
    panel = notebook.panel("fake")
    named(panel, "Model").value = "other"
    assert panel.maker.engine.variant == "other"
    assert panel.generate().settings.variant == "other"


def test_a_motion_in_another_manner():
    walk, engine = sway(frames=40), FakeStyliser()
    panel = notebook.panel(engine, motion=walk, style="old", count=2)
    assert {"Style", "Strength", "Ways", "Seed", "Generate"} <= names(panel)
    assert not {"Action", "Seconds", "Prompt"} & names(panel)
    assert said(panel, "2 takes: fake, old × 1")
    named(panel, "Strength").value = 0.5
    named(panel, "Generate").click()
    assert [motion.frames for motion in panel.motions] == [59, 59]
    assert (engine.calls[-1]["style"], engine.calls[-1]["strength"], panel.settings.strength) == ("old", 0.5, 0.5)
    like = notebook.panel(engine, motion=walk, like=sway("wave", frames=30)).generate().wait()
    assert (engine.calls[-1]["style"], engine.calls[-1]["like"]) == (None, len(like.settings.like.motion))
    with pytest.raises(MotionloomError, match="motion=walk"):
        notebook.panel(engine, style="old")
    with pytest.raises(UnknownLabelError, match="style"):
        notebook.panel(engine, motion=walk, style="odl")
    with pytest.raises(OutOfRangeError, match="strength"):
        notebook.panel(engine, motion=walk, strength=2.0)
    with pytest.raises(UnknownLabelError, match="'strength'"):
        notebook.panel(engine, motion=walk, strenght=1.0)


def test_a_length_is_found_until_one_is_typed(panel):
    named(panel, "Action").value = "jump"
    assert named(panel, "Seconds").value == 1.5
    named(panel, "Generate").click()
    assert panel.motion.frames == 30
    named(panel, "Seconds").value = 2.0
    assert not named(panel, "As long as it takes").value
    named(panel, "Action").value = "walk"
    named(panel, "Generate").click()
    assert panel.motion.frames == 40
    assert named(notebook.panel(ConstrainedEngine(), seconds=3.0, action="jump"), "Seconds").value == 3.0


def test_takes_are_said_in_words(monkeypatch):
    monkeypatch.setattr(
        captions, "describe", lambda motions, _: [Description("A person walks.", 0.8, 0.5)] * len(motions)
    )
    panel = notebook.panel(ConstrainedEngine(), prompt="hop", count=2)
    panel.generate().wait()
    assert panel.words.sentence == "A person walks."
    while jobs := panel.maker.queue.jobs(panel.maker._id):
        jobs[0].wait(20)
    assert said(panel, "A person walks. · ")
    assert said(panel, "fits the prompt 0.50")
