"""Sentences that describe a clip: what people wrote of it, and captions made from its action, style and measured facts.

    for text in captions(clip, seed=3): ...

Captions are drawn, not stored: the same clip and seed give the same sentences. Words for sides, directions, counts,
speeds and durations come from the motion itself (`measure`), so a mirrored clip gets the mirrored words, and a clip
labelled one way that moves another is described as it moves.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from random import Random
from string import Formatter
from typing import TYPE_CHECKING

from engines.datasets.captions import described, phrases, styles, wording
from engines.datasets.captions.grammar import doubled, inflect, sentence
from engines.datasets.captions.measure import Facts

if TYPE_CHECKING:
    from engines.datasets import Clip

COUNT = 16
"""Captions a clip made by the grammar, beside those that people wrote."""
LEAST = 12
"""At least this many are distinct, whatever the clip."""
_DRAWS = 40
"""Draws a caption wanted, before fewer are accepted."""

_PEOPLE = ("a person", "someone", "a person", "somebody", "a figure", "the person", "a human", "one person")
"""Subjects of a sentence."""
_INTRODUCED = ("a person", "someone", "somebody", "a figure")
"""... after "we see"."""
_NOUNS = frozenset({"person", "figure"})
"""... that take an adjective."""
_PRESENT = "{who} {s}"
_FRAMES = (
    (_PRESENT, 8), ("{who} is {ing}", 5), ("{who} can be seen {ing}", 1), ("this is {who} {ing}", 1),
    ("the motion shows {who} {ing}", 1), ("we see {who} {ing}", 1),
)  # fmt: skip


@dataclass(frozen=True)
class _Material:
    """All that can be said of one clip."""

    verbs: tuple[str, ...]
    adjectives: tuple[str, ...]
    manners: tuple[str, ...]
    details: wording.Details


def captions(clip: Clip, seed: int = 0, count: int = COUNT) -> list[str]:
    """Distinct English sentences that describe a clip, people's own first.

    Args:
        clip: a prepared clip; its motion is measured.
        seed: another seed, other sentences; the same one, the same.
        count: so many are made by the grammar, beside those people wrote; at least `LEAST`.

    Returns:
        At least `LEAST` sentences, each with a capital and a full stop.
    """
    # a clip and its mirror image (M...) get the same sentences but for the sides
    digest = hashlib.sha256(f"{clip.corpus}/{clip.name.removeprefix('M')}/{seed}".encode()).digest()
    random = Random(int.from_bytes(digest[:8], "big"))
    said = described.cleaned(clip.sentences)
    if clip.corpus in {"cmu", "amass"}:
        said += described.from_description(clip.text, random, _PEOPLE)
    material = _material(clip)
    made: dict[str, None] = {}
    wanted = max(count, LEAST)
    for _ in range(wanted * _DRAWS):
        if len(made) == wanted:
            break
        text = _compose(material, random)
        if doubled(text) is None and text not in said:
            made[text] = None
    return list(dict.fromkeys([*said, *made]))


def _material(clip: Clip) -> _Material:
    facts = Facts(clip.motion)
    action = clip.action or clip.label
    words = wording.fields(facts, action)
    written = phrases.PHRASES.get(action or "") or phrases.LABELS.get(action or "") or phrases.ANY
    if facts.still:
        written = phrases.HELD.get(action or "", written)
    verbs = tuple(dict.fromkeys(filled for text in written if (filled := _filled(text, words)) is not None))
    adjectives, manners = styles.words(clip.style)
    return _Material(verbs, adjectives, manners, wording.details(facts, action))


def _filled(text: str, words: dict[str, str]) -> str | None:
    """A phrase with its fields filled, or None if the motion lacks one."""
    needed = {name for _, name, _, _ in Formatter().parse(text) if name}
    return text.format(**words) if needed <= words.keys() else None


def _compose(material: _Material, random: Random) -> str:
    """One sentence: who, what, and up to three of how often, how, how fast, how long and what else."""
    frame = random.choices([text for text, _ in _FRAMES], [weight for _, weight in _FRAMES])[0]
    verb = random.choice(material.verbs)
    who, adjective = random.choice(_PEOPLE if frame.startswith("{who}") else _INTRODUCED), ""
    styled = bool(material.adjectives or material.manners) and random.random() < 0.75
    if styled and material.adjectives and who.split()[-1] in _NOUNS and random.random() < 0.4:
        adjective = random.choice(material.adjectives)
        who = f"{'the' if who.startswith('the') else 'a'} {adjective} {who.split()[-1]}"
    after = _modifiers(material, verb, styled, bool(adjective), random)
    front, tail = _length(material, frame, random)
    extras = material.details.extras
    if extras and len(after) < 2 and not front and not tail and random.random() < 0.35:
        extra = random.choice(extras)
        if not _repeats(extra, verb):
            tail = f" {extra}" if extra.startswith("w") else f", {extra}"
    if tail.startswith(", taking") and "[take]" in verb:
        tail = ""
    phrase = " ".join([verb, *after]) + tail
    return sentence(front + frame.format(who=who, s=inflect(phrase, "s"), ing=inflect(phrase, "ing")))


def _modifiers(material: _Material, verb: str, styled: bool, said: bool, random: Random) -> list[str]:
    """How often, and how: the manner of the style unless it is said already, or the speed."""
    details, after = material.details, []
    if details.counts and not _counted(verb) and random.random() < 0.6:
        after.append(random.choice(details.counts))
    if styled and not said and material.manners:
        after.append(random.choice(material.manners))
    elif details.speeds and not said and not _paced(verb) and random.random() < 0.4:
        after.append(random.choice(details.speeds))
    return after


def _length(material: _Material, frame: str, random: Random) -> tuple[str, str]:
    """How long it lasts, before the sentence or after it, or mostly not at all."""
    plain = frame == _PRESENT  # nobody is doing something in two seconds
    lengths = [text for text in material.details.durations if plain or not text.startswith("in ")]
    if not lengths or random.random() > 0.22:
        return "", ""
    length = random.choice(lengths)
    if length.startswith("taking"):
        return "", f", {length}"
    if frame.startswith("{who}") and random.random() < 0.25:
        return f"{length}, ", ""
    return "", f" {length}"


def _counted(verb: str) -> bool:
    return bool(re.search(r"\b(once|twice|times|steps|jumps?)\b", verb.replace("[jump]", "")))


def _paced(verb: str) -> bool:
    return bool(re.search(r"\b(fast|stroll|sprint|dash|carefully)\b", verb))


def _repeats(extra: str, verb: str) -> bool:
    """Would the participle say again what the verb phrase says?"""
    content = {"steps", "strides", "stand", "standing", "bent", "foot"}
    return bool(content & set(re.findall(r"[a-z]+", extra)) & set(re.findall(r"[a-z]+", verb)))


__all__ = ["COUNT", "LEAST", "captions"]
