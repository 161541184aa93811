"""The page about engines that go by actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from engines.evaluation import ActionBench, Results, Row
from engines.metrics.recognition import Recognised
from engines.motion import Motion
from studio.report import sections
from studio.report.content import Content, Part, cast

_ON_THE_MAP = 300
"""About so many motions of each row are points of the map, as many of every action."""
_EXAMPLES = 6
"""Actions shown as players."""


@dataclass(frozen=True)
class Samples:
    """Motions of each row that the page shows: the first of every action in the first repeat."""

    motions: Mapping[str, list[list[Motion]]]
    """Row -> for each action some motions; real ones under "real"."""
    features: Mapping[str, np.ndarray]
    """Row -> (actions * motions, features), in that order."""
    names: Sequence[str]
    """(actions * motions,) the action of each."""


def draw_samples(bench: ActionBench, engines: Mapping[str, Any]) -> Samples:
    """As many motions of every action from each engine, and real ones."""
    count = max(1, min(6, _ON_THE_MAP // len(bench.actions)))
    labels = np.repeat(np.arange(len(bench.actions)), count)
    chosen = bench.real.draw(labels, np.random.default_rng(bench.options.seed))
    real = [bench.real.stretches[i].motion for i in chosen]
    motions = {"real": [real[i : i + count] for i in range(0, len(real), count)]}
    features = {"real": np.asarray(bench.real.recognised(chosen).features)}
    for name, engine in engines.items():
        motions[name] = bench.sample(engine, count)
        seen: Recognised = bench.recogniser.recognised([m for same in motions[name] for m in same])
        features[name] = np.asarray(seen.features)
    return Samples(motions, features, [bench.actions[i] for i in labels])


def content(
    bench: ActionBench, engines: Mapping[str, Any], results: Results, rows: Sequence[Row], facts: Mapping[str, str]
) -> Content:
    """What the page holds; the engines make the motions it shows."""
    samples = draw_samples(bench, engines)
    shown = examples(rows, bench.actions)
    buttons = [f"{bench.actions[i]} ({why})" if why else bench.actions[i] for i, why in shown]
    intro = (
        "The first motions of the first repeat, not chosen, beside a real one; of the actions that are recognised "
        "best, middling and worst."
    )
    looked = (
        f"What the recogniser sees of {len(samples.names):,} motions of each row. Grey: held-out real motions; "
        "coloured: generated, over the same ones. Generated motions should lie where real ones do."
    )
    planes = sections.maps(samples.features, samples.names, looked, bench.options.seed)
    parts = [
        Part("figures", "Figures", "Figures", sections.figures(results, rows, bench.left_out)),
        Part("published", "The papers’ figures", "Published", sections.published_figures(results)),
        Part("examples", "Examples", "Examples", sections.example_buttons(buttons, intro)),
        Part("actions", "By action", "By action", sections.by_action(rows, bench.actions)),
        Part("confusion", "Confusion", "Confusion", sections.confusions(rows, bench)),
        Part("map", "Feature map", "Feature map", planes),
        Part("again", "To make this again", "Again", sections.again(rows, results, facts)),
    ]
    casts = []
    for index, _ in shown:
        made = {name: motions[index] for name, motions in samples.motions.items() if name != "real"}
        casts.append(cast(samples.motions["real"][index][0], made))
    return Content(
        title=f"Evaluation of {', '.join(engines)}",
        summary=f"Action2Motion’s protocol: {len(bench.actions)} actions, {bench.options.motions:,} motions a repeat, "
        f"{bench.options.data} real clips.",
        parts=parts,
        casts=casts,
    )


def examples(rows: Sequence[Row], actions: Sequence[str]) -> list[tuple[int, str]]:
    """Actions to look at, and why: those best recognised, some in the middle, and the worst."""
    order = np.argsort([-v for v in sections.mean_of_made(rows, "accuracy")], kind="stable").tolist()
    if len(order) <= _EXAMPLES:
        return [(i, "") for i in order]
    middle = (len(order) - 2) // 2
    chosen = [*order[:2], *order[middle : middle + 2], *order[-2:]]
    return list(zip(chosen, ["best", "best", "middling", "middling", "worst", "worst"], strict=True))
