"""What the commands share: progress on stderr, settings from a file and from options."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from engines.errors import OutOfRangeError
from studio.settings import Settings, read_settings

SettingsOption = Annotated[
    Path | None,
    typer.Option("--settings", "-s", metavar="FILE", help="Settings file (JSON), as the app's Reproduce saves it."),
]
WidthOption = Annotated[int | None, typer.Option(metavar="PIXELS", help="Video width, even.")]
HeightOption = Annotated[int | None, typer.Option(metavar="PIXELS", help="Video height, even.")]
FpsOption = Annotated[float | None, typer.Option(metavar="RATE", help="Frames a second of the file.")]
CameraOption = Annotated[
    str | None, typer.Option(metavar="NAME", help="Video: follow, orbit, front, back, left or right.")
]
EditOption = Annotated[
    list[str] | None,
    typer.Option("--edit", metavar="NAME", help="Done first, repeatable: smooth, feet, loop, mirror, in_place."),
]


def settings_from(file: Path | None, **options: Any) -> Settings:
    """The settings of a file, or the defaults, with the options that were given on top."""
    return (read_settings(file) if file else Settings()).changed(**options)


@contextmanager
def progress_bar(title: str, unit: str = "frame") -> Iterator[Callable[[int, int | None], None]]:
    """A progress bar on stderr, shown on a terminal only; yields `progress(done, total)`."""
    from tqdm import tqdm

    with tqdm(desc=title, unit=unit, disable=None, leave=False) as bar:

        def progress(done: int, total: int | None) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield progress


def parse_formats(text: str | None) -> tuple[str, ...] | None:
    """`"bvh,npz"` -> ("bvh", "npz"); None stays None."""
    return None if text is None else tuple(part.strip().lower() for part in text.split(",") if part.strip())


def parse_factors(items: list[str] | None) -> dict[str, float] | None:
    """`["left_knee=1.1"]` -> {"left_knee": 1.1}; nothing given stays None."""
    return parse_numbers("--bone-scale", items, "JOINT=FACTOR, as in left_knee=1.1")


def parse_numbers(
    option: str, items: list[str] | None, accepted: str = "NAME=VALUE, as in weight=0.7"
) -> dict[str, float] | None:
    """`["weight=0.7"]`, as given to an option, -> {"weight": 0.7}; nothing given stays None.

    Raises:
        OutOfRangeError: one is not of that form; the message says what is `accepted`.
    """
    if not items:
        return None
    numbers = {}
    for item in items:
        name, equals, number = item.partition("=")
        try:
            numbers[name.strip()] = float(number)
        except ValueError:
            equals = ""
        if not equals:
            raise OutOfRangeError(option, item, accepted)
    return numbers
