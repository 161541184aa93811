"""The page about engines that put motions in other manners."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from engines.evaluation import Results, Row, StyleBench
from engines.motion import Motion
from studio.report import sections
from studio.report.content import Content, Part, cast

_ON_THE_MAP = 150
"""Motions of each row that are points of the map."""
_EXAMPLES = 6
"""Motions shown as players."""


def content(
    bench: StyleBench, engines: Mapping[str, Any], results: Results, rows: Sequence[Row], facts: Mapping[str, str]
) -> Content:
    """What the page holds; the engines make the motions it shows."""
    wishes = bench.wishes(0)[:_ON_THE_MAP]
    made = {name: [bench.make(engine, wish)[0].resample(20.0) for wish in wishes] for name, engine in engines.items()}
    real = [bench.reference(wish) for wish in wishes]
    features = {"real": np.asarray(bench.manners.recognised(real).features)}
    features |= {name: np.asarray(bench.manners.recognised(motions).features) for name, motions in made.items()}
    looked = (
        f"What the recogniser of styles sees of {len(wishes):,} motions of each row. Grey: the clips that give the "
        "styles; coloured: other movements in these styles. They should lie in the same places."
    )
    intro = "The first of the first repeat, not chosen; beside the motion as it was (grey)."
    shown = wishes[:_EXAMPLES]
    names = [f"{bench.contents[wish.content].action or 'motion'} → {wish.style}" for wish in shown]
    planes = sections.maps(features, [wish.style for wish in wishes], looked, bench.options.seed)
    parts = [
        Part("figures", "Figures", "Figures", sections.figures(results, rows, bench.left_out)),
        Part("published", "The papers’ figures", "Published", sections.published_figures(results)),
        Part("examples", "Examples", "Examples", sections.example_buttons(names, intro)),
        Part("map", "Feature map", "Feature map", planes),
        Part("again", "To make this again", "Again", sections.again(rows, results, facts)),
    ]
    return Content(
        title=f"Evaluation of {', '.join(engines)}",
        summary=f"Generative stylization’s protocol: {bench.options.motions:,} motions a repeat, "
        f"{len(bench.styles)} styles, {bench.options.data} clips of {bench.options.corpus}.",
        parts=parts,
        casts=[cast(bench.content(wish), _of(made, i)) for i, wish in enumerate(shown)],
    )


def _of(made: Mapping[str, Sequence[Motion]], index: int) -> dict[str, list[Motion]]:
    return {name: [motions[index]] for name, motions in made.items()}
