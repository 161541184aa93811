"""Fixtures shared by all tests."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

from tests import shape_check

if TYPE_CHECKING:
    from playwright.sync_api import Browser

shape_check.install()  # before any test imports what it is to check

settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")  # a busy machine is no fault

ROOT = Path(__file__).resolve().parent.parent

os.environ["MOTIONLOOM_CHARACTERS"] = str(ROOT / "tests" / "no characters")  # whatever this machine's person has kept

CHROMIUM_FLAGS = [
    "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
    "--disable-background-networking", "--disable-component-update", "--no-first-run", "--disable-sync",
]  # fmt: skip
"""Software WebGL, and nothing that asks the network by itself."""


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


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """The one browser of a test run; Playwright allows no second beside it."""
    sync_api = pytest.importorskip("playwright.sync_api")
    path = os.environ.get("MOTIONLOOM_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    if path is None:
        pytest.skip("no Chromium: install it or set MOTIONLOOM_CHROMIUM")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=CHROMIUM_FLAGS)
        yield browser
        browser.close()
