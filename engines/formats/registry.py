"""What a format is, and how the right one is found for a file."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engines.errors import FormatError, UnknownLabelError
from engines.formats.files import read_head
from engines.motion import Motion


@dataclass(frozen=True)
class Format:
    """One kind of motion file."""

    name: str
    """Short name, e.g. "bvh"; what `read(format=)` and `write(format=)` take."""
    extensions: tuple[str, ...]
    """Lower-case endings with their dot, the one to write first."""
    description: str
    """One line for a person."""
    sniff: Callable[[Path, bytes], bool]
    """Does the file hold this format, from its path and its first bytes? Never raises."""
    read: Callable[..., Motion] | None = None
    """`read(path, **options) -> Motion`, or None."""
    write: Callable[..., Path] | None = None
    """`write(motion, path, **options) -> Path`, or None."""

    @property
    def reads(self) -> bool:
        """Can it be read?"""
        return self.read is not None

    @property
    def writes(self) -> bool:
        """Can it be written?"""
        return self.write is not None

    def matches(self, path: Path) -> int:
        """Length of the longest of its extensions that the file name ends with; 0 for none."""
        name = path.name.lower()
        return max((len(end) for end in self.extensions if name.endswith(end)), default=0)


def find_reader(path: Path, formats: Iterable[Format]) -> Format:
    """The format whose content the file has; of several, the one whose extension it has.

    Raises:
        FormatError: no readable file, or of no known kind; the message lists what would be accepted.
    """
    readers = [f for f in formats if f.reads]
    head = read_head(path)
    ranked = sorted(readers, key=lambda f: f.matches(path), reverse=True)
    recognised = next((f for f in ranked if f.sniff(path, head)), None)
    if recognised:
        return recognised
    named = ranked[0] if ranked and ranked[0].matches(path) else None
    if named:
        return named  # its own reader says best what is wrong
    accepted = "; ".join(f"{f.description} ({', '.join(f.extensions)})" for f in readers)
    raise FormatError(path, f"is of no kind that is known here. Accepted: {accepted}.")


def find_writer(path: Path, formats: Iterable[Format]) -> Format:
    """The format that the file name's extension asks for, the longest extension first.

    Raises:
        FormatError: no format has that extension; the message lists those that are written.
    """
    writers = [f for f in formats if f.writes]
    best = max(writers, key=lambda f: f.matches(path), default=None)
    if best is None or not best.matches(path):
        ends = ", ".join(dict.fromkeys(end for f in writers for end in f.extensions))
        raise FormatError(path, f"no format is known by the extension {path.suffix!r}; accepted: {ends}.")
    return best


def by_name(name: str, formats: Iterable[Format]) -> Format:
    """The format of that name.

    Raises:
        UnknownLabelError: there is none; the nearest names are listed.
    """
    known = {f.name: f for f in formats}
    if name not in known:
        raise UnknownLabelError("format", name, known)
    return known[name]


def check_options(path: Path, kind: Format, call: Callable[..., Any], options: dict[str, Any], given: int) -> None:
    """Refuse options that a reader or writer does not have.

    Args:
        path: the file, for the message.
        kind: the format.
        call: its `read` or `write`.
        options: what was asked for.
        given: how many leading parameters are not options.

    Raises:
        FormatError: an unknown option; the message lists those there are.
    """
    accepted = list(inspect.signature(call).parameters)[given:]
    unknown = [name for name in options if name not in accepted]
    if unknown:
        raise FormatError(
            path, f"format {kind.name!r} has no option {unknown[0]!r}; accepted: {', '.join(accepted) or 'none'}."
        )
