"""Fixtures shared by all tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def find_shared() -> Path | None:
    """The folder of real data and reference numbers: $MOTIONLOOM_SHARED, or `../shared` beside the checkout."""
    folder = Path(os.environ.get("MOTIONLOOM_SHARED", ROOT.parent / "shared"))
    return folder if folder.is_dir() else None


@pytest.fixture(scope="session")
def shared_dir() -> Path:
    folder = find_shared()
    if folder is None:
        pytest.skip("no shared folder: put it beside the checkout or set MOTIONLOOM_SHARED")
    return folder
