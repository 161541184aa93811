"""The files of a report: `table.md`, `table.csv`, `table.json`, and the page `index.html`."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from engines.evaluation import ActionBench, Results, Row, SequenceBench, StyleBench, TextBench, tables
from engines.formats.files import atomic_path
from studio.report import actions, sections, sequences, styles, texts
from studio.report.content import Content
from viewers.web.payload import Actor

_PAGE = Path(__file__).with_name("page.html")


def write_tables(folder: Path, results: Results, rows: Sequence[Row], left_out: Mapping[str, tuple[str, ...]]) -> None:
    """The table in three formats."""
    _write(folder / "table.md", tables.markdown(results, rows, left_out))
    _write(folder / "table.csv", tables.comma_separated(results, rows))
    values = tables.as_json(results, rows, left_out)
    _write(folder / "table.json", json.dumps(values, indent=1, ensure_ascii=False))


def write_report(  # noqa: PLR0913, PLR0917 - what a report tells of
    folder: Path,
    bench: ActionBench | SequenceBench | StyleBench | TextBench,
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
    path = folder / "index.html"
    if isinstance(bench, TextBench):
        content = texts.content(bench, engines, results, rows, facts)
    elif isinstance(bench, SequenceBench):
        content = sequences.content(bench, engines, results, rows, facts)
    elif isinstance(bench, StyleBench):
        content = styles.content(bench, engines, results, rows, facts)
    else:
        content = actions.content(bench, engines, results, rows, facts)
    _write(path, page(content))
    return path


def page(content: Content) -> str:
    """The HTML text: everything inside, nothing fetched."""
    from viewers.web.controls import BUNDLE

    parts = {
        "title": sections.text(content.title),
        "summary": sections.text(content.summary),
        "nav": "".join(f'<a href="#{part.key}">{part.short}</a>' for part in content.parts),
        "main": "\n".join(
            f'<section id="{part.key}"><h2>{part.heading}</h2>{part.html}</section>' for part in content.parts
        ),
        "values": _player_values(content.casts),
        "bundle": base64.b64encode(BUNDLE.read_bytes()).decode(),
    }
    html = _PAGE.read_text(encoding="utf-8")
    for name, value in parts.items():
        html = html.replace(f"[[{name}]]", value)
    return html


def _player_values(casts: Sequence[Sequence[Actor]]) -> str:
    """Body, options, and one payload for each cast."""
    from viewers import bodies
    from viewers.web.controls import actors_of, encode
    from viewers.web.payload import MAX_ACTORS

    body, takes = b"", []
    for each in casts:
        body, data = encode(actors_of(each[:MAX_ACTORS]), bodies.DEFAULT)
        takes.append(base64.b64encode(data).decode())
    options = {"theme": "auto", "playing": True, "camera": "front"}
    values = {"options": options, "body_data": base64.b64encode(body).decode(), "takes": takes}
    return json.dumps(values).replace("<", "\\u003c")


def _write(path: Path, text: str) -> None:
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
