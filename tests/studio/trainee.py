"""The command line on a few made-up clips and a tiny preset, for tests that need processes of their own.

python -m tests.studio.trainee PAUSE THREADS train action2motion --run DIR ...
"""

from __future__ import annotations

import sys
import time

import torch

from engines import datasets
from engines.action2motion import config, train
from engines.datasets import Clip
from studio import cli
from tests.engines.action2motion.tiny import movement

SIZES = {
    "embed_size": 8, "generator_size": 8, "latent_size": 4, "movement_size": 4, "batch_size": 4, "window": 6,
}  # fmt: skip


def load(split: str | None = None, *_: object) -> list[Clip]:
    """Stands for `engines.datasets.load`."""
    names = ("walk", "throw", "turn left", "walk") if split != "val" else ("walk", "throw")
    return [
        Clip("formula", f"{name}-{i}", name, None, None, None, "train", movement(24, i + 10 * (split == "val")))
        for i, name in enumerate(names)
    ]


def main() -> None:
    """Run the command; each step takes `PAUSE` seconds longer than it must."""
    pause, threads, *arguments = sys.argv[1:]
    torch.set_num_threads(int(threads))
    datasets.load = load
    config.PRESETS["small"] = config.SMALL.replaced(**SIZES)
    real = train.losses

    def slow(*given):
        time.sleep(float(pause))
        return real(*given)

    train.losses = slow
    sys.argv = ["motionloom", *arguments]
    cli.main()


if __name__ == "__main__":
    main()
