"""The guide does what it says: its steps, in its order, in one page."""

from __future__ import annotations

import re

import pytest

from scripts.guide_pictures import LARGEST, SIZE, STEPS
from tests.ui.conftest import ROOT, Tab

GUIDE = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8")


def test_the_guide_tells_of_every_step_and_shows_it():
    assert re.findall(r"^## (.+)$", GUIDE, re.MULTILINE) == [step.title for step in STEPS]
    shown = re.findall(r"!\[[^\]]+\]\((guide/[\w.]+)\)", GUIDE)
    assert shown == [f"guide/{step.name}.webp" for step in STEPS]
    for picture in shown:
        data = (ROOT / "docs" / picture).read_bytes()
        assert data[:4] == b"RIFF"
        assert len(data) <= LARGEST


@pytest.mark.timeout(400)
def test_the_steps_of_the_guide_can_be_gone(chromium, address):
    width, height = SIZE
    context = chromium.new_context(
        viewport={"width": width, "height": height}, reduced_motion="reduce", accept_downloads=True
    )
    tab = Tab(context.new_page(), address).open()
    for step in STEPS:
        if step.there():
            step.act(tab)
    assert tab.faults == []
    assert tab.foreign == []
    context.close()
