"""What a search field understands, the same for the takes on the shelf and for a whole library.

wave proud             both words, anywhere: action, prompt, style, engine, file, tags
"old man"              these words as they stand
tag:walk  style:old  engine:loom  action:run  prompt:turns
is:starred  is:kept  is:imported
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, true

from studio.library import schema
from studio.takes import Take

LONGEST_TAG = 40
MOST_TAGS = 20
FIELDS = ("tag", "style", "engine", "action", "prompt")
STATES = ("starred", "kept", "imported")
_TERM = re.compile(r'(?:(\w+):)?(?:"([^"]*)"?|(\S+))')


@dataclass(frozen=True)
class Query:
    """A search, taken apart; every part has to fit."""

    words: tuple[str, ...] = ()
    """Found anywhere, case folded."""
    fields: tuple[tuple[str, str], ...] = ()
    """(one of `FIELDS`, what it has to contain), case folded."""
    states: tuple[str, ...] = ()
    """Of `STATES`."""

    @classmethod
    def parse(cls, text: str) -> Query:
        """What a person typed; nothing typed fits everything, and nothing typed is an error."""
        words: list[str] = []
        fields: list[tuple[str, str]] = []
        states: list[str] = []
        for key, quoted, plain in _TERM.findall(text):
            value = folded(quoted or plain)
            if key.lower() in FIELDS:
                fields.append((key.lower(), value))
            elif key.lower() == "is" and value in STATES:
                states.append(value)
            elif key or value:
                words.append(folded(f"{key}:{value}" if key else value))
        return cls(tuple(words), tuple(fields), tuple(states))

    def __bool__(self) -> bool:
        return bool(self.words or self.fields or self.states)

    def matches(self, take: Take) -> bool:
        """Whether a take fits."""
        told = described(take)
        tags = json_tags(take.tags)
        return (
            all(word in told["words"] or word in tags for word in self.words)
            and all(value in (tags if name == "tag" else folded(told[name])) for name, value in self.fields)
            and all(_STATE[state](take) for state in self.states)
        )

    def condition(self) -> ColumnElement[bool]:
        """The same for rows of the table of takes."""
        rows = schema.takes.c
        found: ColumnElement[bool] = true()
        for word in self.words:
            found &= rows.words.contains(word, autoescape=True) | rows.tags.contains(word, autoescape=True)
        for name, value in self.fields:
            column = rows.tags if name == "tag" else rows[name]
            found &= column.contains(value, autoescape=True)
        for state in self.states:
            found &= {"starred": rows.favourite, "kept": rows.accepted, "imported": rows.settings.is_(None)}[state]
        return found


_STATE: Mapping[str, Any] = {
    "starred": lambda take: take.favourite,
    "kept": lambda take: take.accepted,
    "imported": lambda take: take.settings is None,
}


def folded(text: str) -> str:
    """A text as searches compare it."""
    return " ".join(text.casefold().split())


def described(take: Take) -> dict[str, str]:
    """What of a take is searched, tags aside: `words`, `action`, `prompt`, `style`, `engine`, case folded."""
    made = take.settings
    told = {
        "action": folded(made.action if made else ""),
        "prompt": folded(made.prompt if made else ""),
        "style": folded(made.style if made else ""),
        "engine": folded(made.engine if made else ""),
    }
    blocks = [folded(block.what) for block in made.sequence.blocks] if made else []
    words = filter(None, [folded(take.title), folded(take.source), *told.values(), *blocks])
    return {**told, "words": " · ".join(dict.fromkeys(words))}


def tag(text: str) -> str:
    """A tag as it is kept: small letters, single blanks, no marks that mean something to a search; may be empty."""
    return folded(re.sub(r'[",\\\x00-\x1f]+', " ", text))[:LONGEST_TAG].strip()


def tags(texts: Iterable[str]) -> tuple[str, ...]:
    """Tags as they are kept, each once, in the order they came."""
    return tuple(dict.fromkeys(filter(None, map(tag, texts))))[:MOST_TAGS]


def json_tags(those: tuple[str, ...]) -> str:
    """Tags as their column holds them."""
    return json.dumps(list(those), ensure_ascii=False)
