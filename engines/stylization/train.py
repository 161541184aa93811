"""Train latent stylization, stage by stage: autoencoder, global motion regressor, style model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from torch import Tensor, nn

from engines import datasets, weights_file
from engines.errors import CheckpointError, UnknownLabelError
from engines.stylization import losses, tempo
from engines.stylization.config import StylizationConfig
from engines.stylization.data import Windows
from engines.stylization.losses import Draws
from engines.stylization.model import Stylizer
from engines.training.devices import Share, launch, share_of
from engines.training.loop import TrainingPlan, TrainingState
from engines.training.run import CHECKPOINT, RunOptions, run

Stage = Literal["autoencoder", "regressor", "style"]
STAGES: tuple[Stage, ...] = ("autoencoder", "regressor", "style")
_PARTS: Mapping[str, tuple[str, ...]] = {
    "autoencoder": ("encoder", "decoder"), "regressor": ("regressor",),
    "style": ("content", "style", "generator", "critic"),
}  # fmt: skip
"""Networks that a stage trains."""


def fit(  # noqa: PLR0913 - what a training needs, each part but three optional
    config: StylizationConfig,
    stage: Stage,
    folder: Path,
    clips: Sequence[datasets.Clip] | None = None,
    *,
    base: Path | None = None,
    validation: Sequence[datasets.Clip] | None = None,
    seed: int = 0,
    corpora: Sequence[str] | None = None,
    plan: Mapping[str, Any] | None = None,
    device: str = "auto",
    options: RunOptions | None = None,
) -> TrainingState:
    """Train a stage, or go on with it, in `folder / stage`; stages before it must be there for `style`.

    Args:
        config: a preset; its `styles` are found in the clips if it names none.
        stage: one of `STAGES`.
        folder: of all stages.
        base: the folder of the stages before this one, where it is another.
        clips: the training split of the prepared data by default.
        validation: clips held back.
        seed: of the first weights and of everything drawn.
        corpora: of the prepared data, all by default.
        plan: fields of `TrainingPlan` other than those the config gives.
        device: auto, cpu or cuda.
        options: how the run goes.

    Raises:
        UnknownLabelError: no such stage, or nothing to train in it (the autoencoder of latent="none").
        CheckpointError: a stage before this one is missing.
    """
    if stage not in STAGES:
        raise UnknownLabelError("stage of stylization", stage, STAGES)
    if clips is None:
        clips, validation = datasets.load("train", corpora), datasets.load("val", corpora)
    styles = config.styles or tuple(sorted({clip.style for clip in clips if clip.style}))
    config = config.checked().replaced(styles=styles, pace=tempo.measured(clips, styles))
    windows = Windows(clips, config)
    torch.manual_seed(seed)
    model = Stylizer(config)
    model.mean.copy_(torch.from_numpy(np.array(windows.statistics.mean)))
    model.std.copy_(torch.from_numpy(np.array(windows.statistics.std)))
    parameters = _parameters(model, stage)
    if not parameters:
        raise UnknownLabelError("stage of these settings", stage, [s for s in STAGES if _parameters(model, s)])
    if stage == "style":
        for before in STAGES[:2]:
            if any(name.split(".")[0] in _PARTS[before] for name, _ in model.named_parameters()):
                take(model, (base or folder) / before / CHECKPOINT, _PARTS[before])
    state = TrainingState(
        model, _plan(config, stage, seed, plan or {}), groups=[{"params": parameters}],
        identity={"engine": "stylization", "stage": stage, "latent": config.latent, "styles": styles},
    )  # fmt: skip
    fabric = launch(device, state.plan.precision)
    share_of(fabric).check(config.batch_size)
    held = Windows(validation, config, windows.statistics) if validation and stage != "style" else None
    return run(
        state,
        lambda now: _terms(stage, now, windows),
        folder / stage,
        config.to_json(),
        validate=None if held is None else _validation(stage, held),
        facts={"stage": stage, "corpora": corpora and list(corpora), "clips": len(clips)},
        fabric=fabric,
        options=options or RunOptions(),
    )


def take(model: Stylizer, checkpoint: Path, parts: Sequence[str]) -> None:
    """Put networks of a stage that was trained into the model.

    Raises:
        CheckpointError: there is no such checkpoint, or it is of other sizes.
    """
    if not checkpoint.is_file():
        raise CheckpointError(f"{checkpoint}: train the stage {checkpoint.parent.name!r} first.")
    stored = torch.load(checkpoint, weights_only=True, map_location="cpu")["averaged"]
    wanted = {name: value for name, value in stored.items() if name.split(".")[0] in parts}
    try:
        model.load_state_dict(wanted, strict=False)
    except RuntimeError as error:
        raise CheckpointError(f"{checkpoint}: of other sizes: {error}") from error


def export(state: TrainingState, path: Path, which: str | None = None) -> str:
    """Write the weights (float16) of all networks but the critic, and their config; returns their SHA-256."""
    config = _model(state).config
    told = {"step": state.step, "seconds": round(state.seconds), "critic_weight": config.critic_weight}
    weights = {name: value for name, value in state.weights(which).items() if not name.startswith("critic.")}
    return weights_file.write(weights, config.replaced(critic_weight=0.0, extra=told).to_json(), path)


def read(path: Path) -> Stylizer:
    """The model of exported weights.

    Raises:
        CheckpointError: missing, damaged or of another architecture.
    """
    settings = weights_file.read_settings(path, "train them (motionloom train stylization)")
    model = Stylizer(StylizationConfig.from_json(settings))
    weights_file.fill(model, path)
    return model.eval()


def _plan(config: StylizationConfig, stage: Stage, seed: int, changes: Mapping[str, Any]) -> TrainingPlan:
    steps = {"autoencoder": config.autoencoder_steps, "regressor": config.regressor_steps, "style": config.steps}
    return TrainingPlan.of(config, seed, **{"steps": steps[stage], **changes})


def _parameters(model: Stylizer, stage: Stage) -> list[nn.Parameter]:
    """Those a stage trains; the others get no gradient."""
    for name, parameter in model.named_parameters():
        parameter.requires_grad_(name.split(".")[0] in _PARTS[stage])
    return [parameter for parameter in model.parameters() if parameter.requires_grad]


def _terms(stage: Stage, now: TrainingState, windows: Windows) -> dict[str, Tensor]:
    """Loss terms of a drawn batch; noise is drawn for the whole of it, alike in all processes."""
    model = _model(now)
    if stage == "style":
        model.encoder.eval()  # codes to be met are not made noisy by dropout
        first, second, label = windows.pairs(now.rng, now.share)
        return losses.stylization(model, first, second, label, _draws(model, len(first), now.generator, now.share))
    motion = windows.draw(now.rng, now.share)
    if stage == "regressor":
        return losses.regressor(model, motion)
    code = _code_noise(model, windows.config.batch_size, windows.config.window, now.generator)
    return losses.autoencoder(model, motion, code[now.share.rows].to(now.share.device))


def _code_noise(model: Stylizer, size: int, window: int, generator: torch.Generator) -> Tensor:
    return torch.randn(size, model.config.latent_size, window // 4, generator=generator)


def _draws(model: Stylizer, rows: int, generator: torch.Generator, share: Share) -> Draws:
    """All noise of a pass, this process's pairs of it."""
    whole = rows * share.world
    mine = torch.arange(whole).view(-1, 2)[share.rank :: share.world].reshape(-1)
    codes = [_code_noise(model, whole, model.config.window, generator)[mine].to(share.device) for _ in range(2)]
    size = model.config.style_size
    a, b, c, d, e = (torch.randn(whole, size, generator=generator)[mine].to(share.device) for _ in range(5))
    return Draws((codes[0], codes[1]), (a, b, c, d, e))


def _validation(stage: Stage, held: Windows) -> Callable[[TrainingState], Iterator[dict[str, Tensor]]]:
    def validate(now: TrainingState) -> Iterator[dict[str, Tensor]]:
        for motion in held.each(now.share):
            model = _model(now)
            yield losses.regressor(model, motion) if stage == "regressor" else losses.autoencoder(model, motion, None)

    return validate


def _model(state: TrainingState) -> Stylizer:
    assert isinstance(state.model, Stylizer)
    return state.model
