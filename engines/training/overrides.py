"""Settings from the command line: `--set key=value`, typed by the dataclass that has the key."""

from __future__ import annotations

import types
from collections.abc import Sequence
from dataclasses import fields
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from engines.errors import OutOfRangeError, UnknownLabelError

_TRUTH = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}
_SAYS = {int: "a whole number", float: "a number", str: "a word", bool: "true or false"}


def overrides(pairs: Sequence[str], *kinds: type) -> list[dict[str, Any]]:
    """`["steps=500", "kl_weight=0.01,0.1"]` -> the changed fields of each dataclass.

    A key belongs to the first dataclass that has it. Numbers, words, true/false, one of several words, `none` where a
    field may be None, and tuples with commas are understood.

    Args:
        pairs: KEY=VALUE each.
        kinds: dataclasses.

    Raises:
        OutOfRangeError: not KEY=VALUE, or the value is not of the field's type.
        UnknownLabelError: no dataclass has the key; the message lists the nearest.
    """
    types_of = [_settable(kind) for kind in kinds]
    known = {name for found in types_of for name in found}
    changes: list[dict[str, Any]] = [{} for _ in kinds]
    for pair in pairs:
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not equals:
            raise OutOfRangeError("--set", pair, "KEY=VALUE, as in learning_rate=0.0005")
        if key not in known:
            raise UnknownLabelError("setting", key, known)
        index = next(i for i, found in enumerate(types_of) if key in found)
        try:
            changes[index][key] = _parsed(value, types_of[index][key])
        except ValueError:
            raise OutOfRangeError(key, value, _accepted(types_of[index][key])) from None
    return changes


def _settable(kind: type) -> dict[str, Any]:
    """Fields whose type can be written on a command line."""
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind) if _writable(hints[field.name])}


def _writable(hint: Any) -> bool:
    if get_origin(hint) in {tuple, Union, types.UnionType}:
        return all(part in {..., type(None)} or _writable(part) for part in get_args(hint))
    return hint in _SAYS or get_origin(hint) is Literal


def _parsed(text: str, hint: Any) -> Any:
    """The value of a type that a text stands for; ValueError if it stands for none."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin in {Union, types.UnionType}:
        if type(None) in parts and text.lower() == "none":
            return None
        return _parsed(text, next(part for part in parts if part is not type(None)))
    if origin is tuple:
        return _parsed_tuple(text, parts)
    if origin is Literal or hint is bool:
        words = _TRUTH if hint is bool else {str(part): part for part in parts}
        if text.lower() not in words:
            raise ValueError(text)
        return words[text.lower()]
    return hint(text)


def _parsed_tuple(text: str, parts: tuple[Any, ...]) -> tuple[Any, ...]:
    items = [item.strip() for item in text.split(",") if item.strip()]
    wanted = (parts[0],) * len(items) if parts[-1] is ... else parts
    return tuple(_parsed(item, part) for item, part in zip(items, wanted, strict=True))


def _accepted(hint: Any) -> str:
    """What a type accepts, in words."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Literal:
        return " or ".join(map(str, parts))
    if origin in {Union, types.UnionType}:
        return " or ".join("none" if part is type(None) else _accepted(part) for part in parts)
    if origin is tuple:
        if parts[-1] is ...:
            return f"{_accepted(parts[0])} each, with commas between them"
        return f"{len(parts)} values with a comma between them, each {_accepted(parts[0])}"
    return _SAYS[hint]
