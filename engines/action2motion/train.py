"""Train Action2Motion on prepared clips, and write the weights that ship."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor

from engines import datasets
from engines.action2motion import data
from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.losses import losses
from engines.action2motion.model import Action2Motion
from engines.errors import CheckpointError, MotionloomError, OutOfRangeError
from engines.skeletons import SMPL22
from engines.training.devices import launch, share_of
from engines.training.files import write_beside
from engines.training.loop import TrainingPlan, TrainingState
from engines.training.run import RunOptions, run

log = logging.getLogger(__name__)

FEET = [SMPL22.index(name) for foot in SMPL22.feet for name in foot]
_IDENTITY = ("decoder", "actions", "fps", "time_counter", "normalise")
"""Settings in which a checkpoint must agree to be gone on from; sizes speak for themselves."""


def start(
    config: Action2MotionConfig,
    clips: Sequence[datasets.Clip],
    seed: int = 0,
    plan: Mapping[str, Any] | None = None,
) -> tuple[TrainingState, data.Sequences]:
    """A new training: vocabulary and statistics from the clips, weights from the seed.

    Args:
        config: its `actions` are the ones to learn, all that occur if it names none.
        clips: to train on.
        seed: of the first weights and of everything drawn.
        plan: fields of `TrainingPlan` other than those the config gives.

    Raises:
        OutOfRangeError: a setting is out of its range.
        MotionloomError: no clip shows an action, or a clip's label is not in the vocabulary.
    """
    config = config.checked()
    if not any(clip.action for clip in clips):
        raise MotionloomError(
            f"none of the {len(clips)} clips has an action to be trained; run: motionloom data prepare, "
            "or choose other corpora."
        )
    names, lengths = data.vocabulary_of(clips, config.fps, config.actions)
    config = config.replaced(actions=names, nominal_frames=lengths)
    sequences = data.Sequences(clips, config)
    torch.manual_seed(seed)
    model = Action2Motion(config)
    if config.normalise:
        model.pose_mean, model.pose_std, model.velocity_std = sequences.statistics()
    identity = {"engine": "action2motion", **{name: getattr(config, name) for name in _IDENTITY}}
    return TrainingState(model, TrainingPlan.of(config, seed, **(plan or {})), identity=identity), sequences


def fit(  # noqa: PLR0913, PLR0917 - what a training needs, each part but two optional
    config: Action2MotionConfig,
    folder: Path,
    clips: Sequence[datasets.Clip] | None = None,
    seed: int = 0,
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
    *,
    validation: Sequence[datasets.Clip] | None = None,
    corpora: Sequence[str] | None = None,
    plan: Mapping[str, Any] | None = None,
    trunk: Path | None = None,
    device: str = "auto",
    resume: bool | None = None,
    tick: Callable[[TrainingState], None] | None = None,
) -> TrainingState:
    """Train, or go on training where `folder` holds a checkpoint.

    Args:
        config: preset with the decoder chosen.
        folder: gets `checkpoint.pt` (exact resume), `config.json`, `training.json`, `history.json`, `validation.json`,
            `losses.csv` and the page `losses.html`.
        clips: the training split of the prepared data by default.
        seed: of the first weights and of everything drawn.
        progress: called each time a line is logged.
        cancel: asked each step; the checkpoint is written before `Cancelled` is raised.
        validation: clips held back; the validation split of the prepared data if `clips` are not given either.
        corpora: of the prepared data, all by default.
        plan: fields of `TrainingPlan` other than those the config gives, such as `patience`.
        trunk: weights of another decoder (.safetensors, settings beside them) to take all from but the velocity unit,
            which alone is then trained.
        device: auto, cpu or cuda.
        resume: True: there must be a checkpoint. False: begin anew. None: go on if there is one.
        tick: called each step.
    """
    if clips is None:
        clips, held_back = datasets.load("train", corpora), datasets.load("val", corpora)
    else:
        held_back = list(validation or [])
    state, sequences = start(config, clips, seed, plan)
    config = _config(state)
    if trunk is not None:
        take_trunk(state, trunk)
    fabric = launch(device, state.plan.precision)
    share_of(fabric).check(config.batch_size)
    sequences.to(fabric.device)
    shown = [clip for clip in held_back if clip.action in config.actions]
    _say_what_is_held_back(held_back, shown, state.plan)

    def draw(now: TrainingState) -> dict[str, Tensor]:
        batch = sequences.draw(now.rng, share=now.share)
        return losses(_model(now), batch, now.step, FEET, now.generator, now.share)

    return run(
        state,
        draw,
        folder,
        config.to_json(),
        validate=_validation(data.Sequences(shown, config).to(fabric.device)) if shown else None,
        facts={"corpora": corpora and list(corpora), "clips": len(clips), "clips_held_back": len(shown)},
        fabric=fabric,
        options=RunOptions(resume, progress, tick, cancel),
    )


def take_trunk(state: TrainingState, path: Path) -> None:
    """Put the weights of a trained model in place of all but the velocity unit, and train only that.

    The decoders lie, glmi-m and glmi-r differ in nothing else, so a trained trunk serves all three.

    Raises:
        CheckpointError: the weights are missing, or of other sizes, actions or decoder.
    """
    model = _model(state)
    try:
        theirs = Action2MotionConfig.from_json(path.with_suffix(".json").read_text(encoding="utf-8"))
        stored = {name: value.float() for name, value in load(path.read_bytes()).items()}
    except (OSError, SafetensorError) as error:
        raise CheckpointError(f"{path}: cannot take a trunk from here: {error}") from error
    own = {name: value for name, value in model.state_dict().items() if _of_trunk(name)}
    unlike = [name for name, value in own.items() if name not in stored or stored[name].shape != value.shape]
    if unlike or theirs.actions != model.config.actions:
        what = ", ".join(unlike[:3]) or "their actions"
        raise CheckpointError(f"{path}: the trunk of these weights does not fit; they differ in {what}.")
    model.load_state_dict({name: stored[name] for name in own}, strict=False)
    state.averaged = {name: value.detach().clone() for name, value in model.state_dict().items()}
    for name, parameter in model.named_parameters():
        parameter.requires_grad_(not _of_trunk(name))


def _of_trunk(name: str) -> bool:
    return not name.startswith("velocity.")


def _validation(held_back: data.Sequences) -> Callable[[TrainingState], Iterator[dict[str, Tensor]]]:
    """Terms of every clip held back, with the last step's weights, so that they can be compared over the training."""

    def validate(now: TrainingState) -> Iterator[dict[str, Tensor]]:
        generator = torch.Generator().manual_seed(now.plan.seed)
        for batch in held_back.each(np.random.default_rng(now.plan.seed), now.share):
            yield losses(_model(now), batch, _config(now).steps, FEET, generator, now.share)

    return validate


def _say_what_is_held_back(held_back: Sequence[Any], shown: Sequence[Any], plan: TrainingPlan) -> None:
    if len(shown) < len(held_back):
        log.info(
            "%d of %d clips held back show no action of the vocabulary", len(held_back) - len(shown), len(held_back)
        )
    if plan.patience and not (shown and plan.validate_every):
        raise OutOfRangeError("patience", plan.patience, "0, for there are no clips held back to validate on")


def export(state: TrainingState, path: Path, which: str | None = None) -> str:
    """Write the weights (float16) and their config beside each other; returns the weights' SHA-256.

    Args:
        state: trained.
        path: of the weights, ending in .safetensors.
        which: `best` by validation, `last` averaged ones, or as `TrainingState.weights` chooses.
    """
    weights = state.weights(which)
    step = state.best_step if weights is state.best else state.step
    content = save({name: value.cpu().half().contiguous() for name, value in weights.items()})
    write_beside(path, content)
    config = _config(state).replaced(extra={"step": step, "seconds": round(state.seconds)})
    write_beside(path.with_suffix(".json"), config.to_json() + "\n")
    return hashlib.sha256(content).hexdigest()


def _model(state: TrainingState) -> Action2Motion:
    assert isinstance(state.model, Action2Motion)
    return state.model


def _config(state: TrainingState) -> Action2MotionConfig:
    return _model(state).config
