"""`motionloom train text2motion`, all stages at once and stage after stage, on clips made by formula."""

from __future__ import annotations

import pytest

from engines import datasets
from engines.text2motion import config, train
from tests.engines.action2motion.tiny import clips
from tests.engines.text2motion.tiny import SIZES, material


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(config.PRESETS, "small", config.SMALL.replaced(**SIZES))
    monkeypatch.setattr(datasets, "load", lambda split=None, *_: clips(1) if split != "val" else [])
    monkeypatch.setattr(train, "prepared", lambda _config, stage, *_: None if stage == "autoencoder" else material())


def test_all_stages_at_once(run, tmp_path):
    weights = tmp_path / "out" / "text2motion.safetensors"
    told = ("train", "text2motion", "--run", "runs", "--set", "log_every=1", "--set", "code_size=6")
    code, out, err = run(*told, "--steps", "2")
    assert code == 0, err
    assert "2 steps" in out
    # gone on with, a run remembers its settings
    (tmp_path / "runs" / "text2motion" / "checkpoint.pt").unlink()  # as if stopped before the last stage
    told = ("--run", "runs", "--steps", "2", "--resume", "--export", str(weights))
    code, out, err = run("train", "text2motion", *told)
    assert code == 0, err
    net = train.load(weights)
    assert (net.config.parts, net.config.code_size) == (config.STAGES, 6)
    assert sorted(path.name for path in (tmp_path / "runs").glob("*.safetensors")) == [
        f"{stage}.safetensors" for stage in config.STAGES
    ]


def test_three_stages_one_after_another(run, tmp_path):
    before: list[str] = []
    for stage in config.STAGES:
        folder, weights = str(tmp_path / stage), tmp_path / "out" / f"{stage}.safetensors"
        told = ("train", "text2motion", "--stage", stage, "--run", folder, "--set", "log_every=1", *before)
        code, out, err = run(*told, "--steps", "2")
        assert code == 0, err
        assert "2 steps" in out
        # gone on with, a run remembers its stage and where it came from
        code, out, err = run(
            "train", "text2motion", "--run", folder, "--resume", "--steps", "3", "--export", str(weights)
        )
        assert code == 0, err
        assert "3 steps" in out
        before = ["--from", str(weights)]
    assert train.load(weights).config.parts == config.STAGES
    ablated = tmp_path / "ablated.safetensors"
    told = (
        "--stage",
        "text2motion",
        "--run",
        "no",
        "--steps",
        "1",
        "--set",
        "attention=false",
        "--export",
        str(ablated),
    )
    code, _, err = run("train", "text2motion", *told, "--from", str(tmp_path / "out" / "text2length.safetensors"))
    assert code == 0, err
    assert not train.load(ablated).config.attention


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--stage", "autoencoders"], "did you mean 'autoencoder'"),
        (["--stage", "text2length"], "--from FILE"),
        (["--stage", "text2motion", "--from", "nowhere.safetensors"], "no such weights"),
        (["--from", "nowhere.safetensors"], "--from is"),
        (["--stage", "autoencoder", "--preset", "papers"], "did you mean 'paper'"),
        (["--stage", "autoencoder", "--set", "code_size=0"], "code_size is 0"),
        (["--stage", "autoencoder", "--set", "attention=maybe"], "attention is"),
        (["--stage", "autoencoder", "--export", "a.pt"], "a file ending in .safetensors"),
    ],
)
def test_mistakes_are_one_line(run, tmp_path, arguments, says):
    code, _, err = run("train", "text2motion", "--run", str(tmp_path / "run"), *arguments)
    assert code == 1
    assert says in err and err.count("\n") == 1


def test_the_paper_asks_for_its_word_vectors(run, tmp_path, monkeypatch):
    monkeypatch.undo()
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("MOTIONLOOM_GLOVE", raising=False)
    from engines import text

    text.load.cache_clear()
    with pytest.raises(Exception, match="MOTIONLOOM_GLOVE"):
        train.prepared(config.PAPER, "text2motion")
