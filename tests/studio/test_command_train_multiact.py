"""`motionloom train multiact` on clips made by formula."""

from __future__ import annotations

import pytest

import engines
from engines import datasets
from engines.multiact import config
from tests.engines.action2motion.tiny import movement
from tests.engines.multiact.tiny import SIZES, clips

QUICK = ("--set", "log_every=1", "--steps", "2")


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    monkeypatch.setitem(config.PRESETS, "small", config.SMALL.replaced(**SIZES))
    monkeypatch.setattr(datasets, "load", lambda split=None, *_: clips() if split != "val" else clips(1))
    monkeypatch.setattr(datasets, "cache_folder", lambda: tmp_path / "cache")


def test_a_run_then_an_engine_and_triplets_are_made_once(run, tmp_path):
    weights, folder = tmp_path / "out" / "m.safetensors", str(tmp_path / "run")
    code, out, err = run("train", "multiact", "--run", folder, *QUICK, "--export", str(weights))
    assert code == 0, err
    assert "2 steps" in out
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").glob("triplets-*.npz")}
    assert len(kept) == 2
    # gone on with, a run remembers its settings
    code, out, err = run("train", "multiact", "--run", folder, "--resume", "--steps", "3", "--export", str(weights))
    assert code == 0, err
    assert "3 steps" in out
    assert kept == {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").glob("triplets-*.npz")}
    engine = engines.load("multiact", checkpoint=weights)
    made = engine.continue_from(movement(30), "throw", 1.0)
    assert len(made) == 50 and made.labels[-1].value == "throw"
    # triplets of other settings take their place
    assert run("train", "multiact", "--run", str(tmp_path / "other"), "--set", "pairs=20", *QUICK)[0] == 0
    assert len(new := set((tmp_path / "cache").glob("triplets-*.npz"))) == 2 and new - set(kept)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--preset", "smal"], "did you mean 'small'"),
        (["--set", "width=30"], "multiple of 4"),
        (["--set", "kl_wieght=1"], "kl_weight"),
        (["--export", "m.pth"], "ending in .safetensors"),
    ],
)
def test_mistakes_are_one_line(run, tmp_path, arguments, says):
    code, _, err = run("train", "multiact", "--run", str(tmp_path / "run"), *arguments)
    assert code == 1
    assert says in err
    assert err.count("\n") == 1
