"""Small numbers in words, the same wherever they stand."""

from __future__ import annotations


def duration(seconds: float) -> str:
    """Length of a motion: "3.0 s", "63 min 20 s"."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60} s"
