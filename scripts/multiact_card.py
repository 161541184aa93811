"""Write the model card of the shipped MultiAct weights, and the sheet of transitions.

    python scripts/multiact_card.py [--run DIR] [--table DIR] [--speed TEXT] [--reads a,b] [--limits TEXT]

Needs the prepared data (motionloom data prepare). `--table` is a folder that `motionloom evaluate multiact` wrote;
`--run` is the training's folder, for its losses; `--speed` what benchmarks/multiact.py measured; `--reads` takes what
was looked at in the sheet and is what it says, `--limits` what else was seen. All of it is kept in the settings beside
the weights.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from loom_card import sheet
from model_card import curves, keep_looks, losses, ours

from engines import datasets, load
from engines.datasets import Clip
from engines.metrics import physical
from engines.motion import Motion
from engines.multiact.engine import MultiActEngine
from engines.skeletons import SMPL22
from engines.weights_file import SHIPPED

ROOT = Path(__file__).resolve().parent.parent
SHEET, CURVES = "docs/transitions-multiact.webp", "docs/losses-multiact.webp"
PAIRS = (
    ("walk", "wave right hand"), ("wave right hand", "walk"), ("walk", "run"), ("run", "walk"), ("walk", "sit down"),
    ("sit down", "stand up"), ("stand up", "walk"), ("walk", "jump"), ("jump", "bow"), ("bow", "turn left"),
    ("turn left", "walk"), ("walk", "squat"), ("squat", "throw"), ("throw", "clap"), ("run", "dash"),
    ("walk backward", "raise both hands"),
)  # fmt: skip
"""Transitions of the sheet."""
CYCLES = ("walk", "run", "walk backward", "jog in place", "walk in place")
"""Actions that go on as long as they are asked to."""
LASTING = 10.0
"""Seconds they are asked for."""
DRAWS = 16
_ANKLES = [SMPL22.index(f"{side}_ankle") for side in ("left", "right")]


def rows(engine: MultiActEngine) -> list[tuple[str, Motion]]:
    """The first draw of seed 1 of every pair, nothing picked, and a walk of ten seconds."""
    known = {action.name for action in engine.actions}
    pairs = [pair for pair in PAIRS if known.issuperset(pair)]
    made = [(" > ".join(pair), engine.sequence([(name, 2.5) for name in pair], seed=1)) for pair in pairs]
    return [*made, *((f"{name}, {LASTING:g} s", engine.sequence([(name, LASTING)], seed=1)) for name in CYCLES)]


def strides(motion: Motion) -> float:
    """How often a second one foot passes the other, across or up: the pace of the legs."""
    left, right = (motion.positions[:, joint] for joint in _ANKLES)
    apart = (left - right) - (left - right).mean(axis=0)
    main = np.linalg.svd(apart, full_matrices=False)[2][0]
    along = apart @ main
    return float((np.diff(np.sign(along)) != 0).sum() / motion.duration)


def cycles(engine: MultiActEngine, clips: list[Clip]) -> list[str]:
    """Rows of a table: the legs at the beginning and at the end of ten seconds, and those of real clips."""
    found, part = [], round(3 * engine.fps)
    for name in CYCLES:
        made = [engine.sequence([(name, LASTING)], seed=seed) for seed in range(DRAWS)]
        real = [clip.motion for clip in clips if clip.action == name and clip.motion.duration >= 1.5]
        held = f"{np.mean([strides(m) for m in real]):.2f}" if real else "none held out"
        first, last = (np.mean([strides(m[rows]) for m in made]) for rows in (slice(None, part), slice(-part, None)))
        still = np.mean([strides(m[-part:]) < 0.5 for m in made])
        skate = 100 * np.mean([physical.foot_skate(m) for m in made])
        found.append(f"| {name} | {first:.2f} | {last:.2f} | {held} | {still:.0%} | {skate:.1f} |")
    return found


def card(engine: MultiActEngine, config: dict[str, Any], cyclic: list[str]) -> str:
    """The card as Markdown."""
    extra = config["extra"]
    layers = f"{config['encoder_layers']} and {config['decoder_layers']} layers of {config['width']}"
    minutes = extra.get("seconds", 0) / 60
    lines = "\n".join(cyclic)
    return f"""# MultiAct

**Licence: CC BY-NC 4.0**, since most of the training clips are Bandai-Namco's (attribution: Kobayashi et al. 2023).
Retrain without them for weights of your own. SHA-256 `{engine.weights_hash}`.

| | |
|---|---|
| method | MACVAE and recurrent generation (Lee et al. 2023); {layers} |
| not the paper's | joints for vertices, free nats, losses on movement and standing feet (ARCHITECTURE.md) |
| settings | the `.json` beside the weights |
| data | triplets cut from and joined of Bandai-Namco 1 and 2, CMU subset and UTD-MHAD clips (`triplets.py`) |
| split | by clip, seeded; UTD by subject; only the training split, and its mirror images |
| training | {extra.get("step", 0):,} steps of {config["batch_size"]} triplets, {minutes:.0f} min on one core |
| actions | {len(engine.actions)} |

## Against the simple ways

Twenty actions in a row, drawn at random (`motionloom evaluate multiact`); means with 95 % intervals.

{extra.get("table", "Not measured.")}

## Actions that go on

`python scripts/multiact_card.py`: {DRAWS} draws of {LASTING:g} s each. How often a second one foot passes the other, in
the first and the last three seconds, and in held-out clips; draws whose legs stood still at the end.

| | first 3 s | last 3 s | real | stand still | foot skate, cm/s |
|---|---|---|---|---|---|
{lines}

## Speed

`OMP_NUM_THREADS=1 python benchmarks/multiact.py 1`: {extra.get("speed", "not measured.")}

## Losses

{losses(extra)}

## What it looks like

First draw of seed 1, nothing picked:

![transitions](../../{SHEET})

Looked at and what they are: {", ".join(extra.get("reads", [])) or "none yet"}.

## Limits

{extra.get("limits", "")}
"""


def main() -> None:
    """Look, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, help="folder of the training, for its losses")
    parser.add_argument("--table", type=Path, help="folder of a report")
    parser.add_argument("--speed", help="what the benchmark measured, and on what, in sentences")
    parser.add_argument("--reads", help="what reads in the sheet, comma-separated")
    parser.add_argument("--limits", help="what falls short, in sentences")
    options = parser.parse_args()
    settings = SHIPPED / "multiact.json"
    config = json.loads(settings.read_text())
    extra = config["extra"]
    keep_looks(extra, options.reads, options.limits)
    if options.speed is not None:
        extra["speed"] = options.speed
    if options.table is not None:
        extra["table"] = ours((options.table / "table.md").read_text())
    if options.run is not None:
        extra["losses"] = curves(options.run, ROOT / CURVES) | {"picture": CURVES}
    settings.write_text(json.dumps(config, indent=1) + "\n")
    engine = load("multiact")
    held = [clip for split in ("val", "test") for clip in datasets.load(split)]
    sheet(rows(engine), ROOT / SHEET)
    (SHIPPED / "multiact.md").write_text(card(engine, config, cycles(engine, held)))


if __name__ == "__main__":
    main()
