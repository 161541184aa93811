"""What the README shows works as it is written."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import engines

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_python_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert block
    monkeypatch.chdir(tmp_path)
    engines.load("action2motion").generate("walk", frames=60, seed=1).write("walk.bvh")
    scope: dict = {}
    exec(compile(block[1], "README.md", "exec"), scope)
    assert (tmp_path / "wave.bvh").stat().st_size > 1000
    assert (tmp_path / "wave.mp4").stat().st_size > 1000
    assert [len(motion) for motion in scope["ways_on"]] == [80] * 4
    assert len(scope["between"]) == 5


def test_every_command_exists() -> None:
    commands = sorted(set(re.findall(r"^motionloom (\w+)", README, re.MULTILINE)))
    assert len(commands) >= 5
    listed = subprocess.run(
        [sys.executable, "-m", "studio.cli", "--help"], capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout
    for command in commands:
        assert command in listed


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).exists(), f"README links to {target}, which is not there"


@pytest.mark.parametrize("target", ["studio", "test"])
def test_make_targets_exist(target: str) -> None:
    assert f"make {target}" in README
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
