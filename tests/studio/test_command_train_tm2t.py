"""`motionloom train tm2t`, stage after stage, on clips made by formula."""

from __future__ import annotations

import pytest

from engines import datasets
from engines.tm2t import config, train
from tests.engines.action2motion.tiny import clips
from tests.engines.tm2t.tiny import SIZES, material


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(config.PRESETS, "small", config.SMALL.replaced(**SIZES))
    monkeypatch.setattr(datasets, "load", lambda split=None, *_: clips(1) if split != "val" else [])
    monkeypatch.setattr(train, "prepared", lambda _config, stage, *_: None if stage == "vq" else material())


def test_three_stages_one_after_another(run, tmp_path):
    before: list[str] = []
    for stage in ("vq", "m2t", "t2m"):
        folder, weights = str(tmp_path / stage), tmp_path / "out" / f"{stage}.safetensors"
        told = ("train", "tm2t", "--stage", stage, "--run", folder, "--set", "log_every=1", *before)
        code, out, err = run(*told, "--steps", "2")
        assert code == 0, err
        assert "2 steps" in out
        # gone on with, a run remembers its stage and where it came from
        code, out, err = run("train", "tm2t", "--run", folder, "--resume", "--steps", "3", "--export", str(weights))
        assert code == 0, err
        assert "3 steps" in out
        before = ["--from", str(weights)]
    assert train.load(weights).config.parts == tuple(config.PARTS.values())


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "--stage is None"),
        (["--stage", "vqs"], "did you mean 'vq'"),
        (["--stage", "m2t"], "--from FILE"),
        (["--stage", "m2t", "--from", "nowhere.safetensors"], "no such weights"),
        (["--stage", "vq", "--preset", "papers"], "did you mean 'paper'"),
        (["--stage", "vq", "--set", "codes=0"], "codes is 0"),
        (["--stage", "vq", "--set", "codebook_update=mean"], "gradient or ema"),
        (["--stage", "vq", "--export", "a.pt"], "a file ending in .safetensors"),
    ],
)
def test_mistakes_are_one_line(run, tmp_path, arguments, says):
    code, _, err = run("train", "tm2t", "--run", str(tmp_path / "run"), *arguments)
    assert code == 1
    assert says in err and err.count("\n") == 1
