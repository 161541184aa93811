"""How people ask for an action or a style when they type into a box: synonyms, situations, fragments."""

from __future__ import annotations

from engines.text.everyday import daily, gestures, locomotion, other, sports, styles

__all__ = ["EVERYDAY", "EVERYDAY_STYLES", "OTHER"]


def _apart(texts: dict[str, str]) -> dict[str, tuple[str, ...]]:
    """The sentences of each block, which stand between semicolons."""
    return {
        name: tuple(filter(None, (" ".join(piece.split()) for piece in text.split(";"))))
        for name, text in texts.items()
    }


EVERYDAY: dict[str, tuple[str, ...]] = _apart(
    locomotion.SENTENCES | gestures.SENTENCES | sports.SENTENCES | daily.SENTENCES
)
"""Action -> sentences of 1 to 14 words that ask for it; every one names the side where the action has one."""

EVERYDAY_STYLES: dict[str, tuple[str, ...]] = _apart(styles.PHRASES)
"""Style -> phrases that imply it and may follow a verb phrase ("walks hunched with age").

Styles that are one manner under two names (childish and childlike, elderly and old) share their phrases.
"""

OTHER: tuple[str, ...] = _apart({"": other.REQUESTS})[""]
"""Requests for what no action of the vocabulary is."""
