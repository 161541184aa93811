"""Recognisers: what they see, how they are trained and stored, and how right the shipped ones are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from engines import datasets
from engines.datasets import Clip
from engines.errors import Cancelled, CheckpointError, MotionloomError, UnknownLabelError
from engines.metrics.evaluators import recogniser, train, trunk
from engines.metrics.evaluators.recogniser import Recogniser, RecogniserConfig, RecogniserNet
from tests.engines.action2motion.tiny import movement

SMALL = RecogniserConfig(width=24, features=16, steps=120, batch_size=16)


def clips(count: int = 6) -> list[Clip]:
    """Two kinds of movement that differ in how they turn; neither has a mirrored form of its own."""
    made = []
    for i in range(count):
        for action, turning in (("walk", 0.3), ("dance", 4.0)):
            motion = movement(50 + i, seed=i, turning=turning)
            style = "happy" if i % 2 else "sad"
            made.append(Clip("bandai-namco", f"{action}-{i}", action, style, None, None, "train", motion))
    return made


def net(labels: tuple[str, ...] = ("a", "b", "c")) -> RecogniserNet:
    torch.manual_seed(0)
    return RecogniserNet(replace(SMALL, labels=labels)).eval()


def test_neither_place_nor_heading_nor_rate_nor_bone_lengths_count() -> None:
    motion = movement(40)
    seen = trunk.describe(motion)
    assert seen.shape == (40, trunk.CHANNELS)
    moved = trunk.describe(motion.moved((3.0, 0.0, -2.0), yaw=1.3))
    np.testing.assert_allclose(moved, seen, atol=1e-4)
    scaled = trunk.describe(motion.scale_bones({"left_knee": 1.3}))
    np.testing.assert_allclose(scaled[:, :-4], seen[:, :-4], atol=1e-4)
    assert len(trunk.describe(motion.resample(60.0))) == pytest.approx(40, abs=1)


def test_padding_changes_nothing() -> None:
    made = net()
    rows = [trunk.describe(movement(length), hands=True) for length in (23, 60, 41)]
    together = made(*trunk.pad(rows))
    for i, row in enumerate(rows):
        alone = made(*trunk.pad([row]))
        torch.testing.assert_close(together[0][i : i + 1], alone[0], atol=1e-4, rtol=1e-4)
        torch.testing.assert_close(together[1][i : i + 1], alone[1], atol=1e-4, rtol=1e-4)


def test_it_learns_to_tell_two_movements_apart(tmp_path) -> None:
    found = train.fit(replace(SMALL, steps=220), clips(12), tmp_path / "run.pt")
    assert found.labels == ("dance", "walk")
    held_out = [replace(clip, motion=movement(55, seed=40 + i, turning=0.3 if clip.action == "walk" else 4.0))
                for i, clip in enumerate(clips(4))]  # fmt: skip
    assert train.accuracy(found, held_out)["bandai-namco"][0] >= 0.9
    train.export(found, tmp_path / "mine.safetensors", steps=120)
    again = recogniser.load("action", tmp_path / "mine.safetensors")
    assert again.config.extra == {"steps": 120}
    motions = [clip.motion for clip in held_out]
    np.testing.assert_allclose(again.recognised(motions).logits, found.recognised(motions).logits, atol=0.05)


def test_resuming_is_exact(tmp_path) -> None:
    config = replace(SMALL, steps=6)
    whole = train.fit(config, clips(3))
    asked = iter([False, False, True])
    with pytest.raises(Cancelled):
        train.fit(config, clips(3), tmp_path / "run.pt", cancel=lambda: next(asked))
    resumed = train.fit(config, clips(3), tmp_path / "run.pt")
    for name, value in whole.net.state_dict().items():
        assert torch.equal(value, resumed.net.state_dict()[name]), name


def test_what_a_clip_shows_for_a_task() -> None:
    clip = clips(1)[0]
    assert [train.label_of(clip, task) for task in recogniser.TASKS] == ["walk", "walk", "sad"]
    other = replace(clip, corpus="cmu", style=None)
    assert [train.label_of(other, task) for task in recogniser.TASKS] == ["walk", None, None]
    with pytest.raises(MotionloomError, match="style"):
        train.Windows([other], "style")


def test_unknown_names_and_files(tmp_path) -> None:
    with pytest.raises(UnknownLabelError, match="style"):
        recogniser.load("styles")
    with pytest.raises(CheckpointError, match="motionloom train evaluator --task action"):
        recogniser.load("action", tmp_path / "none.safetensors")
    with pytest.raises(UnknownLabelError, match="walk"):
        Recogniser(net(("walk", "run"))).index("wlak")


@pytest.mark.data
@pytest.mark.parametrize(("task", "corpus", "least"), [
    ("action", "bandai-namco", 0.93), ("action", "utd-mhad", 0.80), ("style", "bandai-namco", 0.95),
    ("content", "bandai-namco", 0.95),
])  # fmt: skip
def test_the_shipped_ones_on_held_out_clips(task, corpus, least) -> None:
    if not (datasets.cache_folder() / f"house-v{datasets.VERSION}.npz").is_file():
        pytest.skip("no prepared data: motionloom data prepare")
    found = train.accuracy(recogniser.load(task), datasets.load("test", corpora=[corpus]))
    assert found[corpus][0] >= least
