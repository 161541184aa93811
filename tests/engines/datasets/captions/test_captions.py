"""Captions: their grammar, and that their words for sides, turns and counts are true of the motion."""

from __future__ import annotations

import re
import tarfile
from dataclasses import replace
from pathlib import Path
from random import Random
from string import Formatter

import numpy as np
import pytest

from engines import actions
from engines.datasets import CORPORA, Clip
from engines.datasets.captions import LEAST, captions, described, grammar, phrases, styles
from engines.datasets.captions.measure import Facts
from engines.datasets.captions.wording import fields
from engines.geometry import rotations
from engines.geometry.mirror import mirror_words
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.datasets.folders import wave

_SET = "dataset/Bandai-Namco-Research-Motiondataset-{0}/data/dataset-{0}_{1}.bvh"
_REAL = [
    (2, name)
    for content in ("raise-up-left-hand", "raise-up-right-hand", "wave-left-hand", "wave-right-hand",
                    "wave-both-hands", "walk-turn-left", "walk-turn-right", "run")
    for name in (f"{content}_normal_001", f"{content}_active_001")
] + [(1, f"{content}_normal_001") for content in ("walk-left", "walk-right", "walk-back", "bow", "walk")]  # fmt: skip


@pytest.fixture(scope="module")
def real(shared_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Clip]:
    """Real clips of sided contents, and each of them in the mirror."""
    folder = tmp_path_factory.mktemp("sided")
    wanted = {_SET.format(number, name) for number, name in _REAL}
    with tarfile.open(shared_dir / "data" / "bandai-namco-motiondataset.tar.xz") as tar:
        for member in tar:
            if member.name in wanted:
                tar.extract(member, folder, filter="data")
                wanted.remove(member.name)
                if not wanted:
                    break
    corpus, found = CORPORA["bandai-namco"], []
    for info in corpus.clips(folder):
        motion = corpus.read(info)
        found.append(Clip(info.corpus, info.name, info.action, info.style, None, info.text, "train", motion))
    assert len(found) > 15
    return [*found, *(clip.mirror() for clip in found)]


def clip_of(motion: Motion, action: str | None, **facts) -> Clip:
    known = {"corpus": "test", "name": "x", "style": None, "subject": None, "text": None, "split": "train"}
    return Clip(**{**known, **facts}, action=action, motion=motion)  # type: ignore[arg-type]


def walk_in_a_circle(degrees: float, frames: int = 80) -> Motion:
    """A body that goes along an arc, turning by so much, to the left if positive."""
    yaw = np.linspace(0, np.radians(degrees), frames)
    turns = np.tile(rotations.IDENTITY, (frames, len(SMPL22), 1))
    turns[:, 0] = rotations.yaw_quaternion(yaw)
    swing = 0.45 * np.sin(np.arange(frames) / 20 * 2 * np.pi)
    for side, sign in (("left", 1), ("right", -1)):
        bend = np.stack([sign * swing, np.zeros(frames), np.zeros(frames)], axis=-1)
        turns[:, SMPL22.index(f"{side}_hip")] = rotations.rotvec_to_quaternion(bend)
    path = np.cumsum(np.stack([np.sin(yaw), np.zeros(frames), np.cos(yaw)], axis=-1) * 0.06, axis=0)
    return Motion(SMPL22, turns, path + np.array([0, 0.95, 0]), 20.0)


# ---- grammar of what comes out ----------------------------------------------------------------------------------


@pytest.mark.parametrize("action", [action.name for action in actions.VOCABULARY] + [None])
def test_every_action_gets_enough_distinct_grammatical_sentences(action: str | None) -> None:
    for style in ("angry", None):
        said = captions(clip_of(wave(), action, style=style))
        assert len(said) == len(set(said)) >= LEAST
        for text in said:
            check_grammar(text)


def check_grammar(text: str) -> None:
    assert re.fullmatch(r"[A-Z][A-Za-z0-9é' ,-]*\.", text), text
    assert not re.search(r"\btak(es|ing)\b.*\btak(es|ing)\b", text), text
    assert grammar.doubled(text) is None, text
    assert "  " not in text
    assert " ," not in text
    assert grammar.articles(text) == text, "a and an fit"
    assert not re.search(r"[\[\]{}]", text), "no field is left open"


def test_the_vocabulary_has_phrases_and_only_known_fields() -> None:
    assert set(phrases.PHRASES) == {action.name for action in actions.VOCABULARY}
    known = {
        "going", "turning", "turn", "turned", "steps", "hand", "arm", "it", "to_height", "over", "swings", "sweep",
        "sense", "claps", "punches", "bends", "depth", "foot", "leg", "standing_foot", "standing_leg", "front_foot",
        "jumps", "a_jump", "ahead", "crouches", "across",
    }  # fmt: skip
    for table in (phrases.PHRASES, phrases.LABELS, phrases.HELD, {"any": phrases.ANY}):
        for action, row in table.items():
            used = [{name for _, name, _, _ in Formatter().parse(text) if name} for text in row]
            assert set().union(*used) <= known
            assert action.startswith("raise") or not all(used), f"{action} has nothing to say of an unclear motion"
            assert not any(re.search(r"\b(left|right)\b", text) for text in row), "sides are measured, not written"


def test_the_same_seed_gives_the_same_and_another_others() -> None:
    clip = clip_of(wave(), "wave left hand")
    assert captions(clip, seed=3) == captions(clip, seed=3)
    assert captions(clip, seed=3) != captions(clip, seed=4)
    assert len(captions(clip, count=24)) == 24


@pytest.mark.parametrize("style", sorted(styles.STYLES))
def test_styles_are_said_and_plain_ones_not(style: str) -> None:
    adjectives, manners = styles.words(style)
    assert manners
    said = " ".join(captions(clip_of(wave(), "wave left hand", style=style)))
    assert any(word in said for word in (*adjectives, *manners))
    plain = " ".join(captions(clip_of(wave(), "wave left hand", style="normal")))
    assert not any(f" {word} " in plain for word in (*adjectives, *manners))


def test_no_style_and_no_phrase_has_a_word_that_a_mirror_would_change() -> None:
    """ "With no strength left" would become right in the mirror, and be taken for a side."""
    for adjectives, manners in styles.STYLES.values():
        for words in (*adjectives, *manners):
            assert mirror_words(words) == words
    for table in (phrases.PHRASES, phrases.LABELS, phrases.HELD, {"any": phrases.ANY}):
        for text in (text for row in table.values() for text in row):
            assert mirror_words(text) == text


def test_a_style_unknown_here_is_said_all_the_same() -> None:
    assert "in an icy way" in " ".join(captions(clip_of(wave(), "walk", style="icy")))


# ---- truth: made motions ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("label", ["wave left hand", "wave right hand"])
def test_the_hand_that_moves_is_told_whatever_the_label_says(label: str) -> None:
    said = " ".join(captions(clip_of(wave(), label)))
    assert "left hand" in said
    assert "right" not in said


@pytest.mark.parametrize(("degrees", "words"), [(90, "to the left"), (-90, "to the right"), (0, None)])
def test_a_walk_that_turns_says_so(degrees: float, words: str | None) -> None:
    said = " ".join(captions(clip_of(walk_in_a_circle(degrees), "walk"), count=24))
    assert {side for side in ("to the left", "to the right") if side in said} == ({words} if words else set())
    assert "forward" in said


@pytest.mark.parametrize(
    ("degrees", "turned"),
    [
        (20, None),
        (90, "a quarter turn to the left"),
        (-180, "half a turn to the right"),
        (360, "a full turn to the left"),
    ],
)
def test_how_far_it_turns(degrees: float, turned: str | None) -> None:
    assert fields(Facts(walk_in_a_circle(degrees)), "turn left").get("turned") == turned


@pytest.mark.parametrize(
    ("yaw", "going"),
    [(0, "forward"), (180, "backward"), (90, "to the left"), (-90, "to the right"),
     (45, "diagonally forward to the left"), (-135, "diagonally backward to the right")],
)  # fmt: skip
def test_where_it_goes_is_seen_from_the_body(yaw: float, going: str) -> None:
    motion = walk_in_a_circle(0)
    way = np.array(motion.translation)
    length = way[:, 2].copy()
    way[:, 0], way[:, 2] = length * np.sin(np.radians(yaw)), length * np.cos(np.radians(yaw))
    moved = motion.replaced(translation=way)
    assert fields(Facts(moved), "walk")["going"] == going
    assert fields(Facts(moved.moved(yaw=2.0)), "walk")["going"] == going, "however it stands in the world"


def test_steps_are_counted() -> None:
    assert Facts(walk_in_a_circle(0)).steps == 8, "four seconds, two steps in each"


def test_a_still_body_is_said_to_hold_its_pose() -> None:
    still = wave()[0:1]
    held = still.concat(*[still] * 30)
    assert all(re.search("pose|still", text) for text in captions(clip_of(held, "dance")))


@pytest.mark.parametrize("action", [action.name for action in actions.VOCABULARY])
def test_a_body_that_does_nothing_gets_its_sentences_too(action: str) -> None:
    still = wave()[0:1].concat(*[wave()[0:1]] * 20)
    assert len(captions(clip_of(still, action))) >= LEAST


def test_punches_are_told_in_their_order() -> None:
    """Right, left, right: three thrusts of stretched arms from bent ones."""
    turns = np.tile(rotations.IDENTITY, (60, len(SMPL22), 1))
    bent = {side: np.full(60, 2.2) for side in ("left", "right")}
    for side, middle in (("right", 10), ("left", 28), ("right", 46)):
        bent[side] -= 2.1 * np.exp(-(((np.arange(60) - middle) / 3.0) ** 2))
    for side, sign in (("left", 1), ("right", -1)):
        forward = np.zeros((60, 3)) + np.array([0.0, -sign * 1.4, 0.0])
        turns[:, SMPL22.index(f"{side}_shoulder")] = rotations.rotvec_to_quaternion(forward)
        elbow = bent[side][:, None] * SMPL22.hinges[f"{side}_elbow"]
        turns[:, SMPL22.index(f"{side}_elbow")] = rotations.rotvec_to_quaternion(elbow)
    motion = Motion(SMPL22, turns, np.zeros((60, 3)) + np.array([0, 0.95, 0]), 20.0)
    assert Facts(motion).thrusts == ("right", "left", "right")
    assert "punches right, left and right" in " ".join(captions(clip_of(motion, "boxing"), count=40))


# ---- truth: real motions --------------------------------------------------------------------------------------------


@pytest.mark.data
def test_side_words_of_hands_agree_with_the_wrists(real: list[Clip]) -> None:
    """Each "left hand" and "right arm" against the higher wrist, read from the positions and not by `measure`."""
    seen = 0
    for clip in real:
        if not (clip.action or "").startswith(("raise", "wave")):
            continue
        left, right = (clip.motion.positions[:, SMPL22.index(f"{side}_wrist"), 1].max() for side in ("left", "right"))
        side = "both" if abs(left - right) < 0.25 else "left" if left > right else "right"
        for text in captions(clip):
            for word in re.findall(r"\b(left|right|both) (?:hand|arm)s?\b", text):
                seen += 1
                assert word == side, f"{clip.name}: {text}"
    assert seen > 200


@pytest.mark.data
def test_side_words_of_ways_and_turns_agree_with_the_path(real: list[Clip]) -> None:
    seen = 0
    for clip in real:
        motion = clip.motion
        if clip.action in {"turn left", "turn right"}:
            side = "left" if motion.heading[-1] > motion.heading[0] else "right"
        elif clip.action in {"walk left", "walk right"}:
            side = "left" if motion.positions[-1, 0, 0] > 0 else "right"  # clips begin at x = 0, facing +Z
        else:
            continue
        for text in captions(clip):
            for word in re.findall(r"to the (left|right)\b", text):
                seen += 1
                assert word == side, f"{clip.name}: {text}"
    assert seen > 60


@pytest.mark.data
def test_straight_walks_backward_walks_and_bows(real: list[Clip]) -> None:
    said = {clip.action: " ".join(captions(clip)) for clip in real if clip.action in {"walk", "walk backward", "bow"}}
    assert "forward" in said["walk"]
    assert "backward" in said["walk backward"]
    assert "forward" not in said["walk backward"]
    assert not re.search(r"\b(left|right)\b", said["bow"])


@pytest.mark.data
def test_mirroring_swaps_the_sides_and_nothing_else(real: list[Clip]) -> None:
    swapped = 0
    for clip in real[: len(real) // 2]:
        said, mirrored = captions(clip), captions(clip.mirror())
        assert mirrored == [mirror_words(text) for text in said], clip.name
        swapped += mirrored != said
    assert swapped > 10


@pytest.mark.data
def test_real_captions_are_grammatical(real: list[Clip]) -> None:
    for clip in real:
        for text in captions(clip, seed=5, count=24):
            check_grammar(text)


# ---- what people wrote -----------------------------------------------------------------------------------------------


def test_peoples_sentences_come_first_with_capital_and_stop() -> None:
    clip = clip_of(wave(), "walk", sentences=("a human  walks", "A human walks."))
    assert captions(clip)[0] == "A human walks."
    assert captions(clip).count("A human walks.") == 1


@pytest.mark.parametrize(
    ("text", "forms"),
    [
        ("playground - climb, hang, swing [fps 120.0]", ("climbs, hangs by the hands and swings", "playground")),
        ("dance - small jetes, pirouette", ("dances with small jetés and a pirouette",)),
        ("basketball - forward dribble, 90-degree left turns", ("makes quarter turns to the left",)),
        ("run/jog", ("jogs",)),
    ],
)  # fmt: skip
def test_cmu_descriptions_become_sentences(text: str, forms: tuple[str, ...]) -> None:
    said = [line for seed in range(6) for line in described.from_description(text, Random(seed), ("a person",))]
    for form in forms:
        assert any(form in line for line in said), said
    for line in said:
        check_grammar(line)


def test_a_description_not_understood_in_full_gives_none() -> None:
    for text in ("walk, juggle", "circus - walk", "", None, "walk-left"):
        assert described.from_description(text, Random(0), ("a person",)) == []


@pytest.mark.data
def test_every_description_of_the_cmu_clips_is_understood(shared_dir: Path) -> None:
    import json

    with tarfile.open(shared_dir / "data" / "cmu-mocap-subset.tar.xz") as tar:
        member = next(m for m in tar if m.name.endswith("manifest.json"))
        stream = tar.extractfile(member)
        assert stream is not None
        rows = json.load(stream)
    missed = {
        row["description"]
        for row in rows
        if not described.from_description(row["description"], Random(0), ("a person",))
    }
    assert missed == set()


def test_a_mirrored_clip_mirrors_what_was_written() -> None:
    clip = clip_of(wave(), None, corpus="cmu", text="basketball - forward dribble, 90-degree left turns",
                   sentences=("He turns Left.",))  # fmt: skip
    said = captions(clip.mirror())
    assert said[0] == "He turns Right."
    assert any("quarter turns to the right" in text for text in said)
    assert not any("quarter turns to the left" in text for text in said)


def test_a_clip_of_another_set_is_told_by_its_label() -> None:
    said = captions(replace(clip_of(wave(), None), label="drink"))
    assert any("drink" in text for text in said)
    assert any("left hand" in text for text in said)
