"""What the settings of every engine and evaluator have in common: a frozen dataclass, saved as JSON beside weights."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any, Self, TypeVar

from engines.errors import CheckpointError, UnknownLabelError

Kind = TypeVar("Kind")


class Config:
    """Base of frozen dataclasses of settings; lists in JSON are tuples in Python."""

    def replaced(self, **changes: Any) -> Self:
        """A copy with some fields changed."""
        return replace(self, **changes)  # type: ignore[type-var]  # only dataclasses inherit this

    def to_json(self) -> str:
        """Readable JSON."""
        return json.dumps(asdict(self), indent=1)  # type: ignore[call-overload]

    @classmethod
    def from_json(cls, text: str) -> Self:
        """The settings of a saved file.

        Raises:
            CheckpointError: not JSON of settings, or unknown fields.
        """
        try:
            values = dict(json.loads(text))
        except (ValueError, TypeError) as error:
            raise CheckpointError(f"the settings are not those of a {cls.__name__}: {error}") from error
        unknown = set(values) - {f.name for f in fields(cls)}  # type: ignore[arg-type]
        if unknown:
            raise CheckpointError(f"settings hold unknown fields {', '.join(sorted(unknown))}")
        return cls(**{key: _frozen(value) for key, value in values.items()})


def preset(name: str, presets: Mapping[str, Kind]) -> Kind:
    """A named preset.

    Raises:
        UnknownLabelError: no such preset.
    """
    if name not in presets:
        raise UnknownLabelError("preset", name, presets)
    return presets[name]


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value
