"""`motionloom train` in processes of its own: killed without warning and resumed, and two that share the work."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from engines import datasets
from engines.action2motion import config, train
from tests.conftest import ROOT
from tests.studio import trainee

PLAN = {"log_every": 4, "validate_every": 8, "warmup": 1}
SETS = ("--set", "log_every=4", "--set", "validate_every=8", "--set", "warmup=1")


@pytest.fixture
def made_up(monkeypatch) -> None:
    """The same clips here as there."""
    monkeypatch.setattr(datasets, "load", trainee.load)


def fit(folder: Path, steps: int, **changes):
    """What the command does, in this process."""
    settings = config.SMALL.replaced(**{**trainee.SIZES, "decoder": "lie", "steps": steps, **changes})
    return train.fit(settings, folder, plan=PLAN, device="cpu")


def command(folder: Path, steps: int, *more: str, pause: float = 0.0) -> list[str]:
    start = ["tests.studio.trainee", str(pause), str(torch.get_num_threads())]
    options = ["--run", str(folder), "--decoder", "lie", "--steps", str(steps), "--device", "cpu", *SETS, *more]
    return [*start, "train", "action2motion", *options]


def without_times(lines: list[dict[str, float]]) -> list[dict[str, float]]:
    return [{name: value for name, value in line.items() if name != "seconds"} for line in lines]


def test_killed_and_resumed_it_gives_the_same_losses(tmp_path: Path, made_up) -> None:
    """Checkpoints are written all the time, and the process is killed at no particular moment."""
    folder, steps = tmp_path / "killed", 40
    arguments = command(folder, steps, "--set", "save_every_seconds=0", pause=0.2)
    with subprocess.Popen([sys.executable, "-m", *arguments], cwd=ROOT, stderr=subprocess.PIPE) as process:
        until = time.monotonic() + 200
        while not (folder / "history.json").exists() and process.poll() is None and time.monotonic() < until:
            time.sleep(0.05)
        process.kill()
        said = process.communicate()[1].decode()
    assert process.returncode == -signal.SIGKILL, said
    cut = json.loads(torch.load(folder / "checkpoint.pt", weights_only=True)["rest"])["step"]
    assert 3 <= cut < steps
    resumed, whole = fit(folder, steps), fit(tmp_path / "whole", steps)
    assert without_times(resumed.history) == without_times(whole.history)
    assert without_times(resumed.validation) == without_times(whole.validation)
    assert len(whole.history) == 10
    for name, value in whole.averaged.items():
        assert torch.equal(value, resumed.averaged[name]), name


def test_two_processes_learn_what_one_does_with_the_whole_batch(tmp_path: Path, made_up) -> None:
    rounds = ("--set", "feed_rounds=0", "--export", str(tmp_path / "two.safetensors"))
    # the two dashes, because torchrun would take --run for its own --run-path
    launcher = ["-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2", "-m", "--"]
    arguments = [sys.executable, *launcher, *command(tmp_path / "two", 12, *rounds)]
    done = subprocess.run(arguments, cwd=ROOT, capture_output=True, text=True, check=False, timeout=280)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("12 steps") == 1, "only the first process speaks"
    one = fit(tmp_path / "one", 12, feed_rounds=0)
    two = torch.load(tmp_path / "two" / "checkpoint.pt", weights_only=True)
    assert json.loads((tmp_path / "two" / "training.json").read_text())["processes"] == 2
    for lines, name in ((one.history, "history.json"), (one.validation, "validation.json")):
        found = without_times(json.loads((tmp_path / "two" / name).read_text()))
        assert len(found) == len(lines) > 1
        for ours, theirs in zip(without_times(lines), found, strict=True):
            assert theirs == pytest.approx(ours, rel=1e-3)
    for name, value in one.model.state_dict().items():
        torch.testing.assert_close(two["model"][name], value, atol=2e-4, rtol=1e-3)
    # what was learned is far more than what the number of processes changes
    begun, _ = train.start(train._config(one), trainee.load())
    learned = max(
        float((value - begun.model.state_dict()[name]).abs().max()) for name, value in one.model.state_dict().items()
    )
    assert learned > 2e-3
