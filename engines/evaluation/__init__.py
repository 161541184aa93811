"""Engines judged by the protocols of the papers: who is asked for what, how often, and against which real motions."""

from __future__ import annotations

from engines.evaluation.actions import ActionBench, Options, evaluate
from engines.evaluation.results import Repeat, Results, Row

__all__ = ["ActionBench", "Options", "Repeat", "Results", "Row", "evaluate"]
