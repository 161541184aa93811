"""`motionloom data` and `motionloom train` on a few clips in a cache of their own."""

from __future__ import annotations

import json
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import engines
from engines import datasets
from engines.action2motion import config, train
from engines.datasets.prepare import VERSION
from engines.formats import bvh
from engines.metrics.evaluators import co_embedding, recogniser
from tests.engines.action2motion.tiny import movement
from tests.studio.fakes import sway


@pytest.fixture
def source(tmp_path) -> Path:
    """Three clips by Bandai-Namco's names, one of them broken."""
    folder = tmp_path / "source" / "dataset" / "data"
    folder.mkdir(parents=True)
    for index, name in enumerate(("walk_normal_001", "walk_normal_002", "kick_normal_001")):
        bvh.write(sway(frames=30 + 10 * index, seed=index), folder / f"dataset-2_{name}.bvh")
    (folder / "dataset-2_run_normal_001.bvh").write_text("no motion\n")
    return tmp_path / "source"


@pytest.fixture
def small(monkeypatch) -> None:
    """The preset `small`, smaller."""
    sizes = {"embed_size": 8, "generator_size": 8, "latent_size": 4, "movement_size": 4, "batch_size": 4, "window": 6}
    monkeypatch.setitem(config.PRESETS, "small", config.SMALL.replaced(**sizes))


@pytest.fixture
def clips(monkeypatch) -> None:
    """Prepared clips without preparing any."""
    made = [
        datasets.Clip("formula", f"{action}-{i}", action, None, None, None, "train", movement(24, i))
        for i, action in enumerate(("walk", "walk", "throw", "turn left"))
    ]
    monkeypatch.setattr(datasets, "load", lambda split=None, *_: made if split != "val" else [])


def test_prepare_then_list(run, source):
    code, out, err = run("data", "prepare", "--source", str(source), "--workers", "1")
    assert code == 0
    assert Path(out.strip()) == datasets.cache_folder() / f"house-v{VERSION}.npz"
    assert Path(out.strip()).is_file()
    assert "1 clips were left out" in err
    assert "bandai-namco/dataset-2_run_normal_001: " in err
    code, out, err = run("data", "list")
    assert (code, err) == (0, "")
    rows = {line.split("  ")[0]: line.split() for line in out.splitlines() if line}
    assert rows["bandai-namco"][1:] == ["3", "0.1", "CC", "BY-NC", "4.0"]
    assert rows["cmu"][1] == "missing"
    assert rows["in all"][2:4] == ["3", "0.1"]
    assert rows["walk"][1] == "2"
    assert rows["kick"][1] == "1"
    assert "run" not in rows
    names = {clip.name for clip in datasets.load()}
    assert names == {"dataset-2_walk_normal_001", "dataset-2_walk_normal_002", "dataset-2_kick_normal_001"}


def test_list_without_a_cache_says_what_to_do(run):
    code, out, err = run("data", "list")
    assert code == 0
    assert out.count("missing") == len(datasets.CORPORA)
    assert "motionloom data prepare --source" in err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["data", "prepare", "--source", "nowhere"], "holds none of"),
        (["data", "prepare", "--source", ".", "--corpora", "cmo"], "did you mean 'cmu'"),
        (["data", "prepare", "--source", ".", "--workers", "0"], "--workers is 0"),
        (["train", "action2motion", "--run", "r", "--decoder", "glmi"], "did you mean 'glmi-m'"),
        (["train", "action2motion", "--run", "r", "--preset", "papers"], "did you mean 'paper'"),
        (["train", "action2motion", "--run", "r", "--steps", "0"], "--steps is 0"),
        (["train", "action2motion", "--run", "r", "--threads", "0"], "--threads is 0"),
        (
            ["train", "action2motion", "--run", "r", "--data", "cmu,utd"],
            "unknown corpus 'utd'; did you mean 'utd-mhad'",
        ),
        (["train", "action2motion", "--run", "r", "--data", ","], "names of corpora"),
        (["train", "action2motion", "--run", "r", "--set", "learning_rat=1"], "did you mean 'learning_rate'"),
        (["train", "action2motion", "--run", "r", "--set", "steps=1.5"], "steps is '1.5'; accepted: a whole number"),
        (["train", "action2motion", "--run", "r", "--set", "seed=1"], "the option --seed 1"),
        (
            ["train", "action2motion", "--run", "r", "--set", "decoder=gru"],
            "accepted: plain or lie or glmi-m or glmi-r",
        ),
        (["train", "action2motion", "--run", "r", "--weights", "first"], "unknown weights 'first'"),
        (["train", "action2motion", "--run", "r", "--export", "a.pt"], "a file ending in .safetensors"),
        (["train", "action2motion", "--run", "r"], "motionloom data prepare"),
    ],
)
def test_a_persons_mistake_is_one_line_and_code_1(run, arguments, says):
    code, out, err = run(*arguments)
    assert (code, out) == (1, "")
    assert err.startswith("error: ")
    assert says in err
    assert err.count("\n") == 1


def test_a_source_of_broken_clips_keeps_the_old_cache(run, source):
    assert run("data", "prepare", "--source", str(source), "--workers", "1")[0] == 0
    before = (datasets.cache_folder() / f"house-v{VERSION}.npz").read_bytes()
    for path in (source / "dataset" / "data").glob("*.bvh"):
        path.write_text("no motion\n")
    code, _, err = run("data", "prepare", "--source", str(source), "--workers", "1")
    assert code == 1
    assert "not one of 4 clips could be read" in err
    assert (datasets.cache_folder() / f"house-v{VERSION}.npz").read_bytes() == before


@pytest.mark.parametrize("arguments", [["data"], ["train"], ["data", "prepare"], ["train", "action2motion"]])
def test_help_has_examples_and_wrong_usage_is_code_2(run, arguments):
    code, out, _ = run(*arguments, "--help")
    assert code == 0
    assert "Examples" in out
    assert "motionloom " + arguments[0] in out
    code, out, err = run(*arguments)
    assert code == 2
    assert out + err


def test_train_export_generate(run, small, clips, tmp_path):
    code, out, err = run("train", "action2motion", "--run", "run", "--steps", "3", "--export", "out/mine.safetensors")
    assert (code, err) == (0, "")
    assert out.startswith("run: 3 steps")
    engine = engines.load("action2motion", checkpoint=tmp_path / "out" / "mine.safetensors")
    assert f"sha256 {engine.weights_hash}" in out
    assert [action.name for action in engine.actions] == ["walk", "turn left", "turn right", "throw"]
    assert len(engine.generate("throw", frames=12)) == 12
    assert json.loads((tmp_path / "run" / "config.json").read_text())["steps"] == 3


def test_ctrl_c_saves_and_the_same_command_goes_on(run, small, clips, tmp_path, monkeypatch):
    """Stopped after two steps and resumed, the weights are those of a training that was not stopped."""
    command = ("train", "action2motion", "--steps", "5", "--decoder", "lie")
    whole = run(*command, "--run", "whole", "--export", "whole.safetensors")
    losses, calls = train.losses, []

    def interrupted(*given):
        calls.append(1)
        if len(calls) == 2:
            signal.raise_signal(signal.SIGINT)
        return losses(*given)

    monkeypatch.setattr(train, "losses", interrupted)
    before = signal.getsignal(signal.SIGINT)
    code, _, err = run(*command, "--run", "parts", "--export", "parts.safetensors")
    assert (code, err) == (130, "cancelled: training was cancelled after step 2\n")
    assert signal.getsignal(signal.SIGINT) is before
    assert (tmp_path / "parts" / "checkpoint.pt").is_file()
    assert not (tmp_path / "parts.safetensors").exists()
    code, out, _ = run(*command, "--run", "parts", "--export", "parts.safetensors")
    assert code == 0
    assert len(calls) == 5
    assert out.splitlines()[-1] == whole[1].splitlines()[-1], "the same SHA-256"
    assert not [path for path in (tmp_path / "parts").iterdir() if path.name.startswith(".")], "nothing half-written"


def test_a_checkpoint_that_does_not_fit_is_refused(run, small, clips, tmp_path):
    assert run("train", "action2motion", "--run", "run", "--steps", "1")[0] == 0
    code, _, err = run("train", "action2motion", "--run", "run", "--steps", "2", "--decoder", "lie")
    assert code == 1
    assert "cannot resume" in err
    assert json.loads((tmp_path / "run" / "config.json").read_text())["decoder"] == "glmi-m"
    (tmp_path / "run" / "checkpoint.pt").write_bytes(b"not a checkpoint")
    code, _, err = run("train", "action2motion", "--run", "run", "--steps", "2")
    assert code == 1
    assert "checkpoint.pt: cannot resume" in err


def test_settings_are_remembered_where_a_run_goes_on(run, small, clips, tmp_path):
    command = ("train", "action2motion", "--run", "run")
    first = ("--decoder", "lie", "--set", "kl_weight=0.5,0.5", "--set", "log_every=1", "--steps", "2")
    assert run(*command, *first)[0] == 0
    assert run(*command, "--steps", "3", "--resume")[1].startswith("run: 3 steps")
    kept = json.loads((tmp_path / "run" / "config.json").read_text())
    assert (kept["decoder"], kept["kl_weight"], kept["steps"]) == ("lie", [0.5, 0.5], 3)
    about = json.loads((tmp_path / "run" / "training.json").read_text())
    assert (about["plan"]["log_every"], about["plan"]["steps"], about["resumed_at"]) == (1, 3, 2)
    assert [line["step"] for line in json.loads((tmp_path / "run" / "history.json").read_text())] == [1, 2, 3]
    assert run(*command, "--steps", "1", "--fresh")[1].startswith("run: 1 steps")
    assert json.loads((tmp_path / "run" / "config.json").read_text())["decoder"] == "glmi-m", "nothing is remembered"
    code, _, err = run("train", "action2motion", "--run", "new", "--resume")
    assert (code, "no checkpoint to go on from" in err) == (1, True)
    (tmp_path / "run" / "training.json").write_text("{")
    code, _, err = run(*command)
    assert (code, "training.json: cannot be read" in err) == (1, True)


def test_corpora_are_chosen_and_remembered(run, small, clips, monkeypatch, tmp_path):
    asked, load = [], datasets.load

    def watched(split=None, corpora=None, *_):
        asked.append((split, corpora))
        return load(split)

    monkeypatch.setattr(datasets, "load", watched)
    command = ("train", "action2motion", "--run", "run", "--steps")
    assert run(*command, "1", "--data", "cmu, utd-mhad")[0] == 0
    assert run(*command, "2")[0] == 0
    assert asked == [("train", ["cmu", "utd-mhad"]), ("val", ["cmu", "utd-mhad"])] * 2


def test_threads_and_seed_are_passed_on(run, monkeypatch, tmp_path):
    told = {}

    def fit(settings, folder, **options):
        told.update(settings=settings, folder=folder, **options)
        plan = type("Plan", (), {"steps": 7})
        return type("State", (), {"step": 7, "seconds": 60.0, "plan": plan})()

    monkeypatch.setattr(train, "fit", fit)
    monkeypatch.setattr("torch.set_num_threads", lambda n: told.update(threads=n))
    options = ("--preset", "paper", "--decoder", "glmi-r", "--threads", "2", "--seed", "5")
    assert run("train", "action2motion", "--run", "r", *options) == (0, "r: 7 steps, 1.0 minutes\n", "")
    assert told["settings"] == replace(config.PAPER, decoder="glmi-r")
    assert (told["folder"], told["seed"], told["threads"]) == (Path("r"), 5, 2)
    assert told["cancel"]() is False
    assert np.isfinite(told["settings"].learning_rate)


def test_a_recogniser_is_trained_and_exported(run, clips, tmp_path):
    code, out, err = run(
        "train", "evaluator", "--task", "action", "--run", "r", "--steps", "2", "--export", "mine.safetensors"
    )
    assert code == 0, err
    assert "val: no clip with such a label" in out
    assert "test: formula " in out
    assert recogniser.load("action", tmp_path / "mine.safetensors").config.extra == {"step": 2}
    code, _, err = run("train", "evaluator", "--task", "actoin", "--run", "r")
    assert code != 0
    assert "did you mean 'action'" in err


def test_a_space_of_motions_and_sentences_is_trained_and_exported(run, clips, tmp_path):
    line = ("train", "evaluator", "--task", "text", "--run", "r", "--steps", "2", "--export", "mine.safetensors")
    code, out, err = run(*line)
    assert code == 0, err
    assert "test: 4 clips, too few to measure on (32 needed)" in out
    found = co_embedding.load(tmp_path / "mine.safetensors")
    assert found.config.extra == {"step": 2, "prepared_data": VERSION}
    assert (tmp_path / "r" / "checkpoint.pt").is_file()
    assert list(datasets.cache_folder().glob("captions-minilm-*.npz"))
