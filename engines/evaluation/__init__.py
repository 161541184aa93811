"""Engines judged by the protocols of the papers: who is asked for what, how often, and against which real motions."""

from __future__ import annotations

from engines.evaluation.actions import ActionBench, Options
from engines.evaluation.results import Repeat, Results, Row
from engines.evaluation.rounds import evaluate
from engines.evaluation.sequences import SequenceBench, SequenceOptions
from engines.evaluation.styles import StyleBench, StyleOptions
from engines.evaluation.texts import TextBench, TextOptions

__all__ = [
    "ActionBench", "Options", "Repeat", "Results", "Row", "SequenceBench", "SequenceOptions", "StyleBench",
    "StyleOptions", "TextBench", "TextOptions", "evaluate",
]  # fmt: skip
