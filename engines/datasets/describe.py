"""What is in the prepared data: how much, of what, in which parts; as numbers and as a picture of bars."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from engines.datasets.prepare import CORPORA
from engines.errors import FormatError, MotionloomError
from engines.formats.files import atomic_path

if TYPE_CHECKING:
    from engines.datasets import Clip

By = Literal["action", "style", "label", "fine", "subject", "split", "corpus"]
BYS: tuple[By, ...] = ("action", "style", "label", "fine", "subject", "split", "corpus")
"""What clips may be counted by."""

_NONE = "(none)"
_ROW, _LEFT, _BARS, _RIGHT, _TOP = 22, 230, 460, 150, 46
"""The picture's measures, pixels: height of a row, widths of names, bars and numbers, height of the title."""
_INK, _FAINT, _BAR = "#1f2430", "#6b7280", "#3b6fd4"


@dataclass(frozen=True)
class Row:
    """Clips that share a value."""

    value: str
    clips: int
    minutes: float


@dataclass(frozen=True)
class Summary:
    """Some clips, counted."""

    title: str
    clips: int
    minutes: float
    seconds: tuple[float, float, float]
    """Shortest, median and longest clip."""
    splits: dict[str, int]
    subjects: int
    sentences: int
    """Written by people, whole clips and parts."""
    by: By
    rows: tuple[Row, ...]
    """Clips by value, most first; those without one last."""


def summarise(clips: Sequence[Clip], by: By | None = None, title: str = "all data sets") -> Summary:
    """Count clips.

    Args:
        clips: at least one.
        by: what to count them by; by default the first of action, label and style that more than half of them have,
            else the data set.
        title: what they are.

    Raises:
        MotionloomError: no clips.
    """
    if not clips:
        raise MotionloomError(f"{title}: there are no clips to describe.")
    chosen: By = by or _telling(clips)
    counted: dict[str, list[Clip]] = defaultdict(list)
    for clip in clips:
        counted[getattr(clip, chosen) or _NONE].append(clip)
    rows = [Row(value, len(own), _minutes(own)) for value, own in counted.items()]
    rows.sort(key=lambda row: (row.value == _NONE, -row.clips, row.value))
    seconds = [clip.motion.duration for clip in clips]
    written = sum(
        len(clip.sentences) + sum(s.kind == "text" and s.end - s.start < len(clip.motion) for s in clip.motion.labels)
        for clip in clips
    )
    return Summary(
        title, len(clips), _minutes(clips), (min(seconds), float(np.median(seconds)), max(seconds)),
        dict(Counter(clip.split for clip in clips)), len({(c.corpus, c.subject) for c in clips if c.subject}),
        written, chosen, tuple(rows),
    )  # fmt: skip


def found(source: Path) -> dict[str, str]:
    """What of the data sets lies in a folder, prepared or not: name -> "packed, 77 MB" or "1,191 clips".

    Archives are not opened. A data set whose index is damaged is told with the reason.

    Raises:
        FormatError: no such folder.
    """
    if not source.is_dir():
        raise FormatError(source, "is no folder; accepted: the folder with the data sets.")
    present: dict[str, str] = {}
    for name, corpus in CORPORA.items():
        archive = source / corpus.archive
        if archive.is_file():
            present[name] = f"packed, {archive.stat().st_size / 2**20:.0f} MB"
            continue
        try:
            count = sum(1 for _ in corpus.clips(source))
        except FormatError as error:
            if "no manifest.json" not in str(error):  # how a folder without CMU's set looks
                present[name] = f"damaged: {error}"
            continue
        if count:
            present[name] = f"{count:,} clips"
    return present


def bars(summary: Summary, width: int = 30, mark: str = "█") -> list[str]:
    """The distribution as lines of text, a bar a row."""
    most = max(row.clips for row in summary.rows)
    return [
        f"{row.value[:29]:<30}{row.clips:>7,}{row.minutes:>10.1f}  {mark * max(1, round(width * row.clips / most))}"
        for row in summary.rows
    ]


def plot(summary: Summary, path: Path) -> Path:
    """Draw the distribution to an .svg or .png file, beside and renamed.

    Raises:
        FormatError: another extension, or the file cannot be written.
    """
    draw: dict[str, Callable[[Summary, Path], None]] = {".svg": _draw_svg, ".png": _draw_png}
    kind = path.suffix.lower()
    if kind not in draw:
        raise FormatError(path, f"cannot draw to {kind or 'a file without extension'!r}; accepted: .svg, .png.")
    with atomic_path(path) as temporary:
        draw[kind](summary, temporary)
    return path


def _heading(summary: Summary) -> str:
    return f"{summary.title} by {summary.by}: {summary.clips:,} clips, {summary.minutes:.1f} minutes"


def _size(summary: Summary) -> tuple[int, int]:
    return _LEFT + _BARS + _RIGHT, _TOP + _ROW * len(summary.rows) + 12


def _lengths(summary: Summary) -> list[int]:
    most = max(row.clips for row in summary.rows)
    return [max(1, round(_BARS * row.clips / most)) for row in summary.rows]


def _draw_svg(summary: Summary, path: Path) -> None:
    width, height = _size(summary)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
        ' font-family="sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        f'<text x="16" y="28" font-size="16" font-weight="bold" fill="{_INK}">{escape(_heading(summary))}</text>',
    ]
    for index, (row, length) in enumerate(zip(summary.rows, _lengths(summary), strict=True)):
        top, numbers = _TOP + _ROW * index, f"{row.clips:,} ({row.minutes:.1f} min)"
        lines += [
            f'<text x="{_LEFT - 10}" y="{top + 15}" text-anchor="end" fill="{_INK}">{escape(row.value[:32])}</text>',
            f'<rect x="{_LEFT}" y="{top + 3}" width="{length}" height="{_ROW - 6}" rx="2" fill="{_BAR}"/>',
            f'<text x="{_LEFT + length + 8}" y="{top + 15}" fill="{_FAINT}">{numbers}</text>',
        ]
    path.write_text("\n".join([*lines, "</svg>", ""]), encoding="utf-8")


def _draw_png(summary: Summary, path: Path) -> None:
    from PIL import Image, ImageDraw, ImageFont

    scale = 2  # for sharp letters on dense screens
    width, height = _size(summary)
    picture = Image.new("RGB", (scale * width, scale * height), "#ffffff")
    pen = ImageDraw.Draw(picture)
    title, text = (ImageFont.load_default(scale * size) for size in (16, 13))
    pen.text((scale * 16, scale * 14), _heading(summary), fill=_INK, font=title)
    for index, (row, length) in enumerate(zip(summary.rows, _lengths(summary), strict=True)):
        middle = scale * (_TOP + _ROW * index + _ROW // 2)
        half = scale * (_ROW - 6) // 2
        pen.text((scale * (_LEFT - 10), middle), row.value[:32], fill=_INK, font=text, anchor="rm")
        pen.rectangle((scale * _LEFT, middle - half, scale * (_LEFT + length), middle + half), fill=_BAR)
        numbers = f"{row.clips:,} ({row.minutes:.1f} min)"
        pen.text((scale * (_LEFT + length + 8), middle), numbers, fill=_FAINT, font=text, anchor="lm")
    picture.save(path, format="PNG")


def _telling(clips: Sequence[Clip]) -> By:
    candidates: tuple[By, ...] = ("action", "label", "style")
    for by in candidates:
        if sum(getattr(clip, by) is not None for clip in clips) > len(clips) / 2:
            return by
    return "corpus"


def _minutes(clips: Sequence[Clip]) -> float:
    return sum(clip.motion.duration for clip in clips) / 60
