"""Small charts as inline SVG: colours come from the page's style, so that they read in the light and in the dark.

Every chart has a title for those who cannot see it, and every mark one that is shown where the pointer rests.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

LINE = 17
"""Pixels of a row of a chart."""
NAMES = 190
"""Pixels for the names beside it."""


def dots(
    title: str, labels: Sequence[str], series: Mapping[str, np.ndarray], *, log: bool = False, percent: bool = False
) -> str:
    """A row a label, a dot a series on one axis.

    Args:
        title: for screen readers.
        labels: of the rows, from the top.
        series: name -> (labels,) values; the k-th has the class `s{k}`, the first is drawn as a ring.
        log: axis of ratios; for values that are far apart.
        percent: values are shares.
    """
    values = np.stack(list(series.values()))
    axis = _Axis.logarithmic(values) if log else _Axis.linear(0.0, 1.0 if percent else float(values.max()))
    width, height = NAMES + 760, LINE * len(labels) + 30

    def x(value: float) -> float:
        return NAMES + 10 + axis.share(value) * (width - NAMES - 40)

    def shown(value: float) -> str:
        return f"{100 * value:.0f} %" if percent else f"{value:.3g}"

    parts = []
    for tick in axis.ticks:
        parts.append(f'<path class="grid" d="M{x(tick):.1f} 4V{height - 22}"/>')
        parts.append(f'<text class="mid" x="{x(tick):.1f}" y="{height - 6}">{shown(tick)}</text>')
    for row, label in enumerate(labels):
        y = LINE * row + 14
        low, high = values[:, row].min(), values[:, row].max()
        parts.append(f'<text class="end" x="{NAMES}" y="{y + 4}">{escape(label)}</text>')
        parts.append(f'<path class="range" d="M{x(low):.1f} {y}H{x(high):.1f}"/>')
        marks = []
        for k, (name, column) in enumerate(series.items()):
            hint = f"<title>{escape(label)}, {escape(name)}: {shown(column[row])}</title>"
            # side by side where they fall together
            off, size = (0.0, 6.5) if k == 0 else (9.0 * ((k - 0.5) / (len(series) - 1) - 0.5), 4.0)
            marks.append(
                f'<circle class="s{k}" cx="{x(column[row]):.1f}" cy="{y + off:.1f}" r="{size}">{hint}</circle>'
            )
        parts += marks[::-1]  # the first is a ring around what it falls together with
    return _svg(title, width, height, parts)


def confusion(title: str, labels: Sequence[str], shares: np.ndarray) -> str:
    """A matrix of what was asked for (rows) and what it was taken for (columns).

    Args:
        title: for screen readers.
        labels: of the rows, and of the first columns; there may be one more column, for all other answers.
        shares: (rows, columns) from 0 to 1, each row adding up to 1.
    """
    cell, top = 15, 170
    columns = [*labels, "any other"][: shares.shape[1]]
    width, height = NAMES + cell * len(columns) + 60, top + cell * len(labels) + 8
    parts = [f'<rect class="field" x="{NAMES + 6}" y="{top}" width="{cell * len(columns)}" '
             f'height="{cell * len(labels)}"/>']  # fmt: skip
    for j, name in enumerate(columns):
        place = f"translate({NAMES + 6 + cell * j + 11},{top - 6}) rotate(-60)"
        parts.append(f'<text transform="{place}">{escape(name)}</text>')
    for i, name in enumerate(labels):
        y = top + cell * i
        parts.append(f'<text class="end" x="{NAMES}" y="{y + 11}">{escape(name)}</text>')
        for j in np.flatnonzero(shares[i] >= 0.005):
            kind = "right" if i == j else "wrong"
            hint = f"{name} taken for {columns[j]}: {100 * shares[i, j]:.0f} %" if i != j else (
                f"{name} recognised: {100 * shares[i, j]:.0f} %")  # fmt: skip
            parts.append(
                f'<rect class="{kind}" x="{NAMES + 6 + cell * j}" y="{y}" width="{cell}" height="{cell}" '
                f'fill-opacity="{math.sqrt(shares[i, j]):.2f}"><title>{escape(hint)}</title></rect>'
            )
    return _svg(title, width, height, parts)


def scatter(title: str, real: np.ndarray, made: np.ndarray, names: Sequence[str], kind: int) -> str:
    """Generated motions over real ones on a plane.

    Args:
        title: for screen readers.
        real: (N, 2) points, grey; from 0 to 1.
        made: (M, 2) points, from 0 to 1.
        names: (M,) what each is.
        kind: number of the series, which has its colour.
    """
    size = 340
    places = 10 + (size - 20) * np.concatenate([real, made])
    places[:, 1] = size - places[:, 1]
    grey = "".join(f"M{x:.0f} {y:.0f}h0" for x, y in places[: len(real)])
    parts = [f'<rect class="field" width="{size}" height="{size}" rx="8"/>', f'<path class="real" d="{grey}"/>']
    for (x, y), name in zip(places[len(real) :], names, strict=True):
        parts.append(f'<circle class="s{kind}" cx="{x:.0f}" cy="{y:.0f}" r="3"><title>{escape(name)}</title></circle>')
    return _svg(title, size, size, parts)


class _Axis:
    """From values to shares of a length, with round numbers to mark on it."""

    def __init__(self, low: float, high: float, ticks: Sequence[float], log: bool) -> None:
        self.low, self.high, self.ticks, self.log = low, high, ticks, log

    def share(self, value: float) -> float:
        if self.log:
            return (math.log(max(value, self.low)) - self.low_log) / (math.log(self.high) - self.low_log)
        return (value - self.low) / (self.high - self.low)

    @property
    def low_log(self) -> float:
        return math.log(self.low)

    @classmethod
    def linear(cls, low: float, high: float) -> _Axis:
        span = high - low if high > low else 1.0
        step = 10.0 ** math.floor(math.log10(span / 3))
        step *= next(factor for factor in (1, 2, 5, 10) if span / (factor * step) <= 5)
        count = math.ceil(span / step - 1e-9)
        return cls(low, low + count * step, [low + i * step for i in range(count + 1)], False)

    @classmethod
    def logarithmic(cls, values: np.ndarray) -> _Axis:
        highest = float(values.max()) or 1.0
        positive = values[values > highest * 1e-3]
        lowest = float(positive.min()) if positive.size else highest / 10
        first, last = math.floor(math.log10(lowest)), math.ceil(math.log10(highest) + 1e-9)
        marks = [factor * 10.0**power for power in range(first - 1, last + 1) for factor in (1, 2, 5)]
        low = max(mark for mark in marks if mark <= lowest * (1 + 1e-9))
        high = min(mark for mark in marks if mark >= highest * (1 - 1e-9) and mark > low)
        return cls(low, high, [mark for mark in marks if low <= mark <= high], True)


def _svg(title: str, width: float, height: float, parts: Sequence[str]) -> str:
    head = f'<svg viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" role="img"><title>{escape(title)}</title>'
    return head + "".join(parts) + "</svg>"
