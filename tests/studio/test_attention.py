"""Words and tokens under the timeline: of the picked take, worked out when they are open."""

from __future__ import annotations

import numpy as np
import pytest

from engines import SMPL22
from engines.text2motion.engine import WordAttention
from studio import attention, captions, tasks
from studio.attention import flat, token_strip, whole_words, word_heat
from studio.session import Session
from tests.engines.text2motion import tiny as text2motion
from tests.engines.tm2t import tiny
from tests.studio.fakes import ConstrainedEngine, sway

PROMPT = "A person does throw."


class ListeningEngine(ConstrainedEngine):
    """Looks at each word in turn."""

    capabilities = ConstrainedEngine.capabilities | {"word_attention"}

    def attention(self, motion):
        words = ("", *motion.provenance.prompt.split(), "")
        return WordAttention(words, np.eye(len(words), dtype=np.float32), 4)


@pytest.fixture
def listened(engine, queue, settle, monkeypatch):
    """A session that drew takes of a sentence by an engine that attends to words."""
    listening = ListeningEngine()
    monkeypatch.setattr(tasks, "load_engine", lambda *_: listening)
    session = Session(queue=queue)
    session.state.describing = False
    session.start()
    settle(session)
    session.state.param.update(compose_tab="text", prompt="walk and wave")
    session.generate()
    settle(session)
    yield session
    session.close()


def test_words_are_shown_under_a_take_of_words_alone(listened, settle):
    strips = listened.state.strips
    assert strips["words"]["text"] == ["walk"]  # what `sway` says it was made of
    assert len(strips["words"]["weights"]) == 3
    assert strips["words"]["seconds"] == 0.2
    assert "tokens" not in strips, "no weights have tokens"


def test_tokens_are_worked_out_once_they_are_open(listened, settle, monkeypatch):
    engine = tiny.engine()
    monkeypatch.setattr(captions, "captioner", lambda: engine)
    listened.select("take-6")
    settle(listened)
    assert listened.state.strips["tokens"] == {}
    listened.state.open_strips = "words,tokens"
    settle(listened)
    tokens = listened.state.strips["tokens"]
    assert tokens["codes"] == engine.tokens(listened.state.take().motion).tolist()
    assert set(tokens["figures"]["points"]) == set(map(str, tokens["codes"]))
    listened.state.open_strips = "tokens,all"
    settle(listened)
    assert len(listened.state.strips["tokens"]["figures"]["points"]) == tokens["all"] == 12
    listened.state.selected = ""
    assert listened.state.strips == {}


def test_what_was_worked_out_is_kept_at_hand(listened, settle, monkeypatch):
    calls = []
    monkeypatch.setattr(attention, "strips", lambda take, *_: calls.append(take.id) or {})
    for take in ("take-6", "take-7", "take-6"):
        listened.select(take)
        settle(listened)
    assert calls == ["take-6", "take-7"]


@pytest.mark.parametrize("make", [tiny.engine, text2motion.engine])
def test_weights_of_a_word_are_those_of_its_pieces(make):
    engine = make()
    motion = engine.generate_many(prompt=PROMPT, count=1, frames=24)[0]
    heat, known = word_heat(engine, motion), engine.attention(motion)
    assert heat is not None
    assert heat["text"] == ["a", "person", "does", "throw"]
    assert heat["seconds"] * len(heat["weights"]) == pytest.approx(motion.duration)
    first = known.words.index("a")
    np.testing.assert_allclose(np.array(heat["weights"]), known.weights[:, first : first + 4], atol=1e-3)


def test_of_other_motions_no_word_is_known():
    assert word_heat(tiny.engine(), sway()) is None


def test_pieces_become_words_and_marks_are_left_out():
    assert whole_words(("", "cart", "##wheel", "##ing", ",", "slowly", ".", "")) == (
        ["cartwheeling", "slowly"], [[1, 2, 3], [5]],
    )  # fmt: skip


def test_a_long_motion_is_taken_apart_up_to_a_minute():
    engine = tiny.engine()
    assert len(token_strip(engine, sway(frames=1400))["codes"]) == 300
    assert len(token_strip(engine, sway(frames=40))["codes"]) == 10


def test_figures_stand_upright_in_the_middle_of_their_box():
    points = flat(sway(frames=4).positions[None])
    x, y = points[..., 0::2], points[..., 1::2]
    assert points.min() >= 0
    assert points.max() <= 100
    assert abs(x[0, :, 0].mean() - 50) <= 3
    assert (y[0, :, SMPL22.index("head")] > y[0, :, SMPL22.index("left_foot")] + 60).all()
