"""The parts of the report's page, each a piece of HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Literal

import numpy as np

from engines.evaluation import ActionBench, Results, Row, published, tables
from engines.evaluation.actions import COMPONENTS
from engines.evaluation.rounds import REAL
from engines.metrics.protocol import METRICS, Estimate
from studio.report import charts
from studio.report import maps as plane

_WORST = 8
"""Confusions that are told in words."""


def text(words: str) -> str:
    """Safe as HTML; `code` in backticks."""
    pieces = escape(words, quote=False).split("`")
    return "".join(f"<code>{piece}</code>" if i % 2 else piece for i, piece in enumerate(pieces))


def figures(results: Results, rows: Sequence[Row], left_out: Mapping[str, tuple[str, ...]]) -> str:
    """The table, the papers' columns apart from the physical ones, and how to read it."""
    names = list(tables.columns(rows))
    said = "".join(f"<li>{text(note)}</li>" for note in tables.notes(results, rows, left_out))
    papers = [name for name in names if name in tables.PAPERS]
    physical = [name for name in names if name not in tables.PAPERS]
    apart = f"<h3>Is it physically plausible</h3>{_table(rows, physical)}"
    return f'{_table(rows, papers)}{apart}<ul class="notes">{said}</ul>'


def _table(rows: Sequence[Row], names: Sequence[str]) -> str:
    winners = {name: tables.best(rows, name) for name in names}
    lines = []
    for row in rows:
        found = row.estimates
        cells = "".join(_cell(found.get(name), row.name in winners[name]) for name in names)
        key = f'<span class="key s{_series(rows).index(row.name)}"></span>' if row.name in _series(rows) else ""
        lines.append(f'<tr class="{row.kind}"><th scope="row">{key}{text(row.name)}</th>{cells}</tr>')
    heads = "".join(f'<th scope="col">{_heading(name)}</th>' for name in names)
    return (
        f'<div class="wide"><table><thead><tr><th scope="col"></th>{heads}</tr></thead><tbody>{"".join(lines)}</tbody>'
        "</table></div>"
    )


def published_figures(results: Results) -> str:
    """The papers' rows, with the warning above them."""
    papers = tables.papers(results)
    heads = "".join(f'<th scope="col">{_heading(name)}</th>' for name in papers.columns)
    lines = []
    for row in papers.rows:
        cells = "".join(_cell(row.figures.get(name), False) for name in papers.columns)
        where = f'<td class="text">{text(row.data)}</td><td class="text">{text(row.table)}</td>'
        kind = "real" if row.method.startswith("Real") else "made"
        lines.append(f'<tr class="{kind}"><th scope="row">{text(row.method)}</th>{cells}{where}</tr>')
    return (
        f'<p class="warning">{text(published.WARNING.capitalize())}.</p><p class="dim">An FID is in the units of the '
        f"features it is taken in, so the numbers of another evaluator say nothing about ours. {text(papers.note)}</p>"
        f'<div class="wide"><table><thead><tr><th scope="col"></th>{heads}<th scope="col" class="text">data</th>'
        f'<th scope="col" class="text">source</th></tr></thead><tbody>{"".join(lines)}</tbody></table></div>'
    )


def example_buttons(names: Sequence[str], intro: str) -> str:
    """A button an example, and the place of the player."""
    buttons = "".join(
        f'<button aria-pressed="{str(i == 0).lower()}">{text(name)}</button>' for i, name in enumerate(names)
    )
    return f'<p class="dim">{text(intro)}</p><div class="tools">{buttons}</div><div id="player"></div>'


def by_action(rows: Sequence[Row], actions: Sequence[str]) -> str:
    """Two charts: how often each action is recognised, and how far it is from real ones."""
    series = [row for row in rows if row.name in _series(rows)]
    parts = [legend(rows)]
    said: tuple[tuple[Literal["accuracy", "frechet"], str], ...] = (
        ("accuracy", "Share of motions recognised as what was asked for"),
        ("frechet", f"Fréchet distance to held-out real motions of the same action, first {COMPONENTS} principal "
                    "components, logarithmic"),
    )  # fmt: skip
    for what, title in said:
        means = np.array(mean_of_made(rows, what))
        order = np.argsort(-means if what == "accuracy" else means, kind="stable")
        columns = {row.name: row.of_actions(what)[order] for row in series}
        ordered = [actions[int(i)] for i in order]
        chart = charts.dots(title, ordered, columns, log=what == "frechet", percent=what == "accuracy")
        parts.append(f"<h3>{text(title)}</h3>{chart}")
    return "".join(parts)


def confusions(rows: Sequence[Row], bench: ActionBench) -> str:
    """A matrix a row, and its largest confusions in words."""
    parts = [
        '<p class="dim">Rows: asked for. Columns: taken for. Blue: right; orange: wrong; the stronger, the more.</p>'
    ]
    labels = bench.recogniser.labels
    others = [i for i in range(len(labels)) if i not in set(bench.answers.tolist())]
    opened = next(row.name for row in rows if row.kind == "made")
    for row in rows:
        if row.name != REAL and row.kind == "real":
            continue
        counts = row.confusion(len(bench.actions), len(labels))
        shares = counts / counts.sum(axis=1, keepdims=True)
        columns = [shares[:, bench.answers]] + ([shares[:, others].sum(axis=1, keepdims=True)] if others else [])
        chart = charts.confusion(f"Confusion matrix of {row.name}", bench.actions, np.concatenate(columns, axis=1))
        parts.append(
            f"<details{' open' if row.name == opened else ''}><summary>{text(row.name)}</summary>"
            f'<p class="dim">Most often: {text(_most_confused(shares, bench))}.</p>'
            f'<div class="wide">{chart}</div></details>'
        )
    return "".join(parts)


def maps(features: Mapping[str, np.ndarray], names: Sequence[str], intro: str, seed: int) -> str:
    """The features of real and generated motions on a plane, by principal components and, where it can be, t-SNE.

    Args:
        features: row -> (N, D); real ones under "real".
        names: (N,) what each motion is of.
        intro: what is seen.
        seed: of t-SNE.
    """
    together = np.concatenate(list(features.values()))
    points, share = plane.principal(together)
    parts = [_panels(f"Principal components 1 and 2 ({100 * share:.0f} % of the variance)", points, features, names)]
    if plane.can_neighbours():
        points = plane.neighbours(together, seed)
        parts.insert(
            0, _panels("t-SNE (near stays near; distances between groups mean little)", points, features, names)
        )
    else:
        parts.append('<p class="dim">No t-SNE: it needs scikit-learn (pip install "motionloom[reports]").</p>')
    return f'<p class="dim">{text(intro)}</p><div class="planes">{"".join(parts)}</div>'


def again(rows: Sequence[Row], results: Results, facts: Mapping[str, str]) -> str:
    """The command, versions, seeds and hashes."""
    basis = results.basis
    known = {
        **facts,
        "seed": str(basis["seed"]),
        "evaluator weights (SHA-256)": basis["evaluator"],
        "held-out clips": f"{basis['data']}, fingerprint {basis['clips']}",
    }
    if "training clips" in basis:
        known["training clips"] = f"fingerprint {basis['training clips']}"
    for row in rows:
        if row.kind == "made":
            seconds = np.median([repeat.seconds for repeat in row.repeats])
            known[f"{row.name}, weights (SHA-256)"] = f"{row.weights} ({seconds:.0f} s a repeat)"
    items = "".join(f"<dt>{text(name)}</dt><dd><code>{text(value)}</code></dd>" for name, value in known.items())
    actions = f"<p class='dim'>The actions: {text(', '.join(results.actions))}.</p>" if results.actions else ""
    return f"<dl>{items}</dl>{actions}"


def legend(rows: Sequence[Row]) -> str:
    """Which colour is which row."""
    items = "".join(f'<span><span class="key s{k}"></span>{text(name)}</span>' for k, name in enumerate(_series(rows)))
    return f'<div class="legend">{items}</div>'


def mean_of_made(rows: Sequence[Row], what: Literal["accuracy", "frechet"]) -> list[float]:
    """Of each action the mean over the generated rows."""
    return np.mean([row.of_actions(what) for row in rows if row.kind == "made"], axis=0).tolist()


def _series(rows: Sequence[Row]) -> list[str]:
    """Names of the rows that have a colour: held-out real motions (0), then the generated."""
    return [REAL, *(row.name for row in rows if row.kind == "made")]


def _panels(title: str, points: np.ndarray, features: Mapping[str, np.ndarray], names: Sequence[str]) -> str:
    """One picture a generated row, all with the same real motions under them."""
    low, high = points.min(axis=0), points.max(axis=0)
    unit = (points - low) / np.where(high > low, high - low, 1.0)
    parts = np.split(unit, np.cumsum([len(values) for values in features.values()])[:-1])
    placed = dict(zip(features, parts, strict=True))
    figures = []
    for kind, name in enumerate((name for name in features if name != "real"), start=1):
        chart = charts.scatter(f"{title}: {name} and real motions", placed["real"], placed[name], names, kind)
        key = f'<span class="key s{kind}"></span>'
        figures.append(f"<figure><figcaption>{key}{text(name)}</figcaption>{chart}</figure>")
    return f'<div><h3>{text(title)}</h3><div class="maps">{"".join(figures)}</div></div>'


def _most_confused(shares: np.ndarray, bench: ActionBench) -> str:
    wrong = shares.copy()
    wrong[np.arange(len(bench.actions)), bench.answers] = 0.0
    order = np.argsort(-wrong, axis=None, kind="stable")[:_WORST]
    pairs = [divmod(int(i), wrong.shape[1]) for i in order]
    found = [
        f"{bench.actions[i]} taken for {bench.recogniser.labels[j]} ({100 * wrong[i, j]:.0f} %)"
        for i, j in pairs
        if wrong[i, j] > 0
    ]
    return ", ".join(found) or "nothing was confused"


def _heading(name: str) -> str:
    metric = METRICS[name]
    unit = f"<br>{text(metric.unit)}" if metric.unit else ""
    return f"{text(metric.title)}&nbsp;{metric.arrow}{unit}"


def _cell(estimate: Estimate | None, best: bool) -> str:
    mean, mark, half = tables.cell(estimate).partition(" ± ")
    spread = f" <small>± {half}</small>" if mark else ""
    return f'<td class="best">{mean}{spread}</td>' if best else f"<td>{mean}{spread}</td>"
