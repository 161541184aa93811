"""`motionloom train stylization`, stage after stage, on clips made by formula."""

from __future__ import annotations

import pytest

import engines
from engines import datasets
from engines.stylization import config
from tests.engines.stylization.tiny import SIZES, clips

QUICK = ("--set", "log_every=1", "--steps", "2")


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(config.PRESETS, "small", config.SMALL.replaced(**SIZES))
    monkeypatch.setattr(datasets, "load", lambda split=None, *_: clips() if split != "val" else clips(1))


@pytest.mark.parametrize("told", [(), ("--latent", "vae", "--unsupervised")])
def test_three_stages_in_one_folder_then_an_engine(run, tmp_path, told):
    weights = tmp_path / "out" / "s.safetensors"
    for stage in ("autoencoder", "regressor", "style"):
        made = ("--export", str(weights)) if stage == "style" else ()
        code, out, err = run(
            "train", "stylization", "--stage", stage, "--run", str(tmp_path / "run"), *told, *QUICK, *made
        )
        assert code == 0, err
        assert "2 steps" in out
    # gone on with, a run remembers its settings
    again = ("--stage", "style", "--run", str(tmp_path / "run"), "--resume", "--steps", "3", "--export", str(weights))
    code, out, err = run("train", "stylization", *again)
    assert code == 0, err
    assert "3 steps" in out
    engine = engines.load("stylization", checkpoint=weights)
    assert engine.config.latent == ("vae" if told else "ae")
    assert engine.config.supervised == (not told)
    assert engine.config.cycle_weight == (1.0 if told else 0.1)
    assert len(engine.stylise(clips()[0].motion)) == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--stage", "styles"], "did you mean 'style'"),
        (["--stage", "style"], "train the stage 'autoencoder' first"),
        (["--stage", "autoencoder", "--export", "a.safetensors"], "none before the last stage"),
        (["--stage", "autoencoder", "--latent", "vea"], "did you mean 'vae'"),
        (["--stage", "autoencoder", "--set", "window=15"], "multiple of 4"),
    ],
)
def test_mistakes_are_one_line(run, tmp_path, arguments, says):
    code, _, err = run("train", "stylization", "--run", str(tmp_path / "run"), *arguments)
    assert code == 1
    assert says in err
    assert err.count("\n") == 1
