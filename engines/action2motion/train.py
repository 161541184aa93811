"""Train Action2Motion on prepared clips, and write the weights that ship."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from safetensors.torch import save_file

from engines import datasets
from engines.action2motion import data
from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.losses import losses
from engines.action2motion.model import Action2Motion
from engines.skeletons import SMPL22
from engines.training.loop import TrainingPlan, TrainingState, train

FEET = [SMPL22.index(name) for foot in SMPL22.feet for name in foot]


def start(
    config: Action2MotionConfig, clips: Sequence[datasets.Clip], seed: int = 0
) -> tuple[TrainingState, data.Sequences]:
    """A new training: vocabulary and statistics from the clips, weights from the seed."""
    names, lengths = data.vocabulary_of(clips, config.fps)
    config = config.replaced(actions=names, nominal_frames=lengths)
    sequences = data.Sequences(clips, config)
    torch.manual_seed(seed)
    model = Action2Motion(config)
    if config.normalise:
        model.pose_mean, model.pose_std, model.velocity_std = sequences.statistics()
    plan = TrainingPlan(
        steps=config.steps,
        learning_rate=config.learning_rate,
        final_learning_rate=config.final_learning_rate,
        weight_decay=config.weight_decay,
        seed=seed,
    )
    return TrainingState(model, plan), sequences


def fit(  # noqa: PLR0913, PLR0917 - what a training needs, each part but two optional
    config: Action2MotionConfig,
    folder: Path,
    clips: Sequence[datasets.Clip] | None = None,
    seed: int = 0,
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> TrainingState:
    """Train, or go on training where `folder` holds a checkpoint.

    Args:
        config: preset with the decoder chosen.
        folder: gets `checkpoint.pt` (exact resume), `history.json` and the config.
        clips: the training split of the prepared data by default.
        seed: of the first weights and of everything drawn.
        progress: called each time a line is logged.
        cancel: asked each step; the checkpoint is written before `Cancelled` is raised.
    """
    folder.mkdir(parents=True, exist_ok=True)
    state, sequences = start(config, datasets.load("train") if clips is None else clips, seed)
    checkpoint = folder / "checkpoint.pt"
    if checkpoint.exists():
        state.restore(checkpoint)
    _write(folder / "config.json", _config(state).to_json())

    def draw(now: TrainingState) -> dict[str, torch.Tensor]:
        return losses(_model(now), sequences.draw(now.rng), now.step, FEET, now.generator)

    def report(now: TrainingState) -> None:
        _write(folder / "history.json", json.dumps(now.history))
        if progress:
            progress(now)

    return train(state, draw, checkpoint, report, cancel)


def export(state: TrainingState, path: Path) -> str:
    """Write the averaged weights (float16) and their config beside each other; returns the weights' SHA-256."""
    weights = {name: value.half().contiguous() for name, value in state.averaged.items()}
    temporary = path.with_suffix(".partial")
    save_file(weights, temporary)
    temporary.replace(path)
    config = _config(state).replaced(extra={"step": state.step, "seconds": round(state.seconds)})
    _write(path.with_suffix(".json"), config.to_json() + "\n")
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _write(path: Path, text: str) -> None:
    """Beside the old file, then in its place."""
    temporary = path.with_suffix(".partial")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def _model(state: TrainingState) -> Action2Motion:
    assert isinstance(state.model, Action2Motion)
    return state.model


def _config(state: TrainingState) -> Action2MotionConfig:
    return _model(state).config
