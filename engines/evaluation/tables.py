"""The table of an evaluation as Markdown, CSV and JSON, with the papers' figures below it."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import combinations
from typing import Any

from engines.evaluation import published
from engines.evaluation.actions import COMPONENTS, PHYSICAL, REAL, TRAINING
from engines.evaluation.published import Published
from engines.evaluation.results import Results, Row
from engines.metrics.protocol import ACTION2MOTION, METRICS, Estimate, Metric


def columns(rows: Sequence[Row]) -> dict[str, Metric]:
    """The metrics that any of the rows has, in the order of the papers."""
    there = {name for row in rows for name in row.repeats[0].figures}
    return {name: metric for name, metric in METRICS.items() if name in there}


PAPERS = ("fid", "accuracy_top1", "accuracy_top5", "diversity", "multimodality")
"""Columns of the papers; the others are physical."""


def heading(metric: Metric) -> str:
    """Title, arrow and unit."""
    return f"{metric.title} {metric.arrow}" + (f" ({metric.unit})" if metric.unit else "")


def best(rows: Sequence[Row], name: str) -> tuple[str, ...]:
    """The rows of generated motions with the best mean, several where they tie; none if there is nothing to choose.

    "Like real" is like motions of the training split: there are more clips of each action than are held out.
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


def notes(results: Results, rows: Sequence[Row], left_out: dict[str, tuple[str, ...]]) -> list[str]:
    """How to read the table, a sentence or two each."""
    basis = results.basis
    repeats = sorted({len(row.repeats) for row in rows})
    said = [
        f"Mean ± half width of the 95 % interval (Student's t) over {' or '.join(map(str, repeats))} "
        f"repeat{'s' if repeats[-1] > 1 else ''} of {basis['motions']:,} motions of {basis['frames']} frames at 20 "
        f"frames a second; {len(results.actions)} actions in equal parts; seed {basis['seed']}.",
        "↑ higher is better, ↓ lower is better, → the closer to real motions of the training split the better. "
        "Bold: the best mean of the generated; a difference smaller than the intervals is none.",
        f"FID compares with held-out real clips (data: {basis['data']}), drawn with replacement, as many of each "
        "action. All rows meet the same draw in the same repeat. A clip longer than a generated motion gives a stretch "
        "of it, a shorter one counts as it is.",
        f"`{REAL}` is a second draw from the same clips: what real motion itself scores; its multimodality is low "
        f"where an action has few clips. `{TRAINING}` is drawn from the clips that engines and recogniser were trained "
        "on, so that its accuracy is no measure of the recogniser.",
        f"Accuracy counts over all {len(results.answers)} labels of the recogniser. Diversity: "
        f"{ACTION2MOTION.diversity_pairs} pairs; multimodality: {ACTION2MOTION.multimodality_pairs} pairs an action.",
        f"Physical measures: about {PHYSICAL} motions of each repeat, the first of every action. Per-action Fréchet "
        f"distances are taken in the first {COMPONENTS} principal components of the held-out clips' features: single "
        "actions have too few motions for all of them.",
    ]
    if any("bone_length_drift" in row.repeats[0].figures for row in rows):
        said.append("Bone-length drift is that of the joints as the network gives them; motions themselves are rigid.")
    said += same_networks(rows)
    said += [f"Left out, {reason}: {', '.join(names)}." for reason, names in left_out.items()]
    return said


def markdown(results: Results, rows: Sequence[Row], left_out: dict[str, tuple[str, ...]]) -> str:
    """The table, how to read it, and the published figures."""
    names = columns(rows)
    lines = ["# Action2Motion's protocol\n", _line(["", *map(heading, names.values())]), _rule(len(names))]
    winners = {name: best(rows, name) for name in names}
    for row in rows:
        found = row.estimates
        cells = [cell(found.get(name)) for name in names]
        marked = [f"**{c}**" if row.name in winners[n] else c for n, c in zip(names, cells, strict=True)]
        lines.append(_line([row.name, *marked]))
    lines += ["", *(f"- {note}" for note in notes(results, rows, left_out))]
    lines += ["", "## The papers' figures\n", f"{published.WARNING.capitalize()}.\n"]
    titles = [heading(METRICS[name]) for name in published.COLUMNS]
    lines += [_line(["", *titles, "data", "source"]), _rule(len(titles) + 2)]
    for other in published.ACTION2MOTION:
        lines.append(_line([other.method, *_published_cells(other), other.data, other.table]))
    return "\n".join(lines) + "\n"


def comma_separated(rows: Sequence[Row]) -> str:
    """A line a row: mean and half width of each figure; published rows say so in `source`."""
    names = columns(rows)
    fields = ["row", "source", "data", "repeats", *(f"{n}{end}" for n in names for end in ("", "_half_width"))]
    text = io.StringIO()
    writer = csv.DictWriter(text, fields, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        facts = {"row": row.name, "source": "measured here", "data": "", "repeats": len(row.repeats)}
        writer.writerow({**facts, **_spread(row.estimates)})
    for other in published.ACTION2MOTION:
        facts = {"row": other.method, "source": f"published ({other.table}), on other data", "data": other.data}
        writer.writerow({**facts, **_spread({k: v for k, v in other.figures.items() if k in names})})
    return text.getvalue()


def as_json(results: Results, rows: Sequence[Row], left_out: dict[str, tuple[str, ...]]) -> dict[str, Any]:
    """Everything as JSON values: figures with what each repeat gave, per-action figures, published rows."""
    return {
        "basis": results.basis,
        "left out": {reason: list(names) for reason, names in left_out.items()},
        "metrics": {n: {"title": m.title, "better": m.better, "unit": m.unit} for n, m in columns(rows).items()},
        "rows": [_row_json(results, row) for row in rows],
        "published, on other data": [
            {"row": other.method, "data": other.data, "source": other.table, "figures": _figures(other.figures)}
            for other in published.ACTION2MOTION
        ],
    }


def _row_json(results: Results, row: Row) -> dict[str, Any]:
    each = {what: dict(zip(results.actions, row.of_actions(what).tolist(), strict=True)) for what in
            ("accuracy", "frechet")}  # fmt: skip
    facts = {"kind": row.kind, "weights": row.weights, "repeats": len(row.repeats), **row.facts}
    return {"row": row.name, **facts, "figures": _figures(row.estimates), "actions": each}


def _figures(figures: dict[str, Estimate]) -> dict[str, Any]:
    return {n: {"mean": e.mean, "half_width": e.half_width, "repeats": list(e.values)} for n, e in figures.items()}


def _spread(figures: dict[str, Estimate]) -> dict[str, float]:
    means = {name: found.mean for name, found in figures.items()}
    return {**means, **{f"{name}_half_width": found.half_width for name, found in figures.items()}}


def _published_cells(row: Published) -> list[str]:
    return [cell(row.figures.get(name)) for name in published.COLUMNS]


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _rule(count: int) -> str:
    return "|" + "---|" * (count + 1)
