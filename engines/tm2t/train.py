"""Train TM2T's three stages on prepared clips, and write weights: motion tokens, then motion2text, then text2motion.

Each stage goes on from the weights of the one before (`base`), which it holds frozen and writes with its own; only the
tokenizer begins from nothing. Text2motion without inverse alignment (`alignment=0`) needs no motion2text.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from engines import datasets, text, weights_file
from engines.datasets.captions import encoded
from engines.errors import CheckpointError
from engines.text import TextEncoder, token_vectors
from engines.text.words import Words
from engines.tm2t import data
from engines.tm2t.config import PARTS, TM2TConfig, check_stage
from engines.tm2t.losses import m2t_losses, t2m_losses, vq_losses
from engines.tm2t.model import TM2T
from engines.training.devices import launch, share_of
from engines.training.loop import TrainingPlan, TrainingState
from engines.training.run import RunOptions, run

_OF_THE_TOKENIZER = (
    "codes", "code_size", "vq_width", "decoder_blocks", "codebook_update", "codebook_decay", "codebook_least",
    "commitment", "movement_weight", "longest",
)  # fmt: skip
_OF_MOTION2TEXT = ("words", "m2t_layers", "width", "inner", "heads", "head_size")
_IDENTITY = ("text_encoder", "codes", "code_size", "codebook_update", "backbone", "late_attention", "words")


class Material:
    """What clips of the training and those held back have in common: captions and their vectors.

    Args:
        told: captions of clips.
        encoder: of their tokens, for text2motion.
        vectors: what it makes of them; made here if they are not given.
    """

    def __init__(
        self, told: data.Told, encoder: TextEncoder | None = None, vectors: token_vectors.TokenVectors | None = None
    ) -> None:
        self.told, self.encoder = told, encoder
        self.vectors = token_vectors.encode(told.sentences, encoder) if encoder and vectors is None else vectors


def prepared(
    config: TM2TConfig,
    stage: str,
    progress: Callable[[int, int], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Material | None:
    """Captions of the prepared clips, and for text2motion their token vectors; made where they are missing.

    Args:
        config: names the text encoder.
        stage: vq needs none.
        progress: hears (done, to do) where they are made, which takes minutes.
        cancel: asked meanwhile.

    Raises:
        FormatError: no prepared data, or the cache cannot be written.
        Cancelled: `cancel` said so.
    """
    if stage == "vq":
        return None
    told = encoded.load(progress=(lambda done, total, _: progress(done, total)) if progress else None, cancel=cancel)
    if stage == "m2t":
        return Material(told)
    encoder = text.load(config.text_encoder)
    vectors = token_vectors.load(told.sentences, encoder, datasets.cache_folder(), progress, cancel)
    return Material(told, encoder, vectors)


Prepare = Callable[[TM2TConfig, str], Material | None]


def start(  # noqa: PLR0913 - what a training begins from
    config: TM2TConfig,
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
    stage, config = check_stage(stage), config.checked()
    earlier = None if stage == "vq" else _earlier(stage, config, base)
    clips = data.mirrored(clips)
    if earlier is not None and PARTS["m2t"] not in earlier.config.parts:
        assert material is not None
        said = {int(row) for clip in clips for row in material.told.of(clip)}
        config = config.replaced(words=Words.of(material.told.sentences[row] for row in sorted(said)).known)
    if stage == "t2m" and material is not None and material.encoder is not None:
        config = config.replaced(text_size=material.encoder.size)
    if earlier is not None:
        config = _joined(config, earlier.config, stage)
    torch.manual_seed(seed)
    model = TM2T(config.replaced(parts=_parts(stage, earlier)))
    if earlier is not None:
        own = model.state_dict()
        own.update({k: v for k, v in earlier.state_dict().items() if not k.startswith(f"{PARTS[stage]}.")})
        model.load_state_dict(own)
    model.freeze_all_but(PARTS[stage])
    if earlier is None:
        source: data.Windows | data.Pairs = data.Windows(clips, config)
        model.mean[...], model.std[...] = source.statistics()
    else:
        assert material is not None
        source = data.Pairs(clips, model, material.told, material.vectors)
    return TrainingState(
        model,
        TrainingPlan.of(config, seed, **{"optimiser": "adamw" if config.weight_decay else "adam", **(plan or {})}),
        groups=[{"params": [p for p in model.parameters() if p.requires_grad]}],
        identity=_identity(model.config, stage, base),
    ), source


def fit(  # noqa: PLR0913 - what a training needs, each part but two optional
    config: TM2TConfig,
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
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
    tick: Callable[[TrainingState], None] | None = None,
) -> TrainingState:
    """Train a stage, or go on training where `folder` holds a checkpoint.

    Args:
        config: a preset; what belongs to earlier stages is taken from `base`.
        stage: vq, m2t or t2m.
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
    if stage != "vq":
        _earlier(stage, config, base)  # before minutes are spent on captions
    if clips is None:
        clips, held_back = datasets.load("train", corpora), datasets.load("val", corpora)
    else:
        held_back = list(validation or [])
    material = prepare(config, stage)
    state, source = start(config, stage, clips, base=base, material=material, seed=seed, plan=plan)
    model = model_of(state)
    fabric = launch(device, state.plan.precision)
    share_of(fabric).check(model.config.vq_batch_size if stage == "vq" else model.config.batch_size)
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


def export(state: TrainingState, path: Path, which: str | None = None) -> str:
    """Write the weights of this stage and of those before it, and their config; returns the weights' SHA-256."""
    weights = state.weights(which)
    step = state.best_step if weights is state.best else state.step
    config = model_of(state).config
    notes = {**config.extra, f"{state.identity['stage']}_step": step}
    notes[f"{state.identity['stage']}_seconds"] = round(state.seconds)
    return weights_file.write(weights, config.replaced(extra=notes).to_json(), path)


def load(path: Path) -> TM2T:
    """The networks of weights that `export` wrote.

    Raises:
        CheckpointError: missing, damaged, or of another network.
    """
    settings = weights_file.read_settings(path, "train them (motionloom train tm2t)")
    model = TM2T(TM2TConfig.from_json(settings))
    weights_file.fill(model, path)
    return model


def model_of(state: TrainingState) -> TM2T:
    """The model that is trained."""
    assert isinstance(state.model, TM2T)
    return state.model


def _losses(source: data.Windows | data.Pairs) -> Callable[[TrainingState], dict[str, Tensor]]:
    def draw(now: TrainingState) -> dict[str, Tensor]:
        model = model_of(now)
        if isinstance(source, data.Windows):
            return vq_losses(model, source.draw(now.rng, now.share))
        batch = source.draw(now.rng, now.share)
        if model.trained == PARTS["m2t"]:
            return m2t_losses(model, batch)
        # one coin a batch
        teacher = bool(now.rng.random() < model.config.teacher_forcing)
        return t2m_losses(model, batch, teacher, now.generator, now.share)

    return draw


def _validation(
    held_back: Sequence[datasets.Clip], model: TM2T, material: Material | None
) -> Callable[[TrainingState], Iterator[dict[str, Tensor]]]:
    """The same terms of clips held back; of text2motion what the real tokens are worth, without inverse alignment."""
    clips = data.mirrored(held_back)
    source: data.Windows | data.Pairs
    if model.trained == PARTS["vq"]:
        source = data.Windows(clips, model.config)
    else:
        assert material is not None
        source = data.Pairs(clips, model, material.told, material.vectors)

    def validate(now: TrainingState) -> Iterator[dict[str, Tensor]]:
        generator = torch.Generator().manual_seed(now.plan.seed)
        for batch in source.each(now.share):
            if isinstance(batch, Tensor):
                yield vq_losses(model_of(now), batch)
            elif model_of(now).trained == PARTS["m2t"]:
                yield m2t_losses(model_of(now), batch)
            else:
                yield t2m_losses(model_of(now), batch, True, generator, now.share)

    return validate


def _earlier(stage: str, config: TM2TConfig, base: Path | None) -> TM2T:
    """The networks of the stages before, all that this one needs."""
    if base is None:
        raise CheckpointError(f"stage {stage!r} goes on from the weights of an earlier one; say which (--from FILE).")
    earlier = load(base)
    if stage == "t2m" and config.alignment > 0 and earlier.motion2text is None:
        raise CheckpointError(
            f"{base}: holds no motion2text, which inverse alignment listens to; train stage m2t first, or do without "
            "it (--set alignment=0)."
        )
    return earlier


def _parts(stage: str, earlier: TM2T | None) -> tuple[str, ...]:
    there = set(earlier.config.parts) if earlier else set()
    return tuple(part for part in PARTS.values() if part in there | {PARTS[stage]})


def _joined(config: TM2TConfig, earlier: TM2TConfig, stage: str) -> TM2TConfig:
    """Settings, those of parts that are there already from the weights that hold them."""
    kept = _OF_THE_TOKENIZER
    if stage == "t2m" and PARTS["m2t"] in earlier.parts:
        kept += _OF_MOTION2TEXT
    if stage == "m2t" and PARTS["t2m"] in earlier.parts:
        kept += ("text_encoder", "text_size", "text_hidden", "motion_hidden", "motion_layers", "late_attention")
        kept += ("backbone", "t2m_layers", "width", "inner", "heads", "head_size")
    return config.replaced(**{name: getattr(earlier, name) for name in kept}, extra=dict(earlier.extra))


def _identity(config: TM2TConfig, stage: str, base: Path | None) -> dict[str, Any]:
    values = {name: getattr(config, name) for name in _IDENTITY}
    digest = hashlib.sha256(base.read_bytes()).hexdigest() if base else ""
    return {"engine": "tm2t", "stage": stage, "base": digest, **values}
