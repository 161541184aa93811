"""Comparing pictures with small references."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from PIL import Image

REFERENCES = Path(__file__).resolve().parent / "references"
MEAN, OFTEN, STRONG = 2.0, 0.02, 40
"""A picture passes if it differs by less than MEAN on average (of 255), and by more than STRONG in fewer than the
share OFTEN of its pixels: drivers round edges differently."""
RENEW = "MOTIONLOOM_NEW_REFERENCES"


def same_picture(picture: np.ndarray, name: str, folder: Path) -> None:
    """Assert that a picture looks like its reference; otherwise save both and their difference in `folder`.

    Set MOTIONLOOM_NEW_REFERENCES=1 to write references anew, and look at them before committing.
    """
    path = REFERENCES / f"{name}.png"
    if os.environ.get(RENEW):
        path.parent.mkdir(exist_ok=True)
        Image.fromarray(picture).save(path, optimize=True)
    assert path.exists(), f"no reference {path}; set {RENEW}=1 once to make it"
    wanted = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert picture.shape == wanted.shape, f"{name} has shape {picture.shape}, the reference {wanted.shape}"
    apart = np.abs(picture.astype(int) - wanted)
    mean, often = apart.mean(), (apart.max(-1) > STRONG).mean()
    if mean < MEAN and often < OFTEN:
        return
    seen = folder / f"{name}-difference.png"
    shown = np.concatenate([wanted, picture.astype(int), np.minimum(4 * apart, 255)], axis=1).astype(np.uint8)
    Image.fromarray(shown).save(seen)
    raise AssertionError(
        f"{name} differs from its reference by {mean:.2f} on average, strongly in {often:.1%} of its pixels; "
        f"reference, picture and difference are in {seen}"
    )
