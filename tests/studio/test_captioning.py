"""Takes that are looked at are put into words, once, after they are shown."""

from __future__ import annotations

import pytest

from engines import registry
from studio import captions
from studio.captioning import kept
from studio.captions import Description
from studio.library import open_library
from studio.session import Session
from studio.views.inspector import describe
from studio.views.takes import card


@pytest.fixture
def asked(engine, monkeypatch):
    """The prompts of every call; each motion's sentence says its length, and that the left hand is raised."""
    calls: list[list[str]] = []

    def say(motions, prompts):
        calls.append(list(prompts))
        assert len(motions) == len(prompts)
        sentences = [f"A person raises the left hand for {motion.frames} frames." for motion in motions]
        return [
            Description(said, 0.8, 0.7 if prompt else None) for said, prompt in zip(sentences, prompts, strict=True)
        ]

    monkeypatch.setattr(captions, "describe", say)
    monkeypatch.setattr(registry, "captioners", lambda: {"fake": "a stand-in"})
    return calls


@pytest.fixture
def drawn(asked, session, settle):
    session.start()
    settle(session)
    return session


def test_every_take_of_a_draw_gets_its_sentence_once(drawn, asked, settle):
    assert asked == [[""] * 4]
    said = drawn.captioning.of(drawn.state.take("take-1"))
    assert said.sentence == "A person raises the left hand for 60 frames."
    drawn.select("take-3")
    drawn.state.stage_mode = "one"
    settle(drawn)
    assert len(asked) == 1


def test_it_is_shown_with_the_take_and_told_to_screen_readers(drawn):
    take = drawn.state.take("take-1")
    said = drawn.captioning.of(take)
    assert "A person raises the left hand" in describe(take, {}, said)
    assert "Caption fits" in describe(take, {}, said)
    shown = card(take, {}, said)
    assert shown["caption"] == said.sentence
    assert shown["measures"] == [], "a card has room for how well a prompt is met alone"


def test_of_a_prompt_it_is_said_how_well_it_is_met(constrained, asked, queue, settle):
    session = Session(queue=queue)
    session.start()
    settle(session)
    session.state.param.update(compose_tab="text", prompt="hop")
    session.generate()
    settle(session)
    assert asked[-1] == ["hop"] * 4
    take = session.state.take()
    assert take is not None
    shown = card(take, {}, session.captioning.of(take))
    assert shown["measures"][0]["word"] == "prompt 0.70"
    session.close()


def test_a_mirrored_take_has_its_sides_exchanged(drawn):
    drawn.editing.set("take-1", ["mirror"])
    said = drawn.captioning.of(drawn.state.take("take-1"))
    assert said.sentence == "A person raises the right hand for 60 frames."
    assert said.prompt_fit is None


def test_nothing_is_said_where_it_is_switched_off(asked, session, settle):
    session.state.describing = False
    session.start()
    settle(session)
    assert asked == []
    session.state.describing = True
    settle(session)
    assert len(asked) == 1


def test_it_is_kept_with_the_project_and_found_again_only_for_what_lacks_a_sentence(asked, queue, settle, tmp_path):
    library = open_library(str(tmp_path / "library.db"))
    first = Session(queue=queue, library=library)
    first.start()
    settle(first)
    key, said = first.state.project, dict(first.state.captions)
    first.close()
    library.shelf(key).keep_captions({2: Description(prompt_fit=0.5).to_json()})
    assert {**said, "take-2": Description(prompt_fit=0.5)} == kept(library.shelf(key))
    again = Session(queue=queue, library=library)
    again.start(key)
    settle(again)
    assert asked == [[""] * 4, [""]], "take 2 had no sentence yet"
    assert again.state.captions == said
    again.close()
    library.close()


def test_what_cannot_be_described_is_shown_all_the_same(session, settle, monkeypatch):
    def fail(_motions, _prompts):
        raise ValueError("no words")

    monkeypatch.setattr(captions, "describe", fail)
    session.start()
    settle(session)
    take = session.state.take()
    assert card(take, {}, session.captioning.of(take))["caption"] == ""
    assert not session.state.generate_error
