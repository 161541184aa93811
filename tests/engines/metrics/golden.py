"""Reference numbers of the metrics: files found by pattern, and a loud skip where there are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.engines.action2motion.golden import cases

__all__ = ["arrays", "cases", "weights"]


def arrays(file: Path) -> dict[str, np.ndarray]:
    """All arrays of a file by name."""
    with np.load(file) as stored:
        return dict(stored)


def weights(file: Path, ending: str) -> Path:
    """The weights `<set>_<ending>` beside `<set>_....npz`; another set's where this one was run with those."""
    own = file.with_name(f"{file.name.split('_')[0]}_{ending}")
    return own if own.is_file() else next(file.parent.glob(f"*_{ending}"))
