"""What a training is at a step, and its checkpoint: everything that going on as if nothing had happened needs."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from engines.errors import CheckpointError, FormatError
from engines.training.devices import ALONE, Share
from engines.training.files import write_beside
from engines.training.plan import TrainingPlan
from engines.training.schedules import Curriculum

_DAMAGED = (
    UnpicklingError,
    OSError,
    RuntimeError,
    KeyError,
    TypeError,
    EOFError,
    ValueError,
    IndexError,
    AttributeError,
)


@dataclass
class TrainingState:
    """Everything that resuming needs.

    Args:
        model: with its first weights.
        plan: how long and how fast.
        groups: parameter groups of the optimiser, whose entry `scale` multiplies the learning rate; all parameters
            alike if None.
        identity: what a checkpoint must agree in to be gone on from, such as the decoder and the vocabulary.
        curricula: by name; they hear every validation.
    """

    model: nn.Module
    plan: TrainingPlan
    groups: Sequence[dict[str, Any]] | None = None
    identity: dict[str, Any] = field(default_factory=dict)
    curricula: dict[str, Curriculum] = field(default_factory=dict)
    step: int = 0
    seconds: float = 0.0
    history: list[dict[str, float]] = field(default_factory=list)
    """A line each `log_every` steps: step, seconds, learning_rate, gradient_norm, every term (means since the last)."""
    validation: list[dict[str, float]] = field(default_factory=list)
    """A line a validation: step, seconds, total, every term."""
    best: dict[str, Tensor] = field(default_factory=dict)
    """Averaged weights of the best validation."""
    best_total: float = math.inf
    best_step: int = 0
    stale: int = 0
    """Validations since the best one."""
    sums: dict[str, float] = field(default_factory=dict)
    """Of what is logged, since the last line."""
    counted: int = 0
    share: Share = ALONE
    """Which part of every batch this process does, and where."""

    def __post_init__(self) -> None:
        kind = {"adam": torch.optim.Adam, "adamw": torch.optim.AdamW}[self.plan.optimiser]
        groups = [{"scale": 1.0, **group} for group in self.groups or [{"params": list(self.model.parameters())}]]
        self.optimiser = kind(groups, lr=self.plan.learning_rate, weight_decay=self.plan.weight_decay, fused=True)
        self.rng = np.random.default_rng(self.plan.seed)
        self.generator = torch.Generator().manual_seed(self.plan.seed)
        self.averaged = {name: value.detach().clone() for name, value in self.model.state_dict().items()}

    @property
    def finished(self) -> bool:
        """The last step is done, or validation has stopped getting better."""
        return self.step >= self.plan.steps or bool(self.plan.patience and self.stale >= self.plan.patience)

    def learning_rate(self) -> float:
        """Of the coming step."""
        return self.plan.rate(self.step)

    def weights(self, which: str | None = None) -> dict[str, Tensor]:
        """The weights to be used: `best` by validation or the `last` averaged ones.

        If neither is said, the best where the training was to stop early, for then the end is past the best; else the
        last, for which the learning rate has come down.
        """
        which = which or ("best" if self.plan.patience else "last")
        return self.best if which == "best" and self.best else self.averaged

    def average(self) -> None:
        """Take the weights into their moving average; early steps count less so that the start is forgotten."""
        decay = min(self.plan.average, (1 + self.step) / (10 + self.step))
        with torch.no_grad():
            for name, value in self.model.state_dict().items():
                if value.dtype.is_floating_point:
                    self.averaged[name].lerp_(value, 1 - decay)
                else:
                    self.averaged[name].copy_(value)

    def judge(self, terms: Mapping[str, float]) -> None:
        """Take note of a validation: keep the averaged weights if they are the best, let curricula move on."""
        total = sum(terms.values())
        self.validation.append({"step": self.step, "seconds": round(self.seconds, 1), "total": total, **terms})
        if total < self.best_total:
            self.best_total, self.best_step, self.stale = total, self.step, 0
            self.best = {name: value.clone() for name, value in self.averaged.items()}
        else:
            self.stale += 1
        moved_on = [curriculum.validated(terms) for curriculum in self.curricula.values()]  # each must hear of it
        if any(moved_on):
            self.best_total, self.stale = math.inf, 0  # another task: what was reached before says nothing of it

    def to(self, share: Share) -> None:
        """Do this share of every batch, and move everything to its device."""
        moved, self.share = share.device != self.share.device, share
        if not moved:
            return
        self.model.to(share.device)
        self.averaged = {name: value.to(share.device) for name, value in self.averaged.items()}
        self.best = {name: value.to(share.device) for name, value in self.best.items()}
        self.optimiser.load_state_dict(self.optimiser.state_dict())  # which brings the moments to the parameters

    def save(self, path: Path) -> None:
        """Write the checkpoint beside the old one and put it in its place.

        Raises:
            CheckpointError: it cannot be written; the old one stands.
        """
        rest = {
            "rng": self.rng.bit_generator.state,
            "curricula": {name: curriculum.state() for name, curriculum in self.curricula.items()},
            "best_total": None if math.isinf(self.best_total) else self.best_total,
            "plan": asdict(self.plan),
            **{name: getattr(self, name) for name in (*_REQUIRED, *_ADDED)},
        }
        content = {
            "model": self.model.state_dict(),
            "averaged": self.averaged,
            "best": self.best,
            "optimiser": self.optimiser.state_dict(),
            "generator": self.generator.get_state(),
            "rest": json.dumps(rest),
        }
        buffer = io.BytesIO()
        torch.save(content, buffer)
        try:
            write_beside(path, buffer.getvalue(), durable=True)
        except FormatError as error:
            there = "the last one written stands and can be gone on from" if path.exists() else "none was written yet"
            raise CheckpointError(
                f"{path}: the checkpoint of step {self.step} {error.problem} Of checkpoints, {there}."
            ) from error

    def restore(self, path: Path) -> None:
        """Go on from a checkpoint written by `save`, also by earlier versions of it.

        Raises:
            CheckpointError: the file is missing, damaged, or of another model or vocabulary; nothing was changed if it
                is of another vocabulary.
        """
        try:
            stored = torch.load(path, weights_only=True, map_location="cpu")
            rest = json.loads(stored["rest"])
            self._check(path, rest.get("identity", {}))
            self.model.load_state_dict(stored["model"])
            options = [_options(group) for group in self.optimiser.param_groups]
            self.optimiser.load_state_dict(stored["optimiser"])
            for group, option in zip(self.optimiser.param_groups, options, strict=True):
                group.update(option)  # rates and decay are the plan's, which may have changed; moments the checkpoint's
            for name, value in self.averaged.items():
                value.copy_(stored["averaged"][name])
            self.generator.set_state(stored["generator"])
            self.rng.bit_generator.state = rest["rng"]
            for name in _REQUIRED:
                setattr(self, name, rest[name])
        except _DAMAGED as error:
            reason = " ".join(str(error).split())[:300]
            raise CheckpointError(f"{path}: cannot resume from this checkpoint: {reason}") from error
        self._restore_rest(stored.get("best", {}), rest)

    def _restore_rest(self, best: dict[str, Tensor], rest: dict[str, Any]) -> None:
        """What checkpoints did not always hold."""
        self.best = {name: value.to(self.share.device) for name, value in best.items()}
        self.best_total = math.inf if rest.get("best_total") is None else rest["best_total"]
        for name in _ADDED:
            setattr(self, name, rest.get(name, getattr(self, name)))
        for name, state in rest.get("curricula", {}).items():
            if name in self.curricula:
                self.curricula[name].restore(state)
        self.plan = replace(self.plan, seed=rest.get("plan", {}).get("seed", self.plan.seed))

    def _check(self, path: Path, identity: Mapping[str, Any]) -> None:
        """Refuse the checkpoint of another training."""
        ours = json.loads(json.dumps(self.identity))
        for name in identity.keys() & ours.keys():
            if identity[name] != ours[name]:
                raise CheckpointError(
                    f"{path}: cannot resume: {_difference(name, identity[name], ours[name])}; "
                    "begin anew (--fresh) or in another folder."
                )


_REQUIRED = ("step", "seconds", "history")
_ADDED = ("validation", "best_step", "stale", "sums", "counted", "identity")


def _options(group: Mapping[str, Any]) -> dict[str, Any]:
    """What a parameter group says besides which parameters are in it."""
    return {name: value for name, value in group.items() if name != "params"}


def _difference(name: str, theirs: Any, ours: Any) -> str:
    """What differs, in as few words as it takes."""
    if isinstance(theirs, list) and isinstance(ours, list):
        gone, new = ([str(v) for v in a if v not in b] for a, b in ((theirs, ours), (ours, theirs)))
        changes = [f"{word} {', '.join(some[:5])}" for word, some in (("without", gone), ("with", new)) if some]
        return f"{name} are now {' and '.join(changes) or 'in another order'}"
    return f"{name} was {theirs!r} and is now {ours!r}"
