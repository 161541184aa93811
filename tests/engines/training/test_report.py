"""What a training leaves for people: the table, the page, and a page that a browser can draw."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from torch import nn

from engines.training import files
from engines.training.plan import TrainingPlan
from engines.training.report import page, table, write_reports
from engines.training.state import TrainingState

if TYPE_CHECKING:
    from playwright.sync_api import Browser

PLAN = TrainingPlan(steps=4000, learning_rate=1e-3, final_learning_rate=1e-4)
TERMS = {"reconstruction": 6.0, "kl": 0.4, "foot_contact": 0.02}


def trained(lines: int = 30, finished: bool = False) -> TrainingState:
    """A state as after `lines` logged lines of falling losses, a validation every five of them."""
    state = TrainingState(nn.Linear(3, 2), PLAN)
    rng = np.random.default_rng(0)
    for i in range(1, lines + 1):
        state.step, state.seconds = 100 * i, 12.0 * i
        terms = {name: size * (0.2 + math.exp(-i / 9)) * rng.uniform(0.9, 1.1) for name, size in TERMS.items()}
        facts = {"learning_rate": PLAN.rate(state.step), "gradient_norm": rng.uniform(0.5, 2)}
        state.history.append({"step": state.step, "seconds": state.seconds, **facts, **terms})
        if i % 5 == 0:
            state.judge({name: 1.2 * value for name, value in terms.items()})
    if finished:
        state.step = PLAN.steps
    return state


def data_of(text: str) -> dict:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found[1])


def test_the_table_has_a_row_a_line_and_a_column_a_term() -> None:
    state = trained(10)
    rows = list(csv.DictReader(table(state).splitlines()))
    assert [row["step"] for row in rows if row["split"] == "val"] == ["500", "1000"]
    assert [row["step"] for row in rows] == sorted((row["step"] for row in rows), key=int)
    first = rows[0]
    assert float(first["total"]) == pytest.approx(sum(float(first[name]) for name in TERMS))
    assert float(first["learning_rate"]) == PLAN.rate(100)
    assert next(row for row in rows if row["split"] == "val")["learning_rate"] == ""


def test_the_page_needs_nothing_else_and_holds_the_numbers() -> None:
    state = trained()
    text = page(state, "a </script> & b")
    assert not re.search(r"(src|href)\s*=|@import|url\((?!#)", text), "nothing is fetched"
    data = data_of(text)
    assert data["title"] == "a </script> & b"
    assert "<title>a &lt;/script> &amp; b: losses</title>" in text
    assert data["train"]["kl"][-1] == [3000, pytest.approx(state.history[-1]["kl"], rel=1e-5)]
    assert data["validation"]["total"][-1][1] == pytest.approx(state.validation[-1]["total"], rel=1e-5)
    assert data["best"] == {"step": state.best_step, "total": state.best_total}
    assert (data["step"], data["steps"], data["finished"], data["early"]) == (3000, 4000, False, False)
    assert data_of(page(TrainingState(nn.Linear(1, 1), PLAN), "new"))["best"] is None


def test_a_long_training_is_thinned_out_on_the_page_but_not_in_the_table() -> None:
    state = trained(4000)
    points = data_of(page(state, "long"))["train"]["kl"]
    assert 1000 < len(points) <= 1500
    assert points[-1][0] == 400_000
    assert table(state).count("\ntrain,") == 4000


def test_a_log_that_cannot_be_written_is_a_warning(tmp_path: Path, monkeypatch, caplog) -> None:
    write_reports(trained(5), tmp_path, "run")
    names = ["history.json", "losses.csv", "losses.html", "validation.json"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    before = [path.read_bytes() for path in sorted(tmp_path.iterdir())]

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.Path, "open", full)
    write_reports(trained(6), tmp_path, "run")
    monkeypatch.undo()
    assert "history.json: cannot be written: no space left on device" in caplog.text
    assert [path.read_bytes() for path in sorted(tmp_path.iterdir())] == before


@pytest.mark.ui
def test_the_page_draws_a_line_a_term_and_remembers_what_was_chosen(tmp_path: Path, chromium: Browser) -> None:
    write_reports(trained(), tmp_path, "run 1")
    tab = chromium.new_page(viewport={"width": 1100, "height": 900})
    faults: list[str] = []
    tab.on("pageerror", lambda error: faults.append(str(error)))
    tab.goto((tmp_path / "losses.html").as_uri())
    assert tab.title() == "run 1: losses"
    curves = tab.locator("#losses path.curve")
    assert curves.count() == 2 * (1 + len(TERMS)), "trained on and held back, with their total"
    assert tab.locator("#losses path.val").count() == 1 + len(TERMS)
    assert "running" in tab.locator("#state").inner_text()
    assert "3,000 of 4,000" in tab.locator("dl").inner_text()
    assert "2 min" in tab.locator("dl").inner_text(), "six minutes for 3,000 steps, two for the thousand to go"
    log_path = curves.first.get_attribute("d")
    tab.get_by_role("button", name="linear").click()
    assert curves.first.get_attribute("d") != log_path
    tab.get_by_role("button", name="kl").click()
    assert curves.count() == 2 * len(TERMS)
    tab.locator("#losses svg").hover(position={"x": 500, "y": 200})
    tip = tab.locator("#losses .tip")
    assert tip.is_visible()
    assert "foot contact" in tip.inner_text()
    assert "kl" not in tip.inner_text()
    write_reports(trained(finished=True), tmp_path, "run 1")
    tab.reload()
    assert curves.count() == 2 * len(TERMS), "a reload keeps what was hidden"
    assert tab.get_by_role("button", name="linear").get_attribute("aria-pressed") == "true"
    assert tab.locator("#state").inner_text() == "finished"
    assert faults == []
    tab.close()
