"""Networks trained on real motion that judge generated motion.

Recognisers of actions, contents and styles (`load`), and the space that motions share with sentences
(`co_embedding.load`).
"""

from __future__ import annotations

from engines.metrics.evaluators.co_embedding import CoEmbedding
from engines.metrics.evaluators.recogniser import Recogniser, load

__all__ = ["CoEmbedding", "Recogniser", "load"]
