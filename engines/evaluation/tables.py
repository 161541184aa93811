"""The table of an evaluation as Markdown, CSV and JSON, with the papers' figures below it."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from engines.evaluation import notes as reading
from engines.evaluation import published
from engines.evaluation.published import Papers
from engines.evaluation.results import Results, Row
from engines.evaluation.rounds import REAL, TRAINING
from engines.metrics.protocol import METRICS, Estimate, Metric


def columns(rows: Sequence[Row]) -> dict[str, Metric]:
    """The metrics that any of the rows has, in the order of the papers."""
    there = {name for row in rows for name in row.repeats[0].figures}
    return {name: metric for name, metric in METRICS.items() if name in there}


PAPERS = (
    "transition_fid", "fid", "accuracy_top1", "accuracy_late", "accuracy_top5", "diversity", "multimodality",
    "r_precision_top1", "r_precision_top2", "r_precision_top3", "multimodal_distance", "style_accuracy", "style_fid",
    "content_accuracy", "content_fid", "pose_distance",
)  # fmt: skip
"""Columns of the papers; the others are physical."""


def heading(metric: Metric) -> str:
    """Title, arrow and unit."""
    return f"{metric.title} {metric.arrow}" + (f" ({metric.unit})" if metric.unit else "")


def best(rows: Sequence[Row], name: str) -> tuple[str, ...]:
    """The rows of generated motions with the best mean, several where they tie; none if there is nothing to choose.

    "Like real" is like motions of the training split where it has a row: there are more clips of each action than are
    held out.
    """
    made = {row.name: row.estimates[name].mean for row in rows if row.kind == "made" and name in row.estimates}
    real = {row.name: row.estimates[name].mean for row in rows if row.kind == "real" and name in row.estimates}
    target = real.get(TRAINING, real.get(REAL))
    better = METRICS[name].better
    if len(set(made.values())) < 2 or (better == "like real" and target is None):
        return ()
    loss = {"higher": lambda mean: -mean, "lower": lambda mean: mean, "like real": lambda mean: abs(mean - target)}
    found = {row: loss[better](mean) for row, mean in made.items()}
    return tuple(row for row, value in found.items() if value == min(found.values()))


def same_networks(rows: Sequence[Row]) -> list[str]:
    """Pairs of generated rows that agree to all digits in some figure, in every repeat: they share networks."""
    said = []
    for one, other in combinations([row for row in rows if row.kind == "made"], 2):
        first, second = one.estimates, other.estimates
        names = [n for n in columns([one]) if n not in PAPERS and n in second and any(first[n].values)]
        alike = [METRICS[n].title.lower() for n in names if first[n].values == second[n].values]
        if alike:
            said.append(
                f"{one.name} and {other.name} agree to all digits in {', '.join(alike)}: they are not independent, "
                "some of their networks are the same."
            )
    return said


def cell(estimate: Estimate | None) -> str:
    """Mean and half width, fewer digits behind the point where there are more before it; a dash for none."""
    if estimate is None:
        return "–"
    size = abs(estimate.mean)
    digits = 3 if size < 10 else 2 if size < 100 else 1
    return f"{estimate.mean:.{digits}f} ± {estimate.half_width:.{digits}f}"


def notes(results: Results, rows: Sequence[Row], left_out: Mapping[str, tuple[str, ...]]) -> list[str]:
    """How to read the table, a sentence or two each."""
    said = [*reading.notes(results, rows), *same_networks(rows)]
    return said + [f"Left out, {reason}: {', '.join(names)}." for reason, names in left_out.items()]


def papers(results: Results) -> Papers:
    """What was published of the protocol."""
    return published.PAPERS[results.basis.get("protocol", "action2motion")]


def markdown(results: Results, rows: Sequence[Row], left_out: Mapping[str, tuple[str, ...]]) -> str:
    """The table, how to read it, and the published figures."""
    names = columns(rows)
    others = papers(results)
    lines = [f"# {others.title}\n", _line(["", *map(heading, names.values())]), _rule(len(names))]
    winners = {name: best(rows, name) for name in names}
    for row in rows:
        found = row.estimates
        cells = [cell(found.get(name)) for name in names]
        marked = [f"**{c}**" if row.name in winners[n] else c for n, c in zip(names, cells, strict=True)]
        lines.append(_line([row.name, *marked]))
    lines += ["", *(f"- {note}" for note in notes(results, rows, left_out))]
    lines += ["", "## The papers' figures\n", f"{published.WARNING.capitalize()}. {others.note}\n"]
    titles = [heading(METRICS[name]) for name in others.columns]
    lines += [_line(["", *titles, "data", "source"]), _rule(len(titles) + 2)]
    for other in others.rows:
        cells = [cell(other.figures.get(name)) for name in others.columns]
        lines.append(_line([other.method, *cells, other.data, other.table]))
    return "\n".join(lines) + "\n"


def comma_separated(results: Results, rows: Sequence[Row]) -> str:
    """A line a row: mean and half width of each figure; published rows say so in `source`."""
    names = columns(rows)
    fields = ["row", "source", "data", "repeats", *(f"{n}{end}" for n in names for end in ("", "_half_width"))]
    text = io.StringIO()
    writer = csv.DictWriter(text, fields, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        facts = {"row": row.name, "source": "measured here", "data": "", "repeats": len(row.repeats)}
        writer.writerow({**facts, **_spread(row.estimates)})
    for other in papers(results).rows:
        facts = {"row": other.method, "source": f"published ({other.table}), on other data", "data": other.data}
        writer.writerow({**facts, **_spread({k: v for k, v in other.figures.items() if k in names})})
    return text.getvalue()


def as_json(results: Results, rows: Sequence[Row], left_out: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    """Everything as JSON values: figures with what each repeat gave, per-action figures, published rows."""
    return {
        "basis": results.basis,
        "left out": {reason: list(names) for reason, names in left_out.items()},
        "metrics": {n: {"title": m.title, "better": m.better, "unit": m.unit} for n, m in columns(rows).items()},
        "rows": [_row_json(results, row) for row in rows],
        "published, on other data": [
            {"row": other.method, "data": other.data, "source": other.table, "figures": _figures(other.figures)}
            for other in papers(results).rows
        ],
    }


def _row_json(results: Results, row: Row) -> dict[str, Any]:
    each = {what: dict(zip(results.actions, row.of_actions(what).tolist(), strict=True)) for what in
            ("accuracy", "frechet")} if results.actions else {}  # fmt: skip
    facts = {"kind": row.kind, "weights": row.weights, "repeats": len(row.repeats), **row.facts}
    return {"row": row.name, **facts, "figures": _figures(row.estimates), **({"actions": each} if each else {})}


def _figures(figures: dict[str, Estimate]) -> dict[str, Any]:
    return {n: {"mean": e.mean, "half_width": e.half_width, "repeats": list(e.values)} for n, e in figures.items()}


def _spread(figures: dict[str, Estimate]) -> dict[str, float]:
    means = {name: found.mean for name, found in figures.items()}
    return {**means, **{f"{name}_half_width": found.half_width for name, found in figures.items()}}


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _rule(count: int) -> str:
    return "|" + "---|" * (count + 1)
