"""`motionloom train loom`, on clips made by formula."""

from __future__ import annotations

import pytest

from engines import datasets
from engines.loom import config
from tests.engines.action2motion.tiny import clips
from tests.engines.loom.tiny import SIZES


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(config.PRESETS, "small", config.SMALL.replaced(**SIZES))
    monkeypatch.setattr(datasets, "load", lambda split=None, *_: clips(1) if split != "val" else [])


def test_trains_goes_on_and_writes_weights(run, tmp_path):
    folder, weights = str(tmp_path / "run"), tmp_path / "out" / "loom.safetensors"
    told = ("train", "loom", "--run", folder, "--no-words", "--set", "log_every=1")
    code, out, err = run(*told, "--steps", "2")
    assert code == 0, err
    assert "2 steps" in out
    code, out, err = run(*told, "--steps", "3", "--resume", "--export", str(weights))
    assert code == 0, err
    assert "3 steps" in out and weights.is_file() and weights.with_suffix(".json").is_file()
    code, out, err = run("train", "loom", "--run", folder, "--no-words", "--set", "patch=4")
    assert code == 1
    assert "patch was 8 and is now 4" in err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--preset", "paper"], "did you mean 'large'"),
        (["--set", "width=33"], "a multiple of 4"),
        (["--set", "wordy=0.8", "--set", "both=0.5"], "0 to 1"),
        (["--export", "a.pt"], "a file ending in .safetensors"),
    ],
)
def test_mistakes_are_one_line(run, tmp_path, arguments, says):
    code, _, err = run("train", "loom", "--run", str(tmp_path / "run"), "--no-words", *arguments)
    assert code == 1
    assert says in err and err.count("\n") == 1
