"""What people wrote of clips: CMU's terse descriptions put into English, and annotators' own sentences."""

from __future__ import annotations

import re
from collections.abc import Iterable
from random import Random

from engines.datasets.captions.grammar import inflect, listed, sentence

_SETTINGS = {
    # what CMU writes before the dash -> where or how, and the verb phrase that things enumerated belong to
    "playground": ("on a playground", None), "dance": (None, "[dance] with"), "basketball": (None, None),
    "static dance pose": (None, "[hold] a dance pose with"), "acrobatics": (None, None), "navigate": (None, None),
}  # fmt: skip

_DOINGS = {
    # what CMU says is done -> verb phrase
    "forward jumps": "[jump] forward", "forward jump": "[jump] forward", "turn around": "[turn] around",
    "climb": "[climb]", "hang": "[hang] by the hands", "swing": "[swing]", "go under": "[go] under the bars",
    "sit": "[sit] down", "dangle legs": "[dangle] the legs", "descend": "[climb] down", "jump down": "[jump] down",
    "hold self up with arms straight": "[hold] the body up with straight arms", "drop": "[drop] down",
    "lean back": "[lean] back", "lean over": "[lean] over", "pull up": "[pull] the body up", "dangle": "[dangle]",
    "lower self to ground": "[get] down to the ground", "legs push off against": "[push] off with the legs",
    "walk": "[walk]", "slow walk": "[walk] slowly", "brisk walk": "[walk] briskly", "run": "[run]",
    "run/jog": "[jog]", "jump": "[jump]", "balance": "[keep] the balance", "punch/strike": "[punch] and [strike]",
    "swordplay": "[practise] swordplay", "wash self": "[wash] the body",
    "walk on uneven terrain": "[walk] on uneven terrain", "exaggerated stride": "[take] exaggerated strides",
    "slow walk/stride": "[walk] slowly with long strides", "leap": "[leap]", "cartwheel": "[do] a cartwheel",
    "cartwheels": "[do] cartwheels", "jump up and down": "[jump] up and down", "hop on one foot": "[hop] on one foot",
    "jump up to grab": "[jump] up to grab something", "reach for": "[reach] for it", "tiptoe": "[stand] on tiptoe",
    "balance on one leg": "[balance] on one leg", "outstretched arms": "[hold] the arms out",
    "forward dribble": "[dribble] a basketball forward", "backward dribble": "[dribble] a basketball backward",
    "sideways dribble": "[dribble] a basketball sideways", "90-degree left turns": "[make] quarter turns to the left",
    "90-degree right turns": "[make] quarter turns to the right", "crossover dribble": "[dribble] from hand to hand",
    "low": "[keep] low", "fast free style dribble": "[dribble] a basketball fast and freely",
    "dribble through legs": "[dribble] between the legs", "dribble": "[dribble] a basketball",
    "shoot": "[shoot] at the basket", "walk forward": "[walk] forward", "backward": "[walk] backward",
    "sideways": "[walk] sideways", "spin/twirl": "[spin] around", "hang on ropes": "[hang] on ropes",
}  # fmt: skip

_THINGS = {
    # parts of dances -> what the dance is with
    "expressive arms": "expressive arms", "pirouette": "a pirouette", "pirouettes": "pirouettes", "turn": "a turn",
    "sideways arabesque": "a sideways arabesque", "side arabesque": "a side arabesque", "turn step": "a turning step",
    "folding arms": "folding arms", "quasi-cou-de-pied": "a foot drawn up to the ankle",
    "raised leg above hip-height": "a leg raised above the hip", "jete en tourant": "a turning jeté",
    "grand jete en tourant": "a grand turning jeté", "cartwheel-like start": "a start like a cartwheel",
    "jete": "a jeté", "small jetes": "small jetés", "attitude/arabesque": "an arabesque",
    "shifted-axis pirouette": "a pirouette on a shifted axis",
    "rond de jambe in the air": "a leg circling in the air", "glissade devant": "a gliding step to the front",
    "glissade derriere": "a gliding step to the back", "sideways steps": "sideways steps",
    "arms held high": "the arms held high", "pointe tendue a terre": "a foot stretched along the floor",
    "upper body rotation": "a rotation of the upper body", "retire derriere": "a foot drawn up behind the knee",
    "coupe dessous": "a quick change of feet", "bending back": "a bend backward",
    "fold in from side arabesque": "a fold in from a side arabesque", "curl inwards": "a curl inward",
    "lean forward": "a lean forward", "bring back leg forward": "the back leg brought forward",
    "arching arms": "arching arms", "folded in": "the body folded in", "head lowered": "the head lowered",
    "leg bent": "a leg bent", "lean back on bent leg": "a lean back on a bent leg", "balance": "a balance",
    "bend elbow by ear": "an elbow bent beside the ear",
}  # fmt: skip
_BRACKETS = re.compile(r"\s*\[[^\]]*\]")
_TEMPLATES = (
    ("{who} {s}", "s"), ("{who} is {ing}", "ing"), ("{who} {s}", "s"), ("{who} can be seen {ing}", "ing"),
)  # fmt: skip


def from_description(text: str | None, random: Random, people: Iterable[str]) -> list[str]:
    """Sentences that say what a CMU description says; none for one that is not understood in full.

    Args:
        text: "playground - climb, hang, swing"; facts in square brackets after it are left aside.
        random: draws the subjects.
        people: subjects to draw from ("a person").
    """
    phrase = _verb_phrase(_BRACKETS.sub("", text or "").strip().lower())
    if phrase is None:
        return []
    where, verb = phrase
    said = []
    for template, form in random.sample(_TEMPLATES, k=2):
        who = random.choice(tuple(people))
        text = template.format(who=who, **{form: inflect(verb, form)})  # type: ignore[arg-type]
        if where:
            text = f"{where}, {text}" if random.random() < 0.5 else f"{text} {where}"
        said.append(sentence(text))
    return list(dict.fromkeys(said))


def _verb_phrase(text: str) -> tuple[str | None, str] | None:
    """(where, verb phrase) of a description, or None."""
    setting, dash, rest = text.partition(" - ")
    if not dash:
        setting, rest = "", text
    elif setting not in _SETTINGS:
        return None
    where, opening = _SETTINGS.get(setting, (None, None))
    parts = [part.strip() for part in rest.split(",") if part.strip()]
    known = _THINGS if opening else _DOINGS
    if not parts or any(part not in known for part in parts):
        return None
    said = [known[part] for part in parts]
    return (where, f"{opening} {listed(said)}") if opening else (where, listed(said))


def cleaned(sentences: Iterable[str]) -> list[str]:
    """People's own sentences with a capital and a full stop; their wording is kept."""
    spaced = (re.sub(r"\s+", " ", text).strip(" .") for text in sentences)
    return list(dict.fromkeys(text[:1].upper() + text[1:] + "." for text in spaced if text))
