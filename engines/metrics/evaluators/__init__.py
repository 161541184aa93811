"""Networks trained on real motion that judge generated motion: recognisers of actions, contents and styles."""

from __future__ import annotations

from engines.metrics.evaluators.recogniser import Recogniser, load

__all__ = ["Recogniser", "load"]
