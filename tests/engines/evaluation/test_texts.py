"""Text2Motion's protocol on made-up clips: what is asked, seeds, what an engine that gives the real motions scores."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.datasets import Clip
from engines.datasets.captions.encoded import HELD_OUT_SEED
from engines.errors import Cancelled, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation import Results, TextBench, TextOptions, evaluate, texts
from engines.evaluation.rounds import REAL
from engines.metrics.evaluators import CoEmbedding
from engines.metrics.protocol import TEXT2MOTION
from engines.motion import Motion
from tests.engines.action2motion.tiny import movement

SIZE = 8
OPTIONS = TextOptions(motions=64, seed=3)


def clips() -> list[Clip]:
    """72 held-out clips, most of two kinds, and one for training."""
    made = []
    for i in range(73):
        action = "walk" if i % 2 else "turn left"
        motion = movement(25 + i % 7, seed=i, turning=0.2 if i % 2 else 3.0)
        split = "train" if i == 72 else "val" if i % 3 else "test"
        made.append(Clip("cmu", f"{i}", action, None, None, None, split, motion))  # pyright: ignore[reportArgumentType]
    return made


KNOWN = clips()


def captions(clip: Clip, seed: int) -> list[str]:
    """Three sentences that are said of no other clip."""
    return [f"The {way} way of {clip.name} with seed {seed}{' and more' * bool(clip.sentences)}." for way in "abc"]


class Judge(CoEmbedding):
    """Knows the real clips and their captions by heart; anything else is far from all."""

    def __init__(self) -> None:
        rng = np.random.default_rng(0)
        points = rng.normal(size=(len(KNOWN), SIZE))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        self.seen = {clip.motion.rotations.tobytes(): point for clip, point in zip(KNOWN, points, strict=True)}
        self.said = {text: p for clip, p in zip(KNOWN, points, strict=True) for text in captions(clip, HELD_OUT_SEED)}

    def motions(self, motions) -> np.ndarray:
        return np.stack([self.seen.get(m.rotations.tobytes(), np.zeros(SIZE)) for m in motions])

    def texts(self, sentences) -> np.ndarray:
        return np.stack([self.said[sentence] for sentence in sentences])


class Memory:
    """An engine that remembers the real motion of every sentence."""

    name, licence, weights_hash, capabilities = "memory", "none", "1" * 64, frozenset({"text"})

    def __init__(self) -> None:
        self.asked: list[dict] = []
        self.clips = {text: clip for clip in KNOWN for text in captions(clip, HELD_OUT_SEED)}

    def generate_many(self, *, prompt: str, count: int, frames: int, seed: int) -> list[Motion]:
        self.asked.append({"prompt": prompt, "count": count, "frames": frames, "seed": seed})
        return [self.clips[prompt].motion] * count


class Deaf(Memory):
    """One that gives the same motion whatever is said."""

    def generate_many(self, *, prompt: str, count: int, frames: int, seed: int) -> list[Motion]:
        return [KNOWN[0].motion] * count


@pytest.fixture(autouse=True)
def _said(monkeypatch) -> None:
    monkeypatch.setattr(texts, "captions", captions)


@pytest.fixture
def bench(_said) -> TextBench:
    return TextBench({"memory": Memory()}, KNOWN, Judge(), OPTIONS)


def run(bench: TextBench, engines: dict, path=None, repeats: int = 2, **options) -> Results:
    results = Results(bench.basis("0" * 64), ())
    if path:
        results.go_on_from(path)
    evaluate(bench, engines, results, repeats=repeats, finished=lambda _: path and results.save(path), **options)
    return results


def test_every_sentence_is_of_another_held_out_clip(bench) -> None:
    first, again = bench.prompts(0), bench.prompts(0)
    assert first == again != bench.prompts(1)
    assert len({prompt.clip for prompt in first}) == len(first) == 64
    for prompt in first:
        clip = bench.clips[prompt.clip]
        assert clip.split in ("val", "test")
        assert prompt.sentence in captions(clip, HELD_OUT_SEED)
        assert prompt.frames == len(clip.motion)
    assert len({prompt.seed for prompt in first}) == 64
    assert TextBench({"memory": Memory()}, KNOWN, Judge(), replace(OPTIONS, seed=4)).prompts(0) != first


def test_the_engine_is_asked_for_just_that(bench) -> None:
    engine = Memory()
    heard = []
    run(bench, {"memory": engine}, repeats=1, progress=lambda *now: heard.append(now))
    single = [asked for asked in engine.asked if asked["count"] == 1]
    assert [a["prompt"] for a in single] == [prompt.sentence for prompt in bench.prompts(0)]
    assert [a["seed"] for a in single] == [prompt.seed for prompt in bench.prompts(0)]
    many = [asked for asked in engine.asked if asked["count"] > 1]
    assert [a["count"] for a in many] == [TEXT2MOTION.motions_a_prompt] * 2
    assert heard[-1] == (64 + 60, 64 + 60, "memory")


def test_real_motions_score_as_the_real_row_and_one_for_all_by_chance(bench) -> None:
    results = run(bench, {"memory": Memory(), "deaf": Deaf()})
    real, memory, deaf = (results.rows[name].estimates for name in (REAL, "memory", "deaf"))
    assert "multimodality" not in real
    for name, found in real.items():
        assert memory[name].values == pytest.approx(found.values), name
    assert memory["multimodality"].mean == 0.0  # it knows one motion a sentence
    assert memory["r_precision_top1"].mean == 1.0
    assert memory["multimodal_distance"].mean == 0.0
    assert deaf["r_precision_top3"].mean < 0.2
    assert deaf["diversity"].mean == 0.0
    assert deaf["fid"].mean > real["fid"].mean > 0
    assert deaf["multimodal_distance"].mean > memory["multimodal_distance"].mean
    assert {"jitter", "foot_skate"} <= set(memory)


def test_stopping_and_going_on_gives_the_same(bench, tmp_path) -> None:
    whole = run(bench, {"memory": Memory()}, repeats=2)
    path = tmp_path / "rows.json"
    calls = iter(range(10_000))
    with pytest.raises(Cancelled, match="repeat 2 of memory"):
        run(bench, {"memory": Memory()}, path, repeats=2, cancel=lambda: next(calls) > 100)
    resumed = run(bench, {"memory": Memory()}, path, repeats=2)
    for name, row in whole.rows.items():
        assert [r.figures for r in resumed.rows[name].repeats] == [r.figures for r in row.repeats]


def test_what_cannot_be_judged() -> None:
    mute = Memory()
    mute.capabilities = frozenset({"actions"})
    with pytest.raises(MotionloomError, match=r"takes no text.*can do: actions"):
        TextBench({"mute": mute}, KNOWN, Judge(), OPTIONS)
    with pytest.raises(OutOfRangeError, match="engines"):
        TextBench({}, KNOWN, Judge(), OPTIONS)
    with pytest.raises(OutOfRangeError, match="number of held-out clips is 40"):
        TextBench({"memory": Memory()}, KNOWN[:40], Judge(), OPTIONS)
    with pytest.raises(OutOfRangeError, match="motions is 63"):
        TextOptions(motions=63).check()
    with pytest.raises(UnknownLabelError, match="held-out"):
        TextOptions(data="holdout").check()  # pyright: ignore[reportArgumentType]


def test_the_basis_changes_with_what_is_said(bench) -> None:
    other = [replace(KNOWN[0], sentences=("He strolls about",)), *KNOWN[1:]]
    assert TextBench({"memory": Memory()}, other, Judge(), OPTIONS).basis("0")["clips"] != bench.basis("0")["clips"]
