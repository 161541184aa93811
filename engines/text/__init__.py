"""Words for networks: frozen encoders of sentences."""

from __future__ import annotations

from engines.text.encoder import EncodedText, TextEncoder, load

__all__ = ["EncodedText", "TextEncoder", "load"]
