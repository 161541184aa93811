"""The page about engines that make sequences of actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from engines.evaluation import Results, Row, SequenceBench
from studio.report import sections
from studio.report.content import Content, Part, cast

_EXAMPLES = 3
"""Sequences shown as players."""
_SHOWN = 6
"""Actions of each."""


def content(
    bench: SequenceBench, engines: Mapping[str, Any], results: Results, rows: Sequence[Row], facts: Mapping[str, str]
) -> Content:
    """What the page holds; the engines make the motions it shows."""
    made = {name: bench.sample(engine, _EXAMPLES) for name, engine in engines.items()}
    asked = [blocks[:_SHOWN] for blocks, _ in bench.asked(0)[:_EXAMPLES]]
    frames = _SHOWN * bench.options.frames
    intro = (
        f"The first {_SHOWN} actions of the first sequences of the first repeat, not chosen; beside them a real "
        "transition."
    )
    parts = [
        Part("figures", "Figures", "Figures", sections.figures(results, rows, bench.left_out)),
        Part("published", "The papers’ figures", "Published", sections.published_figures(results)),
        Part("examples", "Examples", "Examples",
             sections.example_buttons([" › ".join(name for name, _ in blocks) for blocks in asked], intro)),
        Part("again", "To make this again", "Again", sections.again(rows, results, facts)),
    ]  # fmt: skip
    return Content(
        title=f"Evaluation of {', '.join(engines)}",
        summary=f"MultiAct’s protocol: {bench.sequences:,} sequences a repeat, {bench.options.data} real clips.",
        parts=parts,
        casts=[
            cast(bench.real[i].motion.face_front(), {name: [whole[i][:frames]] for name, whole in made.items()})
            for i in range(len(asked))
        ],
    )
