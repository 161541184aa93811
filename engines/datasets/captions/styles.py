"""Words for the manners of the data sets' styles: for the one who moves, and for how."""

from __future__ import annotations

STYLES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    # style -> adjectives of the person, manners that follow the verb phrase
    "active": (("lively", "energetic"), ("energetically", "in a lively way", "full of energy", "with a lot of energy")),
    "angry": (("angry", "furious"), ("angrily", "in anger", "as if furious")),
    "childish": ((), ("like a child", "in a childish way", "as a small child would")),
    "childlike": ((), ("like a child", "in a childlike way", "as a small child would")),
    "chimpira": ((), ("like a street thug", "with a swagger", "in a provocative way")),
    "depressed": (("depressed", "dejected"), ("in a depressed way", "as if all were lost", "dejectedly")),
    "drunk": (("drunken",), ("as if drunk", "unsteadily", "like a drunk")),
    "elderly": (("elderly", "old"), ("like an old person", "as an elderly person would", "with the stiffness of age")),
    "exhausted": (("exhausted", "worn-out"), ("wearily", "as if exhausted", "with hardly any strength")),
    "female model": ((), ("like a fashion model", "as on a catwalk")),
    "feminine": ((), ("in a feminine way", "in a feminine manner", "with feminine grace")),
    "giant": ((), ("like a giant", "heavily, as a giant would", "with a giant's weight")),
    "happy": (("happy", "cheerful"), ("happily", "cheerfully", "in high spirits")),
    "heavy": ((), ("heavily", "as if weighed down")),
    "hurried": ((), ("in a hurry", "hurriedly")),
    "lazy": (("lazy",), ("lazily", "without any effort")),
    "masculine": ((), ("in a masculine way", "in a masculine manner", "with manly firmness")),
    "musical": ((), ("as if to music", "rhythmically", "with a sense of rhythm")),
    "old": (("elderly", "old"), ("like an old person", "as an elderly person would", "with the stiffness of age")),
    "proud": (("proud",), ("proudly", "with pride", "with the chest out")),
    "robot": ((), ("like a robot", "mechanically")),
    "sad": (("sad", "downcast"), ("sadly", "in a sad way", "with a heavy heart")),
    "sexy": ((), ("seductively", "in a sexy way")),
    "sneaky": ((), ("stealthily", "in a sneaky way")),
    "soldier": ((), ("like a soldier", "with military stiffness")),
    "strutting": ((), ("in a strutting way", "showing off")),
    "tired": (("tired", "weary"), ("tiredly", "as if tired", "with little energy")),
    "unconfident": (("timid", "shy"), ("timidly", "without confidence", "in an unsure way")),
    "youthful": (("young", "youthful"), ("like a young person", "in a youthful way", "with youthful ease")),
    "zombie": ((), ("like a zombie", "as if undead")),
}
"""Adjectives are only given where they say what the style says; a person who moves like a giant is none."""

PLAIN = frozenset({"normal", "neutral"})
"""Styles of which there is nothing to say."""


def words(style: str | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """(adjectives, manners) of a style; a style not known here gets "in a ... way"."""
    if style is None or style in PLAIN:
        return (), ()
    return STYLES.get(style, ((), (f"in a {style} way", f"in a {style} manner")))
