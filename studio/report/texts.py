"""The page about engines that take sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from engines.evaluation import Results, Row, TextBench
from studio.report import sections
from studio.report.content import Content, Part, cast

_ON_THE_MAP = 150
"""Motions of each row that are points of the map."""
_EXAMPLES = 6
"""Sentences shown as players."""


def content(
    bench: TextBench, engines: Mapping[str, Any], results: Results, rows: Sequence[Row], facts: Mapping[str, str]
) -> Content:
    """What the page holds; the engines make the motions it shows."""
    prompts = bench.prompts(0)[:_ON_THE_MAP]
    sentences = [prompt.sentence for prompt in prompts]
    made = {name: bench.sample(engine, len(prompts)) for name, engine in engines.items()}
    features = {"real": bench.real[[prompt.clip for prompt in prompts]]}
    features |= {name: bench.judge.motions(motions) for name, motions in made.items()}
    looked = (
        f"Where {len(prompts):,} motions of each row lie in the space that they share with sentences. Grey: the real "
        "motions of these sentences; coloured: generated. Generated motions should lie where real ones do."
    )
    intro = "The first sentences of the first repeat, not chosen; beside the real motion they were drawn for."
    parts = [
        Part("figures", "Figures", "Figures", sections.figures(results, rows, bench.left_out)),
        Part("published", "The papers’ figures", "Published", sections.published_figures(results)),
        Part("examples", "Examples", "Examples", sections.example_buttons(sentences[:_EXAMPLES], intro)),
        Part("map", "Feature map", "Feature map", sections.maps(features, sentences, looked, bench.options.seed)),
        Part("again", "To make this again", "Again", sections.again(rows, results, facts)),
    ]
    casts = [
        cast(bench.clips[prompt.clip].motion.face_front(), {name: [motions[i]] for name, motions in made.items()})
        for i, prompt in enumerate(prompts[:_EXAMPLES])
    ]
    return Content(
        title=f"Evaluation of {', '.join(engines)}",
        summary=f"Text2Motion’s protocol: {bench.count:,} sentences a repeat, {bench.options.data} real clips.",
        parts=parts,
        casts=casts,
    )
