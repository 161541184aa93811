"""The pages of docs/ point at what is there, and show code that is run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*(ROOT / "docs").glob("*.md"), *ROOT.glob("*.md")])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    lost = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert lost == []


def test_slow_and_fast_code_is_what_the_benchmark_runs() -> None:
    shown = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    source = (ROOT / "benchmarks" / "habits.py").read_text(encoding="utf-8")
    run = {line.split("  # noqa")[0].strip() for line in source.splitlines()}
    pairs = re.findall(r"```python\n# (?:slow|fast): [\d.]+ m?s\n(.*?)```", shown, re.DOTALL)
    assert len(pairs) == 2 * source.count("    Habit(")
    assert [line for code in pairs for line in code.splitlines() if line.strip() not in run] == []


def test_features_name_tests_that_exist() -> None:
    page = (ROOT / "docs" / "features.md").read_text(encoding="utf-8")
    named = re.findall(r"`([\w/]+\.py)::(\w+)`", page)
    assert len(named) > 40
    assert [f"{file}::{test}" for file, test in named if f"def {test}(" not in _source(file)] == []
    rows = [line for line in page.splitlines() if line.startswith("| ✓")]
    assert [row for row in rows if "::test_" not in row] == []


def _source(file: str) -> str:
    path = ROOT / "tests" / file
    return path.read_text(encoding="utf-8") if path.is_file() else ""
