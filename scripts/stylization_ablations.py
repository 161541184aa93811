"""Train and judge stylization without its parts, as the thesis's tables 5.2 and 5.6 do.

    python scripts/stylization_ablations.py --run RUN --out DIR [--steps N] [--repeats N] [--motions N] [--only a,b]

RUN is the folder of a training whose autoencoder and regressor all settings share. Every setting gets the same number
of steps, fewer than the shipped weights had; what is in DIR already is not trained again, and a training or a table
that was stopped goes on. Writes DIR/supervised and DIR/unsupervised, reports of `motionloom evaluate`.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engines.stylization import train
from engines.stylization.config import StylizationConfig, preset

SETTINGS: Mapping[str, tuple[bool, dict[str, Any]]] = {
    "s": (True, {}),
    "s-no-critic": (True, {"critic_weight": 0.0}),
    "s-no-latent": (True, {"latent": "none"}),
    "s-no-regressor": (True, {"regressor": ()}),
    "s-hsa-0": (True, {"hsa_weight": 0.0}),
    "s-hsa-0.1": (True, {"hsa_weight": 0.1}),
    "s-kl-0.01": (True, {"kl_weight": 0.01}),
    "s-cyc-0": (True, {"cycle_weight": 0.0}),
    "s-cyc-1": (True, {"cycle_weight": 1.0}),
    "u": (False, {}),
    "u-no-latent": (False, {"latent": "none"}),
    "u-hsa-0": (False, {"hsa_weight": 0.0}),
    "u-kl-0.1": (False, {"kl_weight": 0.1}),
    "u-cyc-0": (False, {"cycle_weight": 0.0}),
}
"""Name -> whether labels are told, and what differs from the preset that ships."""


def config(name: str, steps: int) -> StylizationConfig:
    """The settings of a row."""
    supervised, changes = SETTINGS[name]
    return preset("small", supervised).replaced(steps=steps, **changes)


def trained(name: str, run: Path, out: Path, steps: int) -> Path:
    """Weights of a row, trained if they are not there."""
    weights = out / f"{name}.safetensors"
    if not weights.is_file():
        train.export(train.fit(config(name, steps), "style", out / name, base=run), weights)
    return weights


def main() -> None:
    """Train what is missing, then judge: labels by their names, the unsupervised by motions."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=1500)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--motions", type=int, default=200)
    parser.add_argument("--only", default=",".join(SETTINGS))
    options = parser.parse_args()
    names = options.only.split(",")
    weights = {name: trained(name, options.run, options.out, options.steps) for name in names}
    for supervised, way in ((True, "label"), (False, "motion")):
        chosen = [f"stylization:ae@{weights[name]}" for name in names if SETTINGS[name][0] == supervised]
        if chosen:
            folder = options.out / ("supervised" if supervised else "unsupervised")
            counts = ["--repeats", str(options.repeats), "--motions", str(options.motions)]
            command = [sys.executable, "-m", "studio.cli", "evaluate", *chosen, "--protocol", "styles", "--by", way]
            subprocess.run([*command, *counts, "--out", str(folder)], check=True)


if __name__ == "__main__":
    main()
