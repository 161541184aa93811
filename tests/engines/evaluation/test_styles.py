"""Generative stylization's protocol on made-up clips: what is asked, seeds, what perfect and idle engines score."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.datasets import Clip
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation import Results, StyleBench, StyleOptions, evaluate, tables
from engines.evaluation.rounds import REAL
from engines.metrics.evaluators import Recogniser
from engines.metrics.recognition import Recognised
from engines.motion import LabelKind, Motion, Segment
from tests.engines.action2motion.tiny import movement

STYLES = ("elderly", "proud")
ACTIONS = ("run", "walk")
OPTIONS = StyleOptions(motions=12, seed=3)


def clips() -> list[Clip]:
    """Held-out clips of two contents in two styles, a style in training alone, and a clip of another corpus."""
    made = []
    for i in range(16):
        motion = movement(24 + i, seed=i, turning=1.0)
        style, action = STYLES[i % 2], ACTIONS[(i // 2) % 2]
        made.append(Clip("bandai-namco", f"{i}", action, style, None, None, "val" if i % 3 else "test", motion))
    made.append(Clip("bandai-namco", "t", "walk", "tired", None, None, "train", movement(30, seed=50)))
    made.append(Clip("cmu", "c", "climb", None, None, None, "test", movement(30, seed=51)))
    return made


KNOWN = clips()


class Judge(Recogniser):
    """Reads a motion's labels; of the real clips it knows them by their length."""

    def __init__(self, kind: LabelKind, labels: tuple[str, ...]) -> None:
        self.kind, self.labels = kind, labels
        self.real = {len(clip.motion): getattr(clip, kind) for clip in KNOWN}

    def recognised(self, motions) -> Recognised:
        said = [motion.label_at(0, self.kind) or self.real.get(len(motion)) for motion in motions]
        logits = np.array([[float(name == label) for label in self.labels] for name in said])
        length = np.array([[len(motion)] for motion in motions], dtype=float)
        return Recognised(features=np.concatenate([logits, 0.01 * length], axis=1), logits=logits)


class Engine:
    """Says that a motion has the style, and leaves it as it is; `deaf` says always the same one."""

    name, licence, weights_hash = "says", "none", "1" * 64
    capabilities = frozenset({"stylise", "styles", "references"})
    styles = (*STYLES, "tired")

    def __init__(self, deaf: bool = False) -> None:
        self.deaf = deaf
        self.asked: list[dict] = []

    def stylise(self, motion: Motion, style: str = "proud", *, like=None, count: int = 1, seed: int = 0):
        self.asked.append({"style": style, "like": like, "count": count, "seed": seed, "frames": len(motion)})
        action = next(clip.action for clip in KNOWN if len(clip.motion) == len(motion))
        said = {"style": "proud" if self.deaf else style, "action": str(action)}
        return [
            motion.replaced(labels=tuple(Segment(0, len(motion), kind, name) for kind, name in said.items()))
        ] * count


def bench(engine: Engine, options: StyleOptions = OPTIONS) -> StyleBench:
    return StyleBench({"e": engine}, KNOWN, Judge("style", (*STYLES, "tired")), Judge("action", ACTIONS), options)


def figures(engine: Engine, options: StyleOptions = OPTIONS) -> tuple[dict, Results]:
    made = bench(engine, options)
    results = Results(made.basis("0" * 64), ())
    evaluate(made, {"e": engine}, results, repeats=2)
    return {name: row.estimates for name, row in results.rows.items()}, results


def test_the_same_is_asked_again_and_other_things_of_another_repeat():
    made = bench(Engine())
    assert made.wishes(0) == bench(Engine()).wishes(0) != made.wishes(1)
    assert made.styles == STYLES, "tired has no held-out clip"
    assert made.left_out == {"without a held-out clip": ("tired",)}
    asked = made.wishes(0)
    assert sorted(wish.style for wish in asked) == ["elderly"] * 6 + ["proud"] * 6
    assert all(made.styled[wish.reference].style == wish.style for wish in asked)
    assert {clip.split for clip in [*made.contents, *made.styled]} == {"val", "test"}


def test_an_engine_that_does_it_and_one_that_does_not():
    good, results = figures(Engine())
    assert good["e"]["style_accuracy"].mean == good["e"]["content_accuracy"].mean == 1.0
    assert good["e"]["pose_distance"].mean == pytest.approx(0.0, abs=1e-6)
    assert good["e"]["multimodality"].mean == 0.0, "it does the same each time"
    assert good[REAL]["style_accuracy"].mean == 1.0
    assert "content_accuracy" not in good[REAL]
    deaf, _ = figures(Engine(deaf=True))
    assert deaf["e"]["style_accuracy"].mean == 0.5
    assert deaf["e"]["style_fid"].mean > good["e"]["style_fid"].mean
    text = tables.markdown(results, results.shown(["e"], 2), {})
    assert "Style accuracy ↑" in text and "thesis, table 5.2" in text and "Content accuracy and FID" in text


@pytest.mark.parametrize(("by", "told"), [("label", {"style"}), ("motion", {"style", "like"}), ("prior", set())])
def test_what_an_engine_is_told(by, told):
    engine = Engine()
    options = replace(OPTIONS, by=by)
    made = bench(engine, options)
    wish = made.wishes(0)[0]
    made.make(engine, wish)
    asked = engine.asked[0]
    assert (asked["style"] == wish.style) or "style" not in told
    assert (asked["like"] is not None) == ("like" in told)
    found, _ = figures(engine, options)
    assert ("style_accuracy" in found["e"]) == (by != "prior")


class Hurried(Engine):
    """Leaves out every other frame where it may."""

    capabilities = Engine.capabilities | {"tempo"}

    def stylise(self, motion: Motion, style: str = "proud", *, tempo: bool = False, **told):
        return [
            made[::2].replaced(fps=motion.fps) if tempo else made for made in super().stylise(motion, style, **told)
        ]


def test_tempo_is_asked_of_engines_that_have_it_and_poses_are_then_not_compared():
    options = replace(OPTIONS, tempo=True)
    found, results = figures(Hurried(), options)
    assert "pose_distance" not in found["e"] and found["e"]["style_accuracy"].mean == 1.0
    assert "as fast as" in tables.markdown(results, results.shown(["e"], 2), {})
    made = bench(Hurried(), options)
    wish = made.wishes(0)[0]
    assert len(made.make(Hurried(), wish)[0]) == -(-len(made.content(wish)) // 2)
    assert len(made.make(Engine(), wish)[0]) == len(made.content(wish))


def test_motions_of_another_corpus_have_no_content_that_is_known():
    found, results = figures(Engine(), replace(OPTIONS, corpus="cmu"))
    assert "content_accuracy" not in found["e"]
    assert "contents are not counted" in tables.markdown(results, results.shown(["e"], 2), {})


def test_what_cannot_be_judged():
    class Walker:
        capabilities = frozenset({"actions"})

    with pytest.raises(MotionloomError, match="lacks styles and stylise"):
        StyleBench({"w": Walker()}, KNOWN, Judge("style", STYLES), Judge("action", ACTIONS), OPTIONS)
    with pytest.raises(UnknownLabelError, match="moon"):
        bench(Engine(), replace(OPTIONS, corpus="moon"))
    with pytest.raises(UnknownLabelError, match="way to tell"):
        bench(Engine(), replace(OPTIONS, by="hope"))
    with pytest.raises(OutOfRangeError, match="motions"):
        bench(Engine(), replace(OPTIONS, motions=1))
