"""What each word of a sentence is: its part of speech, or the kind of motion word.

Text2Motion tells its networks, beside every word's vector, one of fifteen tags (Guo et al. 2022, section 3.3 "Text
Encoder"; thesis section 4.2.3). Nine are parts of speech, four are the motion dictionary of the paper (direction, body
part, object, action), a fifth kind (manner) is the release's, and the last is whatever else there is. A motion word
goes before its part of speech.

The paper's sentences were tagged by a library of hundreds of megabytes. Here it is word lists and the neighbours
(`lexicon`): captions are short and about one thing. `RELEASED` is the release's own dictionary, for its checkpoints.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from engines.text.lexicon import ADJECTIVES, CLOSED, NOUNS, POSSESSIVE, VERBS, base_forms, is_any, words

PARTS_OF_SPEECH = ("VERB", "NOUN", "DET", "ADP", "NUM", "AUX", "PRON", "ADJ", "ADV")
KINDS = ("direction", "body part", "object", "action", "manner")
TAGS = (*PARTS_OF_SPEECH, *KINDS, "OTHER")
"""In the order of the release's one-hot vectors."""
OTHER = len(TAGS) - 1

_KINDS: dict[str, frozenset[str]] = {
    "direction": words(
        "left right clockwise counterclockwise anticlockwise forward forwards backward backwards back ahead up down "
        "upward upwards downward downwards straight curve sideways sidewards diagonal diagonally around leftward "
        "rightward leftwards rightwards overhead inward outward reverse circle"
    ),
    "body part": words(
        "arm hand leg foot head knee elbow shoulder chest waist hip torso wrist ankle finger thumb fist palm face eye "
        "ear mouth chin neck thigh forearm heel toe body belly stomach biceps calf shin"
    ),
    "object": words(
        "stair stairs ladder dumbbell chair seat window floor ground car ball handrail rail baseball basketball bat "
        "racket racquet basket door table wall rope bar sword box weight bottle cup phone book golf tennis football "
        "beam bike equipment playground terrain"
    ),
    "action": words(
        "walk run jog jump hop leap step turn wave raise lift lower bend squat kneel sit stand lie rise throw catch "
        "kick punch push pull swing shake clap bow dance climb march sprint dash stroll stretch crouch lunge spin "
        "twist rotate roll crawl swim balance stumble fall skip shuffle limp tiptoe stomp reach grab pick put bring "
        "carry hold stop wash rub knock hit strike slap dodge lean nod point beckon gesture signal greet salute cross "
        "fold shoot dribble bounce serve bowl toss hurl row draw trace swipe box fight fence applaud cheer curl "
        "cartwheel flap spread trudge plod saunter clamber stoop shove race jab parry slash stride circle stagger "
        "retreat flail sway wheel drop flip drink eat bat"
    ),
    "manner": words(
        "slow slowly quick quickly fast happy happily angry angrily sad sadly careful carefully tired tiredly lively "
        "energetic energetically exhausted weary wearily proud proudly old elderly young youthful feminine masculine "
        "childish steadily calmly leisurely furiously furious cheerfully cheerful gentle gently gracefully heavily "
        "timidly shyly confidently briskly stiffly strongly weakly suddenly smoothly vigorously nervously drunk"
    ),
}

RELEASED: dict[str, tuple[str, ...]] = {
    "direction": (
        "left", "right", "clockwise", "counterclockwise", "anticlockwise", "forward", "back", "backward", "up", "down",
        "straight", "curve",
    ),
    "body part": (
        "arm", "chin", "foot", "feet", "face", "hand", "mouth", "leg", "waist", "eye", "knee", "shoulder", "thigh",
    ),
    "object": (
        "stair", "dumbbell", "chair", "window", "floor", "car", "ball", "handrail", "baseball", "basketball",
    ),
    "action": (
        "walk", "run", "swing", "pick", "bring", "kick", "put", "squat", "throw", "hop", "dance", "jump", "turn",
        "stumble", "stop", "sit", "lift", "lower", "raise", "wash", "stand", "kneel", "stroll", "rub", "bend",
        "balance", "flap", "jog", "shuffle", "lean", "rotate", "spin", "spread", "climb",
    ),
    "manner": (
        "slowly", "carefully", "fast", "careful", "slow", "quickly", "happy", "angry", "sad", "happily", "angrily",
        "sadly",
    ),
}  # fmt: skip
"""The motion dictionary of the released code, whose words are matched as they are."""

SIDES: tuple[frozenset[str], ...] = (
    words("left leftward leftwards"),
    words("right rightward rightwards"),
    words("both"),
    words("forward forwards ahead onward onwards"),
    words("back backward backwards reverse retreat retreats"),
    words("clockwise"),
    words("counterclockwise anticlockwise"),
)
"""Words that name the same side or way. All are directions to the tags, and what a frozen encoder makes of "left" and
of "right" is nearly the same, since what most sentences say does not hang on it; motions do."""

_WORD = re.compile(r"[^\W\d_]+|'s\b|\d+|[^\w\s]")


def words_of(sentence: str) -> list[str]:
    """The words of a sentence in lower case; numbers, punctuation and a genitive's 's by themselves."""
    return _WORD.findall(sentence.lower().replace("’", "'"))


def parts_of_speech(sentence: Sequence[str]) -> list[str]:
    """A part of speech for each word (lower case), or OTHER."""
    told: list[str] = []
    for place, word in enumerate(sentence):
        after = sentence[place + 1] if place + 1 < len(sentence) else ""
        told.append(_part(word, told, sentence[:place], after))
    return told


def tags(sentence: Sequence[str]) -> list[str]:
    """One of `TAGS` for each word (lower case): the kind of motion word if it is one, else its part of speech."""
    found = []
    for word, part in zip(sentence, parts_of_speech(sentence), strict=True):
        kind = _kind(word, part)
        found.append(kind or part)
    return found


def tags_of_pieces(pieces: Sequence[str], continues: str = "##") -> list[int]:
    """Places in `TAGS` of words cut into pieces, every piece with the tag of its word.

    Args:
        pieces: in order; those that go on a word begin with `continues`.
        continues: the mark.
    """
    whole, belongs = _joined(pieces, continues)
    told = [TAGS.index(tag) for tag in tags(whole)]
    return [told[place] for place in belongs]


def sides_of_pieces(pieces: Sequence[str], continues: str = "##") -> list[int]:
    """Places in `SIDES` of words cut into pieces, -1 for those that name none; arguments as in `tags_of_pieces`."""
    whole, belongs = _joined(pieces, continues)
    told = [next((place for place, side in enumerate(SIDES) if word in side), -1) for word in whole]
    for place, word in enumerate(whole):
        if word == "clockwise" and whole[max(0, place - 2) : place] in (["counter", "-"], ["anti", "-"]):
            told[place] = len(SIDES) - 1
    return [told[place] for place in belongs]


def released_tag(word: str, part: str, known: bool, dictionary: Mapping[str, Sequence[str]] = RELEASED) -> int:
    """Place in `TAGS` of a word as the release has it: only known words have one, and words are matched as they are.

    Args:
        word: lower case.
        part: of speech, as a tagger says; one that is not of `PARTS_OF_SPEECH` is OTHER.
        known: whether it has a vector.
        dictionary: of motion words.
    """
    if not known:
        return OTHER
    for kind, held in dictionary.items():
        if word in held:
            return TAGS.index(kind)
    return TAGS.index(part) if part in PARTS_OF_SPEECH else OTHER


def one_hot(places: np.ndarray) -> np.ndarray:
    """(..., 15) float32 of places (...) in `TAGS`."""
    return np.eye(len(TAGS), dtype=np.float32)[places]


def _joined(pieces: Sequence[str], continues: str) -> tuple[list[str], list[int]]:
    """Whole words of pieces, and to which of them each piece belongs."""
    whole: list[str] = []
    belongs: list[int] = []
    for piece in pieces:
        if whole and piece.startswith(continues):
            whole[-1] += piece.removeprefix(continues)
        else:
            whole.append(piece.lower())
        belongs.append(len(whole) - 1)
    return whole, belongs


@lru_cache(maxsize=8192)
def _kind(word: str, part: str) -> str | None:
    """Of motion word."""
    if part in {"DET", "AUX", "PRON", "NUM"}:
        return None
    found = [kind for kind, held in _KINDS.items() if is_any(word, held)]
    if len(found) > 1 and "action" in found:  # he bats with a bat, she circles in a circle
        return "action" if part == "VERB" else next(kind for kind in found if kind != "action")
    return found[0] if found else None


def _part(word: str, told: Sequence[str], before: Sequence[str], after: str) -> str:
    if word.isdigit():
        return "NUM"
    if not word[0].isalpha() and word != "'s":
        return "OTHER"
    if word == "to":
        return "OTHER" if after in VERBS else "ADP"
    if word in CLOSED:
        return CLOSED[word]
    return _open_part(word, told, before, after)


def _open_part(word: str, told: Sequence[str], before: Sequence[str], after: str) -> str:
    """Of a word that could be several things, by its forms, its ending, and what stands beside it."""
    verb, noun = is_any(word, VERBS), is_any(word, NOUNS)
    if word in ADJECTIVES and not (verb and _wants_verb(told, before)):
        return "ADJ"
    if word.endswith("ly") and len(word) > 4 and not verb:
        return "ADV"
    if verb and word.endswith(("ing", "ed")) and word not in NOUNS:
        return "VERB"
    if verb and noun:
        return "NOUN" if _wants_noun(word, told, before, after) else "VERB"
    return "VERB" if verb else "NOUN" if noun else _by_ending(word, _wants_verb(told, before))


def _by_ending(word: str, wants_verb: bool) -> str:
    """Of a word in none of the lists."""
    if is_any(word, ADJECTIVES) or word.endswith(("ful", "ous", "ive", "able", "ible", "less", "ish", "ic")):
        return "ADJ"
    return "VERB" if word.endswith(("ing", "ed")) or (wants_verb and word.endswith("s")) else "NOUN"


def _wants_noun(word: str, told: Sequence[str], before: Sequence[str], after: str) -> bool:
    """Whether a noun is likelier than a verb here."""
    if not told:
        return after in {"of", "is", "are"}
    last = told[-1]
    if before[-1] in POSSESSIVE or last in {"DET", "ADJ", "NUM"}:
        return True
    if last == "ADP":
        return True
    # takes steps, makes turns
    return last == "VERB" and word.endswith("s") and bool(set(base_forms(before[-1])) & {"take", "make", "do", "throw"})


def _wants_verb(told: Sequence[str], before: Sequence[str]) -> bool:
    """Whether a verb is likely to come: after whom it is told of, or after a comma."""
    return bool(told) and (told[-1] in {"NOUN", "PRON"} or before[-1] in {",", "and"}) and before[-1] not in POSSESSIVE


__all__ = [
    "KINDS", "OTHER", "PARTS_OF_SPEECH", "RELEASED", "SIDES", "TAGS", "one_hot", "parts_of_speech", "released_tag",
    "sides_of_pieces", "tags", "tags_of_pieces", "words_of",
]  # fmt: skip
