"""Where training runs: one processor, one GPU, or many processes that each do their share of every batch.

Lightning Fabric places, wraps and launches; it is imported when training begins and nowhere else. Processes are started
by `torchrun` (one machine or many), which the very same command notices. The batch of the settings is that of all
processes together: everything random is drawn for the whole batch from generators that are alike everywhere, and each
process keeps every `world`-th sequence, so how many there are changes the result by rounding only.
"""

from __future__ import annotations

import logging
import os
import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from engines.errors import OutOfRangeError, UnknownLabelError

if TYPE_CHECKING:
    from lightning_fabric import Fabric

log = logging.getLogger(__name__)

_PROCESSOR = torch.device("cpu")
DEVICES = ("auto", "cpu", "cuda")
PRECISIONS = ("auto", "32", "bf16")


@dataclass(frozen=True)
class Share:
    """The part of every batch that this process does."""

    rank: int = 0
    world: int = 1
    device: torch.device = _PROCESSOR

    @property
    def rows(self) -> slice:
        """Of the whole batch; terms that begin with the first rows stay first."""
        return slice(self.rank, None, self.world)

    def count(self, total: int) -> int:
        """How many of the first `total` rows of the whole batch are this process's."""
        return len(range(self.rank, total, self.world))

    def check(self, batch_size: int) -> None:
        """Refuse a batch that cannot be shared out evenly: its means would not be those of the whole.

        Raises:
            OutOfRangeError: the batch size is no multiple of the number of processes.
        """
        if batch_size % self.world:
            raise OutOfRangeError("batch_size", batch_size, f"a multiple of {self.world}, the number of processes")


ALONE = Share()
"""One process on the processor."""


def processes() -> tuple[int, int]:
    """(rank, world) as `torchrun` set them; (0, 1) without it."""
    if "TORCHELASTIC_RUN_ID" not in os.environ:
        return 0, 1
    return int(os.environ["RANK"]), int(os.environ["WORLD_SIZE"])


@lru_cache(maxsize=4)
def launch(device: str = "auto", precision: str = "auto") -> Fabric:
    """Fabric, launched: on a GPU if there is one and in as many processes as `torchrun` started.

    Args:
        device: auto, cpu or cuda.
        precision: as `TrainingPlan.precision`.

    Raises:
        UnknownLabelError: no such device or precision.
        OutOfRangeError: cuda was asked for where there is none.
    """
    if device not in DEVICES:
        raise UnknownLabelError("device", device, DEVICES)
    if precision not in PRECISIONS:
        raise UnknownLabelError("precision", precision, PRECISIONS)
    if device == "cuda" and not torch.cuda.is_available():
        raise OutOfRangeError("device", device, "cpu or auto: this torch finds no GPU")
    from lightning_fabric import Fabric

    kind = "cuda" if device != "cpu" and torch.cuda.is_available() else "cpu"
    for name in ("lightning.fabric", "lightning_fabric"):
        logging.getLogger(name).setLevel(logging.WARNING)
    here = int(os.environ.get("LOCAL_WORLD_SIZE", "1")) if processes()[1] > 1 else 1
    fabric = Fabric(
        accelerator=kind,
        devices=here,
        num_nodes=processes()[1] // here,
        strategy=_strategy() if processes()[1] > 1 else "auto",
        precision="bf16-mixed" if _bf16(kind, precision) else "32-true",
    )
    fabric.launch()
    return fabric


def share_of(fabric: Fabric) -> Share:
    """This process's part."""
    return Share(fabric.global_rank, fabric.world_size, fabric.device)


def mean_over_processes(fabric: Fabric, values: Tensor) -> Tensor:
    """Mean of a tensor over all processes; itself where there is one."""
    if fabric.world_size == 1:
        return values
    mean = fabric.all_reduce(values, reduce_op="mean")
    assert isinstance(mean, Tensor)
    return mean


def anywhere(fabric: Fabric, here: bool) -> bool:
    """Whether it is true in any process: what all must do together is decided by this."""
    if fabric.world_size == 1:
        return here
    return bool(mean_over_processes(fabric, torch.tensor(float(here), device=fabric.device)) > 0)


def reseed(seed: int, step: int, share: Share) -> None:
    """Put torch's own generator (dropout) where it stands at a step, so that no checkpoint has to hold it."""
    mixed = (seed * 1_000_003 + step) * share.world + share.rank
    torch.default_generator.manual_seed(mixed)
    if share.device.type == "cuda":
        torch.cuda.manual_seed(mixed)


def _strategy():
    """Gradients averaged over processes; parameters that a step does not use are allowed."""
    from lightning_fabric.strategies.ddp import DDPStrategy

    warnings.filterwarnings("ignore", message="find_unused_parameters=True")
    return DDPStrategy(find_unused_parameters=True)


def _bf16(kind: str, precision: str) -> bool:
    if precision == "auto":
        return kind == "cuda" and torch.cuda.is_bf16_supported(including_emulation=False)
    if precision == "bf16" and kind == "cpu" and not _processor_has_bf16():
        log.warning("this processor has no bfloat16 units: bf16 will be slower than 32")
    return precision == "bf16"


def _processor_has_bf16() -> bool:
    found = (getattr(torch.cpu, name, None) for name in ("_is_avx512_bf16_supported", "_is_amx_tile_supported"))
    return any(ask() for ask in found if ask is not None)
