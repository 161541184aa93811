"""The files of a report: `table.md`, `table.csv`, `table.json`, and the page `index.html`."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from engines.evaluation import ActionBench, Results, Row, tables
from engines.formats.files import atomic_path
from engines.metrics.recognition import Recognised
from engines.motion import Motion
from studio.report import sections

_PAGE = Path(__file__).with_name("page.html")
_ON_THE_MAP = 300
"""About so many motions of each row are points of the map, as many of every action."""
_EXAMPLES = 6
"""Actions shown as players."""
_FIGURES = 5
"""Bodies in one player, about."""
_COLOURS = ("#56b4e9", "#e69f00", "#2fb98f", "#cc79a7", "#f0e442", "#d55e00", "#7d8ff0")
"""Of the generated rows in the player, as in the page's charts (`--s1` and so on, in the dark)."""


@dataclass(frozen=True)
class Samples:
    """Motions of each row that the page shows: the first of every action in the first repeat."""

    motions: Mapping[str, list[list[Motion]]]
    """Row -> for each action some motions; real ones under "real"."""
    features: Mapping[str, np.ndarray]
    """Row -> (actions * motions, features), in that order."""
    names: Sequence[str]
    """(actions * motions,) the action of each."""


def write_tables(folder: Path, results: Results, rows: Sequence[Row], left_out: dict[str, tuple[str, ...]]) -> None:
    """The table in three formats."""
    _write(folder / "table.md", tables.markdown(results, rows, left_out))
    _write(folder / "table.csv", tables.comma_separated(rows))
    values = tables.as_json(results, rows, left_out)
    _write(folder / "table.json", json.dumps(values, indent=1, ensure_ascii=False))


def write_report(  # noqa: PLR0913, PLR0917 - what a report tells of
    folder: Path,
    bench: ActionBench,
    engines: Mapping[str, Any],
    results: Results,
    repeats: int,
    facts: Mapping[str, str],
) -> Path:
    """The tables and the page; returns the page's path.

    Args:
        folder: that there is.
        bench: what was measured on.
        engines: by row name; they make the motions that are shown.
        results: the rows.
        repeats: how many of them count.
        facts: for the page's last part: the command, versions, hashes.
    """
    rows = results.shown(list(engines), repeats)
    write_tables(folder, results, rows, bench.left_out)
    samples = draw_samples(bench, engines)
    path = folder / "index.html"
    _write(path, page(bench, results, rows, samples, facts))
    return path


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


def page(bench: ActionBench, results: Results, rows: Sequence[Row], samples: Samples, facts: Mapping[str, str]) -> str:
    """The HTML text: everything inside, nothing fetched."""
    from viewers.web.controls import BUNDLE

    shown = examples(rows, bench.actions)
    made = [row.name for row in rows if row.kind == "made"]
    parts = {
        "title": sections.text(f"Evaluation of {', '.join(made)}"),
        "summary": sections.text(f"Action2Motion’s protocol: {len(bench.actions)} actions, "
                                 f"{bench.options.motions:,} motions a repeat, {bench.options.data} real clips."),
        "figures": sections.figures(results, rows, bench.left_out),
        "published": sections.published_figures(),
        "examples": sections.example_buttons([(bench.actions[i], why) for i, why in shown]),
        "actions": sections.by_action(rows, bench.actions),
        "confusion": sections.confusions(rows, bench),
        "map": sections.maps(samples.features, samples.names, bench.options.seed),
        "again": sections.again(rows, results, facts),
        "values": _player_values(samples, [i for i, _ in shown]),
        "bundle": base64.b64encode(BUNDLE.read_bytes()).decode(),
    }  # fmt: skip
    html = _PAGE.read_text(encoding="utf-8")
    for name, content in parts.items():
        html = html.replace(f"[[{name}]]", content)
    return html


def examples(rows: Sequence[Row], actions: Sequence[str]) -> list[tuple[int, str]]:
    """Actions to look at, and why: those best recognised, some in the middle, and the worst."""
    order = np.argsort([-v for v in sections.mean_of_made(rows, "accuracy")], kind="stable").tolist()
    if len(order) <= _EXAMPLES:
        return [(i, "") for i in order]
    middle = (len(order) - 2) // 2
    chosen = [*order[:2], *order[middle : middle + 2], *order[-2:]]
    return list(zip(chosen, ["best", "best", "middling", "middling", "worst", "worst"], strict=True))


def _player_values(samples: Samples, actions: Sequence[int]) -> str:
    """Body, options, and one payload for each action: a real motion, then some of each engine."""
    from viewers import bodies
    from viewers.web.controls import actors_of, encode
    from viewers.web.payload import MAX_ACTORS, Actor

    made = [name for name in samples.motions if name != "real"]
    each = max(1, (_FIGURES - 1) // len(made))
    body, takes = b"", []
    for action in actions:
        cast = [Actor(samples.motions["real"][action][0], "real")]
        for name, colour in zip(made, cycle(_COLOURS), strict=False):
            some = samples.motions[name][action][:each]
            short = name.partition(":")[2] or name
            cast += [Actor(m, short if each == 1 else f"{short}, {k}", colour) for k, m in enumerate(some, start=1)]
        body, data = encode(actors_of(cast[:MAX_ACTORS]), bodies.DEFAULT)
        takes.append(base64.b64encode(data).decode())
    options = {"theme": "auto", "playing": True, "camera": "front"}
    values = {"options": options, "body_data": base64.b64encode(body).decode(), "takes": takes}
    return json.dumps(values).replace("<", "\\u003c")


def _write(path: Path, text: str) -> None:
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
