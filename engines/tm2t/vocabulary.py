"""Motion tokens with their boundary marks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from torch import Tensor

from engines.text.words import padded

FRAMES_A_TOKEN = 4
"""Two convolutions of stride 2 (thesis 6.2.1)."""


@dataclass(frozen=True)
class MotionTokens:
    """Codes 0 ... K - 1, then [BOM], [EOM] and padding."""

    codes: int
    """K."""

    @property
    def begin(self) -> int:
        """[BOM]."""
        return self.codes

    @property
    def end(self) -> int:
        """[EOM]."""
        return self.codes + 1

    @property
    def pad(self) -> int:
        """Past the end."""
        return self.codes + 2

    @property
    def size(self) -> int:
        """How many there are."""
        return self.codes + 3

    def rows(self, sequences: Sequence[np.ndarray]) -> Tensor:
        """Codes of many motions -> (B, L) each between its marks, padded."""
        return padded(sequences, self.begin, self.end, self.pad)
