"""What a session makes of a take in another manner: by name, like another, by chance, off a map."""

from __future__ import annotations

import json

import numpy as np
import pytest

from engines import registry
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from studio import edits, tasks
from studio.given import FARTHEST, Given
from studio.session import Session
from studio.settings import BLEND_STEPS, GenerateSettings, Settings, parse_settings
from tests.studio.fakes import FakeStyliser, sway


@pytest.fixture
def styled(engine, queue, settle, monkeypatch):
    """A session with four takes, on the tab of styles."""
    fake, other = FakeStyliser(), tasks.load_engine
    monkeypatch.setattr(registry, "stylisers", lambda: {fake.name: "a stand-in"})
    monkeypatch.setattr(tasks, "load_engine", lambda name, variant="": fake if name == fake.name else other(name))
    session = Session(queue=queue)
    session.start()
    settle(session)
    session.state.compose_tab = "style"
    settle(session)
    session.fake = fake
    yield session
    session.close()


def of(session) -> Given:
    return session.takes.get("take-5").settings.given


def test_a_motion_survives_as_text_to_a_millionth():
    motion = sway(frames=33).labelled("old", "style")
    given = Given.of(motion, "take 2", 30.0)
    read = Given.from_json(json.loads(json.dumps(given.to_json())))
    assert read == given
    assert (given.source, given.fps, given.motion.labels) == ("take 2", 30.0, motion.resample(30.0).labels)
    np.testing.assert_allclose(given.motion.positions, motion.resample(30.0).positions, atol=1e-5)
    assert read.motion.rotations.tobytes() == given.motion.rotations.tobytes()


@pytest.mark.parametrize(
    ("change", "problem", "says"),
    [
        ({"values": "eJw="}, OutOfRangeError, "damaged"),
        ({"values": "é"}, OutOfRangeError, "damaged"),
        ({"frames": 9}, OutOfRangeError, "9 frames"),
        ({"frames": True}, OutOfRangeError, "frames"),
        ({"fps": 0}, OutOfRangeError, "1 to 240"),
        ({"labels": [[0, 5, "mood", "old"]]}, OutOfRangeError, "label"),
        ({"value": ""}, UnknownLabelError, "'values'"),
    ],
)
def test_what_is_no_motion_is_refused_in_words(change, problem, says):
    tree = Given.of(sway(frames=20)).to_json() | change
    with pytest.raises(problem, match=says):
        Given.from_json(tree)


def test_a_motion_far_away_is_refused():
    with pytest.raises(OutOfRangeError, match=f"up to {FARTHEST:,.0f} m"):
        Given.of(sway().moved((2 * FARTHEST, 0, 0)), "take 1")


def test_the_tab_builds_on_what_the_engine_says(styled):
    state = styled.styling.state
    assert (state.ready, state.styles, state.source) == (True, ["happy", "old", "tired"], "take-1")
    assert styled.styling.problem() == "Choose a style."
    state.style = "old"
    assert styled.styling.problem() == ""
    assert styled.styling.forecast() == "1 take of 3.0 s · old × 1"


def test_a_take_in_a_style_stands_beside_the_take(styled, settle):
    state = styled.styling.state
    state.param.update(style="old", strength=0.5, count=2, source="take-2")
    styled.styling.stylise()
    settle(styled)
    made = [styled.takes.get(f"take-{n}") for n in (5, 6)]
    assert (styled.state.compared, styled.state.shown) == (["take-2", "take-5", "take-6"],) * 2
    assert (styled.state.selected, styled.state.stage_mode) == ("take-5", "compare")
    assert [take.edits for take in made] == [("feet",), ("feet",)]
    assert made[0].subject == "walk, old"
    assert (made[1].settings.take, made[0].settings.given.source) == (2, "take 2")
    assert made[0].motion.provenance.prompt == "walk"
    settings = parse_settings(Settings(made[1].settings).to_json()).generate
    (again,) = tasks.generate(settings)
    assert again.rotations.tobytes() == made[1].motion.rotations.tobytes()
    assert state.source == "take-2", "what came of it is only looked at"
    styled.state.selected = "take-3"
    assert state.source == "take-3", "another take is the next"
    styled.undo()
    assert [take.id for take in styled.takes] == ["take-1", "take-2", "take-3", "take-4"]


def test_strength_nothing_is_the_take_itself_and_a_held_seed_the_same_again(styled, settle):
    state = styled.styling.state
    state.param.update(style="old", strength=0.0, feet=False)
    styled.state.param.update(seed=41, seed_locked=True)
    for _ in range(2):
        styled.styling.stylise()
        settle(styled)
    first, second = (styled.takes.get(f"take-{n}") for n in (5, 6))
    np.testing.assert_allclose(
        first.motion.positions, styled.takes.get("take-1").motion.resample(30).positions, atol=1e-5
    )
    assert first.motion.rotations.tobytes() == second.motion.rotations.tobytes()
    assert (first.settings.seed, first.edits) == (41, ())
    styled.again("take-6")
    settle(styled)
    assert styled.takes.get("take-7").settings.given == first.settings.given
    assert styled.takes.get("take-7").settings.seed != 41
    assert styled.state.compared == ["take-1", "take-7"]


def test_the_take_is_taken_as_it_is_shown(styled, settle):
    styled.editing.set("take-1", ["mirror"])
    styled.styling.state.param.update(style="old", strength=0.0, feet=False)
    styled.styling.stylise()
    settle(styled)
    mirrored = edits.apply(styled.takes.get("take-1").motion, ["mirror"]).resample(30)
    np.testing.assert_allclose(of(styled).motion.positions, mirrored.positions, atol=1e-5)


def test_like_a_file_that_is_dropped(styled, settle, tmp_path):
    state = styled.styling.state
    state.way = "like"
    assert styled.styling.wants_a_file()
    assert styled.styling.problem().startswith("Choose a take")
    path = sway("wave", frames=50).write(tmp_path / "wave.bvh")
    data = path.read_bytes()
    message = {"id": "k", "name": "wave.bvh", "start": 0, "size": len(data), "data": data}
    styled.files.receive(message, styled.styling.refer)
    settle(styled)
    assert (state.like, styled.state.selected, state.source) == ("take-5", "take-1", "take-1")
    styled.styling.stylise()
    settle(styled)
    take = styled.takes.get("take-6")
    assert take.subject == "walk, as in take 5"
    assert (styled.fake.calls[-1]["style"], styled.fake.calls[-1]["like"]) == (None, len(take.settings.like.motion))


def test_by_chance(styled, settle):
    styled.styling.state.param.update(way="chance", style="old")
    styled.styling.stylise()
    settle(styled)
    assert styled.fake.calls[-1]["style"] is None
    assert styled.takes.get("take-5").subject == "walk, a surprise"


def test_what_cannot_be_is_said_and_nothing_is_lost(styled, settle):
    short = sway(frames=3)
    styled.files.import_file("short.npz", b"")
    styled.shelve(styled.takes.add([short], group="g", source="short.bvh"), styled.takes)
    settle(styled)
    styled.styling.state.style = "old"
    styled.styling.stylise()
    settle(styled)
    assert "8 to 18,000" in styled.state.generate_error
    styled.shelve(styled.takes.add([sway().moved((5000, 0, 0))], group="h", source="far.bvh"), styled.takes)
    settle(styled)
    styled.styling.stylise()
    settle(styled)
    assert "5,0" in styled.state.generate_error and "m away" in styled.state.generate_error
    assert len(styled.takes) == 6


def test_settings_that_contradict_themselves(styled):
    given = Given.of(sway())
    with pytest.raises(MotionloomError, match="only changes motions"):
        tasks.generate(GenerateSettings(engine="restyler"))
    with pytest.raises(MotionloomError, match="cannot put a motion in another manner"):
        tasks.generate(GenerateSettings(engine="fake", given=given))
    with pytest.raises(UnknownLabelError, match="'old'"):
        tasks.generate(GenerateSettings(engine="restyler", given=given, style="odl"))
    with pytest.raises(OutOfRangeError, match="strength"):
        GenerateSettings(given=given, strength=1.6)


def test_the_map_shows_every_style_and_what_lies_between(styled, settle):
    styling = styled.styling
    styling.state.way = "map"
    styling.map.draw()
    settle(styled)
    drawn = styling.map.state
    assert drawn.names == ["happy", "happy", "old", "old", "tired", "tired"]
    assert (drawn.subject, len(drawn.points), drawn.error) == ("take 1", 6, "")
    styling.map.move(*drawn.points[2])
    (title, before), (words, after) = styled.state.preview
    assert (title, words) == ("Take 1", "Old")
    assert len(before) != len(after), "at its own rate"
    a, b = np.array(drawn.points)[[1, 2]]
    styling.map.move(*(0.5 * a + 0.5 * b))
    settle(styled)
    assert drawn.words == "50 % from happy to old"
    assert len(drawn.line) == BLEND_STEPS
    styling.state.way = "like"
    assert styled.state.preview == ()
    styling.state.way = "map"
    assert len(styled.state.preview) == 2, "it is shown again"
    styling.map.keep()
    settle(styled)
    take = styled.takes.get("take-5")
    assert take.settings.blend["style"] == "old"
    assert (take.subject, take.edits, styled.state.compared) == ("walk, happy to old", ("feet",), ["take-1", "take-5"])
    (again,) = tasks.generate(parse_settings(Settings(take.settings).to_json()).generate)
    assert again.rotations.tobytes() == take.motion.rotations.tobytes()
    styling.state.source = "take-2"
    assert (drawn.points, styled.state.preview) == ([], ()), "another take has another map"
