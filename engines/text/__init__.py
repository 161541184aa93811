"""Words for networks: frozen encoders of sentences."""

from __future__ import annotations

from engines.text.encoder import EncodedText, TextEncoder, load, sentence_vector

__all__ = ["EncodedText", "TextEncoder", "load", "sentence_vector"]
