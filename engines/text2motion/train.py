"""Train Text2Motion's three stages on prepared clips, and write weights: autoencoder, text2length, text2motion.

Each stage goes on from the weights of the one before (`base`), which it holds frozen and writes with its own; only the
autoencoder begins from nothing. `fit_all` is all three, one after another.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from engines import datasets, text, weights_file
from engines.datasets.captions import encoded
from engines.errors import CheckpointError
from engines.text import TextEncoder, token_vectors
from engines.text.words import Words
from engines.text2motion import data
from engines.text2motion.config import STAGES, Stage, Text2MotionConfig, check_stage
from engines.text2motion.losses import autoencoder_losses, text2length_losses, text2motion_losses
from engines.text2motion.model import Text2Motion
from engines.text2motion.words import Captions
from engines.training.devices import launch, share_of
from engines.training.loop import TrainingPlan, TrainingState
from engines.training.run import RunOptions, run
from engines.training.schedules import Constant, LengthCurriculum, Linear, Schedule

_OF_WORDS = ("text_encoder", "text_size", "words")
_OF_PARTS: dict[str, tuple[str, ...]] = {
    "autoencoder": ("code_size", "autoencoder_hidden", "dropout"),
    "text2length": (*_OF_WORDS, "length_hidden", "length_tags"),
    "text2motion": (
        *_OF_WORDS, "snippet_codes", "attention", "tags", "sides", "position", "text_hidden", "attention_size",
        "latent_size", "latent_hidden", "motion_hidden",
    ),
}  # fmt: skip
"""Settings that belong to weights that are there already."""
_IDENTITY = ("text_encoder", "snippet_codes", "attention", "tags", "sides", "position", "words")
CURRICULUM = "codes generated"
"""Name of the curriculum in checkpoints."""

Listener = Callable[[TrainingState], None]
Asked = Callable[[], bool]


class Material:
    """Captions of clips, and their tokens.

    Args:
        told: captions of clips.
        encoder: of their tokens.
        vectors: what it makes of them; made here if they are not given.
    """

    def __init__(
        self, told: data.Told, encoder: TextEncoder, vectors: token_vectors.TokenVectors | None = None
    ) -> None:
        self.told, self.encoder = told, encoder
        self.captions = Captions(told.sentences, encoder, vectors or token_vectors.encode(told.sentences, encoder))


def prepared(
    config: Text2MotionConfig,
    stage: str,
    progress: Callable[[int, int], None] | None = None,
    cancel: Asked | None = None,
) -> Material | None:
    """Captions of the prepared clips and their token vectors; made where they are missing.

    Args:
        config: names the text encoder.
        stage: the autoencoder needs none.
        progress: hears (done, to do) where they are made, which takes minutes.
        cancel: asked meanwhile.

    Raises:
        FormatError: no prepared data, or the cache cannot be written.
        CheckpointError: the text encoder's weights, or the word vectors, are not there.
        Cancelled: `cancel` said so.
    """
    if stage == "autoencoder":
        return None
    encoder = text.load(config.text_encoder)  # before minutes are spent on captions
    told = encoded.load(progress=(lambda done, total, _: progress(done, total)) if progress else None, cancel=cancel)
    vectors = token_vectors.load(told.sentences, encoder, datasets.cache_folder(), progress, cancel)
    return Material(told, encoder, vectors)


Prepare = Callable[[Text2MotionConfig, str], Material | None]


def start(  # noqa: PLR0913 - what a training begins from
    config: Text2MotionConfig,
    stage: str,
    clips: Sequence[datasets.Clip],
    *,
    base: Path | None = None,
    material: Material | None = None,
    seed: int = 0,
    plan: Mapping[str, Any] | None = None,
) -> tuple[TrainingState, data.Windows | data.Pairs]:
    """A new training: earlier parts from `base`, vocabulary and statistics from the clips, weights from the seed.

    Raises:
        CheckpointError: the stage needs weights of an earlier one.
    """
    stage = check_stage(stage)
    earlier = _earlier(stage, config, base)
    clips = data.mirrored(clips)
    if material is not None:
        said = {int(row) for clip in clips for row in material.told.of(clip)}
        words = Words.of(material.told.sentences[row] for row in sorted(said)).known
        config = config.replaced(words=words, text_size=material.encoder.size)
    config = _joined(config, earlier, stage).checked()
    torch.manual_seed(seed)
    model = Text2Motion(config)
    if earlier is not None:
        own, held = model.state_dict(), earlier.state_dict()
        own.update({name: held[name] for name in own if name in held and not name.startswith(f"{stage}.")})
        model.load_state_dict(own)
    model.freeze_all_but(stage)
    if stage == "autoencoder":
        source: data.Windows | data.Pairs = data.windows(clips, config)
        model.mean[...], model.std[...] = source.statistics()
    else:
        assert material is not None
        source = data.Pairs(clips, config, material.told, material.captions)
    return TrainingState(
        model,
        replace(_plan(config, stage, seed), **(plan or {})),
        groups=_groups(model, stage),
        identity=_identity(config, stage, base),
        curricula={CURRICULUM: _curriculum(config)} if stage == "text2motion" and not config.curriculum_steps else {},
    ), source


def fit(  # noqa: PLR0913 - what a training needs, each part but two optional
    config: Text2MotionConfig,
    stage: str,
    folder: Path,
    clips: Sequence[datasets.Clip] | None = None,
    *,
    base: Path | None = None,
    prepare: Prepare = prepared,
    validation: Sequence[datasets.Clip] | None = None,
    seed: int = 0,
    corpora: Sequence[str] | None = None,
    plan: Mapping[str, Any] | None = None,
    device: str = "auto",
    resume: bool | None = None,
    progress: Listener | None = None,
    cancel: Asked | None = None,
    tick: Listener | None = None,
) -> TrainingState:
    """Train a stage, or go on training where `folder` holds a checkpoint.

    Args:
        config: a preset; what belongs to earlier stages is taken from `base`.
        stage: autoencoder, text2length or text2motion.
        folder: gets the checkpoint, the settings and the logs.
        clips: the training split of the prepared data by default.
        base: weights of the stage before, written by `export`.
        prepare: gives the captions; those of the prepared data by default.
        validation: clips held back; the validation split of the prepared data if `clips` are not given either.
        seed: of the first weights and of everything drawn.
        corpora: of the prepared data, all by default.
        plan: fields of `TrainingPlan` other than those the config gives.
        device: auto, cpu or cuda.
        resume: as in `RunOptions`.
        progress: called each time a line is logged.
        cancel: asked each step.
        tick: called each step.

    Raises:
        CheckpointError: the stage needs weights of an earlier one, or the checkpoint is of another training.
    """
    stage = check_stage(stage)
    _earlier(stage, config.checked(), base)  # before minutes are spent on captions
    if clips is None:
        clips, held_back = datasets.load("train", corpora), datasets.load("val", corpora)
    else:
        held_back = list(validation or [])
    material = prepare(config, stage)
    state, source = start(config, stage, clips, base=base, material=material, seed=seed, plan=plan)
    model = model_of(state)
    fabric = launch(device, state.plan.precision)
    size = model.config.autoencoder_batch if stage == "autoencoder" else model.config.batch_size
    share_of(fabric).check(size)
    return run(
        state,
        _losses(source),
        folder,
        model.config.to_json(),
        validate=_validation(held_back, model, material) if held_back else None,
        facts={
            "stage": stage, "base": str(base) if base else None, "corpora": corpora and list(corpora),
            "clips": len(clips), "clips_held_back": len(held_back),
        },
        fabric=fabric,
        options=RunOptions(resume, progress, tick, cancel),
    )  # fmt: skip


def fit_all(
    config: Text2MotionConfig, folder: Path, one: Callable[..., TrainingState] = fit, **options: Any
) -> TrainingState:
    """All stages, one after another, each in a folder of its own; what is done is not done again.

    Args:
        config: a preset.
        folder: gets a folder and weights (`STAGE.safetensors`) of each stage.
        one: trains a stage, as `fit` does.
        options: as `fit` takes them, but for `base`.

    Raises:
        Everything that `fit` raises.
    """
    before: Path | None = None
    state: TrainingState | None = None
    for stage in STAGES:
        state = one(config, stage, folder / stage, base=before, **options)
        before = folder / f"{stage}.safetensors"
        if state.share.rank == 0:
            export(state, before)
        launch(options.get("device", "auto"), state.plan.precision).barrier()
    assert state is not None
    return state


def export(state: TrainingState, path: Path, which: str | None = None) -> str:
    """Write the weights of this stage and of those before it, and their config; returns the weights' SHA-256."""
    weights = state.weights(which)
    step = state.best_step if weights is state.best else state.step
    config = model_of(state).config
    stage = state.identity["stage"]
    notes = {**config.extra, f"{stage}_step": step, f"{stage}_seconds": round(state.seconds)}
    return weights_file.write(weights, config.replaced(extra=notes).to_json(), path)


def load(path: Path) -> Text2Motion:
    """The networks of weights that `export` wrote.

    Raises:
        CheckpointError: missing, damaged, or of another network.
    """
    settings = weights_file.read_settings(path, "train them (motionloom train text2motion)")
    model = Text2Motion(Text2MotionConfig.from_json(settings))
    weights_file.fill(model, path)
    return model


def model_of(state: TrainingState) -> Text2Motion:
    """The model that is trained."""
    assert isinstance(state.model, Text2Motion)
    return state.model


def aim(state: TrainingState) -> int:
    """Fours of frames that are generated now."""
    found = state.curricula.get(CURRICULUM)
    if isinstance(found, LengthCurriculum):
        return found.length
    config = model_of(state).config
    schedule = _schedule(config.curriculum_first, config.classes, config.curriculum_steps)
    return int(schedule(state.step))


def _losses(source: data.Windows | data.Pairs) -> Callable[[TrainingState], dict[str, Tensor]]:
    def draw(now: TrainingState) -> dict[str, Tensor]:
        model = model_of(now)
        if isinstance(source, data.Windows):
            return autoencoder_losses(model, source.draw(now.rng, now.share))
        if model.trained == "text2length":
            return text2length_losses(model, source.draw_texts(now.rng, now.share))
        config = model.config
        batch = source.draw(now.rng, aim(now), now.share)
        forced = _schedule(config.teacher_forcing_first, config.teacher_forcing, config.teacher_forcing_steps)
        weight = _schedule(0.0, config.kl_weight, config.kl_ramp)
        return text2motion_losses(model, batch, now.generator, forced(now.step), weight(now.step), now.share)

    return draw


def _validation(
    held_back: Sequence[datasets.Clip], model: Text2Motion, material: Material | None
) -> Callable[[TrainingState], Iterator[dict[str, Tensor]]]:
    """The same terms of clips held back; text2motion fed with its own codes, at its full weights."""
    clips = data.mirrored(held_back)
    source: data.Windows | data.Pairs
    if model.trained == "autoencoder":
        source = data.windows(clips, model.config)
    else:
        assert material is not None
        # a curriculum that validation moves on must hear of every motion, whatever its length
        config = model.config.replaced(keep_short=True)
        source = data.Pairs(clips, config, material.told, material.captions)

    def validate(now: TrainingState) -> Iterator[dict[str, Tensor]]:
        model, generator = model_of(now), torch.Generator().manual_seed(now.plan.seed)
        if isinstance(source, data.Windows):
            yield from (autoencoder_losses(model, batch) for batch in source.each(now.share))
        elif model.trained == "text2length":
            yield from (text2length_losses(model, batch) for batch in source.each_texts(now.share))
        else:
            until = aim(now) if now.curricula else model.config.classes
            for batch in source.each(until, now.share):
                yield text2motion_losses(model, batch, generator, 0.0, model.config.kl_weight, now.share)

    return validate


def _schedule(first: float, last: float, steps: int) -> Schedule:
    return Linear(first, last, steps) if steps else Constant(last)


def _curriculum(config: Text2MotionConfig) -> LengthCurriculum:
    return LengthCurriculum(config.curriculum_first, config.classes, term="codes")


def _groups(model: Text2Motion, stage: Stage) -> list[dict[str, Any]]:
    """Parameters that learn; the motion decoder, while it is fine-tuned, at a rate of its own."""
    parts = {name: [p for p in part.parameters() if p.requires_grad] for name, part in model.named_children()}
    groups: list[dict[str, Any]] = [{"params": parts.pop(stage)}]
    if tuned := [p for part in parts.values() for p in part]:
        groups.append({"params": tuned, "scale": model.config.decoder_rate})
    return groups


def _earlier(stage: Stage, config: Text2MotionConfig, base: Path | None) -> Text2Motion | None:
    """The networks of the stages before, all that this one needs."""
    if stage == "autoencoder":
        if base is not None:
            raise CheckpointError("stage 'autoencoder' is the first; it goes on from no other weights (--from).")
        return None
    if base is None:
        raise CheckpointError(f"stage {stage!r} goes on from the weights of an earlier one; say which (--from FILE).")
    earlier = load(base)
    if stage == "text2motion" and config.snippet_codes and earlier.autoencoder is None:
        raise CheckpointError(
            f"{base}: holds no autoencoder of snippets, whose codes text2motion tells; train stage autoencoder first, "
            "or do without it (--set snippet_codes=false)."
        )
    return earlier


def _joined(config: Text2MotionConfig, earlier: Text2Motion | None, stage: Stage) -> Text2MotionConfig:
    """Settings with all parts, those of parts that are there already from the weights that hold them."""
    if earlier is None:
        return config.replaced(parts=(stage,))
    there = set(earlier.config.parts)
    if stage == "text2motion" and not config.snippet_codes:
        there.discard("autoencoder")
    kept = {"longest", *(name for part in there - {stage} for name in _OF_PARTS[part])}
    parts = tuple(part for part in STAGES if part in there | {stage})
    told = {name: getattr(earlier.config, name) for name in sorted(kept)}
    return config.replaced(**told, parts=parts, extra=dict(earlier.config.extra))


def _plan(config: Text2MotionConfig, stage: Stage, seed: int) -> TrainingPlan:
    return TrainingPlan.of(
        config, seed, steps=config.steps_of(stage), optimiser="adamw" if config.weight_decay else "adam"
    )


def _identity(config: Text2MotionConfig, stage: str, base: Path | None) -> dict[str, Any]:
    values = {name: getattr(config, name) for name in _IDENTITY}
    digest = hashlib.sha256(base.read_bytes()).hexdigest() if base else ""
    return {"engine": "text2motion", "stage": stage, "base": digest, **values}
