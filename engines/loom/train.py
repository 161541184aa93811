"""Train Loom on prepared clips, and write the weights that ship."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from engines import datasets, text, weights_file
from engines.datasets.captions import encoded
from engines.errors import CheckpointError, UnknownLabelError
from engines.loom import data
from engines.loom.config import LoomConfig
from engines.loom.losses import losses
from engines.loom.model import Loom
from engines.text import sides
from engines.text.everyday import EVERYDAY
from engines.training.devices import launch, share_of
from engines.training.loop import TrainingPlan, TrainingState
from engines.training.run import RunOptions, run

_SIZES = ("width", "depth", "heads", "inner", "patch", "frame_width", "longest", "text_encoder")
_IDENTITY = ("actions", "styles", "text_encoder", "patch")


def start(  # noqa: PLR0913 - what a training begins from
    config: LoomConfig,
    clips: Sequence[datasets.Clip],
    *,
    seed: int = 0,
    plan: Mapping[str, Any] | None = None,
    captions: data.Captions | None = None,
    base: Path | None = None,
) -> tuple[TrainingState, data.Windows]:
    """A new training: vocabulary and statistics from the clips, weights from the seed; or all of `base`.

    Raises:
        CheckpointError: `base` is no weights of Loom, or of other sizes than `config`.
        UnknownLabelError: an emphasised action is not in the vocabulary.
    """
    config = config.checked()
    if base is None:
        actions, styles, usual = data.vocabulary_of(clips)
        config = config.replaced(actions=actions, styles=styles, usual_frames=usual)
    else:
        config = _going_on(config, base)
    for name in config.emphasised:
        if name not in config.actions:
            raise UnknownLabelError("action", name, config.actions)
    windows = data.Windows(clips, config, captions)
    torch.manual_seed(seed)
    model = Loom(config)
    if base is None:
        mean, std = windows.statistics()
        model.mean.copy_(mean)
        model.std.copy_(std)
    else:
        weights_file.fill(model, base)
    told = TrainingPlan.of(config, seed, **{"optimiser": "adamw", **(plan or {})})
    identity = {"engine": "loom", **{name: getattr(config, name) for name in _IDENTITY}}
    return TrainingState(model, told, identity=identity), windows


def fit(  # noqa: PLR0913 - what a training needs, each part but two optional
    config: LoomConfig,
    folder: Path,
    clips: Sequence[datasets.Clip] | None = None,
    *,
    validation: Sequence[datasets.Clip] | None = None,
    captions: data.Captions | None = None,
    base: Path | None = None,
    seed: int = 0,
    corpora: Sequence[str] | None = None,
    plan: Mapping[str, Any] | None = None,
    device: str = "auto",
    resume: bool | None = None,
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
    tick: Callable[[TrainingState], None] | None = None,
) -> TrainingState:
    """Train, or go on training where `folder` holds a checkpoint; arguments as `engines.action2motion.train.fit`.

    Args:
        config: a preset.
        folder: gets the checkpoint, the settings and the logs.
        clips: the training split of the prepared data by default.
        validation: clips held back; the validation split of the prepared data if `clips` are not given either.
        captions: gives sentence vectors of clips; without, nothing is told in words.
        base: weights to begin from, written by `export`; their steps and time are counted on.
        seed: of the first weights and of everything drawn.
        corpora: of the prepared data, all by default.
        plan: fields of `TrainingPlan` other than those the config gives.
        device: auto, cpu or cuda.
        resume: as in `RunOptions`.
        progress: called each time a line is logged.
        cancel: asked each step.
        tick: called each step.
    """
    if clips is None:
        clips, held_back = datasets.load("train", corpora), datasets.load("val", corpora)
    else:
        held_back = list(validation or [])
    state, windows = start(config, clips, seed=seed, plan=plan, captions=captions, base=base)
    config = model_of(state).config
    fabric = launch(device, state.plan.precision)
    share_of(fabric).check(config.batch_size)

    def draw(now: TrainingState) -> dict[str, Tensor]:
        model = model_of(now)
        batch = windows.draw(now.rng, model.mean.cpu(), model.std.cpu(), share=now.share)
        return losses(model, batch, now.generator, now.share)

    return run(
        state,
        draw,
        folder,
        config.to_json(),
        validate=_validation(data.Windows(held_back, config, captions)) if held_back else None,
        facts={"corpora": corpora and list(corpora), "clips": len(clips), "clips_held_back": len(held_back)},
        fabric=fabric,
        options=RunOptions(resume, progress, tick, cancel),
    )


def told_in_words(clips: Sequence[datasets.Clip], count: int = 16, asked: int = 8) -> np.ndarray:
    """(N, count + asked, `sides.SIZE`) float16: what each clip is told by.

    Args:
        clips: prepared clips or mirror images of them.
        count: captions of each, from the cache of encoded captions.
        asked: sentences as people ask for its action (`engines.text.everyday`); captions where there is no action.
    """
    told = encoded.load()
    sentences = sides.joined(told.vectors, told.sentences)
    asking = _asking() if asked else {}
    rows = []
    for place, clip in enumerate(clips):
        captions = sentences[np.resize(told.of(clip), count)]
        everyday = asking.get(clip.action or "", captions)
        rows.append(np.concatenate([captions, everyday[np.arange(place, place + asked) % len(everyday)]]))
    return np.stack(rows)


def _asking() -> dict[str, np.ndarray]:
    """Action -> (K, `sides.SIZE`) float16 of everyday sentences."""
    vectors = {name: text.load().encode(lines).sentences.numpy() for name, lines in EVERYDAY.items()}
    return {name: sides.joined(found.astype(np.float16), EVERYDAY[name]) for name, found in vectors.items()}


def _validation(held_back: data.Windows) -> Callable[[TrainingState], Iterator[dict[str, Tensor]]]:
    def validate(now: TrainingState) -> Iterator[dict[str, Tensor]]:
        generator = torch.Generator().manual_seed(now.plan.seed)
        model = model_of(now)
        for batch in held_back.each(model.mean.cpu(), model.std.cpu(), now.share):
            yield losses(model, batch, generator, now.share)

    return validate


def _going_on(config: LoomConfig, base: Path) -> LoomConfig:
    """The settings with vocabulary and notes of the weights in `base`, which must be of the same sizes."""
    held = LoomConfig.from_json(weights_file.read_settings(base, "train them (motionloom train loom --export)"))
    for name in _SIZES:
        if getattr(config, name) != getattr(held, name):
            raise CheckpointError(f"{base}: its {name} is {getattr(held, name)}, asked for is {getattr(config, name)}.")
    notes = {key: held.extra[key] for key in ("step", "seconds") if key in held.extra}
    return config.replaced(actions=held.actions, styles=held.styles, usual_frames=held.usual_frames, extra=notes)


def export(state: TrainingState, path: Path, which: str | None = None) -> str:
    """Write the weights (float16) and their config beside each other; returns the weights' SHA-256."""
    weights = state.weights(which)
    step = state.best_step if weights is state.best else state.step
    config = model_of(state).config
    before = config.extra  # of the weights it began from
    total = {"step": before.get("step", 0) + step, "seconds": before.get("seconds", 0) + round(state.seconds)}
    config = config.replaced(extra={**before, **total})
    return weights_file.write(weights, config.to_json(), path)


def model_of(state: TrainingState) -> Loom:
    """The model that is trained."""
    assert isinstance(state.model, Loom)
    return state.model
