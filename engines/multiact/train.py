"""Train MACVAE on triplets of prepared clips, and write its weights.

    train.fit(config.preset("small"), Path("runs/multiact"), device="cpu")
    train.export(state, Path("multiact.safetensors"))

which `motionloom train multiact --run runs/multiact --export multiact.safetensors` does too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from engines import datasets, weights_file
from engines.loom.data import vocabulary_of
from engines.multiact import triplets
from engines.multiact.config import MultiActConfig
from engines.multiact.data import Windows, prepared
from engines.multiact.losses import losses
from engines.multiact.model import MACVAE
from engines.training.devices import launch, share_of
from engines.training.loop import TrainingPlan, TrainingState
from engines.training.run import RunOptions, run

_HELD_BACK = 20
"""Of so many triplets for training there is one of held-back clips for validation."""


def fit(  # noqa: PLR0913 - what a training needs, each part but two optional
    config: MultiActConfig,
    folder: Path,
    clips: Sequence[datasets.Clip] | None = None,
    *,
    validation: Sequence[datasets.Clip] = (),
    seed: int = 0,
    corpora: Sequence[str] | None = None,
    plan: Mapping[str, Any] | None = None,
    device: str = "auto",
    options: RunOptions | None = None,
) -> TrainingState:
    """Train, or go on where `folder` holds a checkpoint.

    Args:
        config: a preset; its vocabulary is found in the clips.
        folder: gets the checkpoint, the settings and the logs.
        clips: the training split of the prepared data by default, whose triplets are made once and kept.
        validation: clips held back; the validation split of the prepared data if `clips` are not given.
        seed: of the first weights and of everything drawn.
        corpora: of the prepared data, all by default.
        plan: fields of `TrainingPlan` other than those the config gives.
        device: auto, cpu or cuda.
        options: how the run goes.

    Raises:
        MotionloomError: no clip shows an action.
        Everything that `engines.training.run` raises.
    """
    held = max(1, config.pairs // _HELD_BACK)
    if clips is None:
        clips = datasets.load("train", corpora)
        made = prepared("train", config.pairs, corpora, config.label_balance)
        unseen = prepared("val", held, corpora, config.label_balance)
    else:
        made = triplets.make(clips, config.pairs, balance=config.label_balance)
        unseen = triplets.make(validation, held) if validation else None
    actions, _, usual = vocabulary_of(clips)
    config = config.checked().replaced(actions=actions, usual_frames=usual)
    state, windows = start(config, made, seed, plan)
    fabric = launch(device, state.plan.precision)
    share_of(fabric).check(config.batch_size)

    def draw(now: TrainingState) -> dict[str, Tensor]:
        return losses(model_of(now), windows.draw(now.rng, now.share), now.generator, now.share)

    return run(
        state,
        draw,
        folder,
        config.to_json(),
        validate=_validation(Windows(unseen, actions, config.batch_size)) if unseen else None,
        facts={"corpora": corpora and list(corpora), "clips": len(clips), "triplets": len(made)},
        fabric=fabric,
        options=options or RunOptions(),
    )


def start(
    config: MultiActConfig, made: triplets.Triplets, seed: int = 0, plan: Mapping[str, Any] | None = None
) -> tuple[TrainingState, Windows]:
    """A new training: statistics from the triplets, weights from the seed."""
    windows = Windows(made, config.actions, config.batch_size)
    torch.manual_seed(seed)
    model = MACVAE(config)
    mean, std = windows.statistics()
    model.mean.copy_(mean)
    model.std.copy_(std)
    told = TrainingPlan.of(config, seed, **{"optimiser": "adamw", **(plan or {})})
    return TrainingState(model, told, identity={"engine": "multiact", "actions": config.actions}), windows


def export(state: TrainingState, path: Path, which: str | None = None) -> str:
    """Write the weights (float16) and their config beside each other; returns the weights' SHA-256."""
    weights = state.weights(which)
    step = state.best_step if weights is state.best else state.step
    config = model_of(state).config.replaced(extra={"step": step, "seconds": round(state.seconds)})
    return weights_file.write(weights, config.to_json(), path)


def read(path: Path) -> MACVAE:
    """The model of exported weights.

    Raises:
        CheckpointError: missing, damaged or of another architecture.
    """
    settings = weights_file.read_settings(path, "train them (motionloom train multiact)")
    model = MACVAE(MultiActConfig.from_json(settings).checked())
    weights_file.fill(model, path)
    return model.eval()


def model_of(state: TrainingState) -> MACVAE:
    """The model that is trained."""
    assert isinstance(state.model, MACVAE)
    return state.model


def _validation(held_back: Windows) -> Callable[[TrainingState], Iterator[dict[str, Tensor]]]:
    def validate(now: TrainingState) -> Iterator[dict[str, Tensor]]:
        generator = torch.Generator().manual_seed(now.plan.seed)
        for batch in held_back.each(now.share):
            yield losses(model_of(now), batch, generator, now.share)

    return validate
