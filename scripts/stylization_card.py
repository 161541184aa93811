"""Write the model card of shipped stylization weights, and the sheet of a walk, a run and a wave in seven styles.

    python scripts/stylization_card.py VARIANT [--run DIR] [--tables DIR ...] [--reads a,b] [--limits TEXT]

Needs the prepared data (motionloom data prepare). `--tables` are folders that `motionloom evaluate` wrote with the
protocol `styles`; `--run` is the training's folder, for its losses; `--reads` takes what was looked at in the sheet and
is what it says, `--limits` what else was seen. All of it is kept in the settings beside the weights.
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
from engines.geometry.cleanup import plant_feet
from engines.metrics import physical
from engines.motion import Motion
from engines.stylization.engine import StylizationEngine
from engines.weights_file import SHIPPED

ROOT = Path(__file__).resolve().parent.parent
CONTENTS = ("walk", "run", "wave right hand")
STYLES = ("active", "elderly", "exhausted", "feminine", "giant", "masculine", "proud")
LOOKED_AT = 200
"""Stylised motions whose feet are measured."""
FEET = ("foot_skate", "contact_skate", "jitter", "ground_penetration")


def contents(clips: list[Clip]) -> list[Clip]:
    """The first held-out clip of each content, in the normal style."""
    return [next(c for c in clips if c.action == name and c.style == "normal") for name in CONTENTS]


def rows(engine: StylizationEngine, clips: list[Clip], given: list[Clip]) -> list[tuple[str, Motion]]:
    """Each content as it was and in each style: by label, or without labels by a clip that has the style."""
    found = []
    for clip in contents(clips):
        motion = clip.motion[:120].face_front()
        found.append((f"{clip.action}, as recorded", motion))
        for style in STYLES:
            if engine.styles:
                made = engine.stylise(motion, style, seed=1)
            else:
                like = next(c for c in given if c.style == style and c.action in ("walk", clip.action))
                made = engine.stylise(motion, like=like.motion, seed=1)
            found.append((f"{clip.action}, {style}", made[0]))
    return found


def feet(engine: StylizationEngine, clips: list[Clip]) -> dict[str, dict[str, float]]:
    """Physical measures of held-out motions, of what is made of them, and of that with feet held."""
    rng = np.random.default_rng(0)
    seen: dict[str, list[dict[str, float]]] = {"given": [], "stylised": [], "feet held": []}
    for k in range(LOOKED_AT):
        motion = clips[int(rng.integers(len(clips)))].motion[:160].face_front().resample(engine.fps)
        style = engine.styles[k % len(engine.styles)] if engine.styles else None
        made = engine.stylise(motion, style, seed=k)[0]
        for name, each in {"given": motion, "stylised": made, "feet held": plant_feet(made)}.items():
            seen[name].append(physical.table(each))
    return {name: {key: float(np.mean([m[key] for m in all_])) for key in FEET} for name, all_ in seen.items()}


def card(engine: StylizationEngine, extra: dict[str, Any], found: dict[str, dict[str, float]]) -> str:
    """The card as Markdown."""
    config = engine.config
    label = "labels told" if config.supervised else "without labels"
    body = "\n".join(f"| {name} | " + " | ".join(f"{m[key]:.3g}" for key in FEET) + " |" for name, m in found.items())
    tables = "\n\n".join(extra.get("tables", [])) or "Not measured."
    weights = f"cycle {config.cycle_weight:g}, KL {config.kl_weight:g}, homo-style {config.hsa_weight:g}"
    minutes = extra.get("seconds", 0) / 60
    critic = f"; a critic of styles, weight {extra['critic_weight']:g}" if extra.get("critic_weight") else ""
    ours = f"pairs share a style and not a recording{critic}; what the content code loses is kept"
    return f"""# Generative stylization, {engine.variant}

**Licence: CC BY-NC 4.0**, since the styled clips are Bandai-Namco's (attribution: Kobayashi et al. 2023). Retrain
without them for weights of your own. SHA-256 `{engine.weights_hash}`.

| | |
|---|---|
| method | latent stylization (thesis chapter 5), latent space `{config.latent}`, {label}; {weights} |
| not the thesis's | {ours} |
| settings | the `.json` beside the weights |
| data | autoencoder and regressor: Bandai-Namco 1 and 2, CMU subset, UTD-MHAD; styles: Bandai-Namco only |
| split | by clip, seeded; UTD by subject; only the training split, and its mirror images |
| training | style stage {extra.get("step", 0):,} steps of {config.batch_size} pairs, {minutes:.0f} min on one core |
| styles | {", ".join(config.styles)} |

## Held-out figures

Recognisers: `evaluator-style.md`, `evaluator-content.md`; means with 95 % intervals. Styles are asked for evenly, of
any content; ten of them have one or two clips of a content in the data, and most pairs of style and content none.

{tables}

## Feet

`python scripts/stylization_card.py {engine.variant}`: {LOOKED_AT} held-out Bandai-Namco clips at 30 fps, styles in
turn. Feet held: the clean-up of the Style tab (`engines.geometry.cleanup`).

| | foot skate, cm/s | contact skate, cm/s | jitter, m/s³ | penetration, cm |
|---|---|---|---|---|
{body}

## Losses

{losses(extra)}

## What it looks like

Held-out clips of the normal style, first draw of seed 1, nothing picked:

![a walk, a run and a wave in seven styles](../../docs/styles-stylization-{engine.variant}.webp)

Looked at and what they are: {", ".join(extra.get("reads", [])) or "none yet"}.

## Limits

{extra.get("limits", "")}
"""


def main() -> None:
    """Look, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("variant")
    parser.add_argument("--run", type=Path, help="folder of the training, for its losses")
    parser.add_argument("--tables", type=Path, nargs="*", help="folders of reports")
    parser.add_argument("--reads", help="what reads in the sheet, comma-separated")
    parser.add_argument("--limits", help="what falls short, in sentences")
    options = parser.parse_args()
    settings = SHIPPED / f"stylization-{options.variant}.json"
    stored = json.loads(settings.read_text())
    extra = stored["extra"]
    keep_looks(extra, options.reads, options.limits)
    if options.tables:
        extra["tables"] = [ours((folder / "table.md").read_text()) for folder in options.tables]
    if options.run is not None:
        drawn = f"docs/losses-stylization-{options.variant}.webp"
        extra["losses"] = curves(options.run / "style", ROOT / drawn) | {"picture": drawn}
    settings.write_text(json.dumps(stored, indent=1) + "\n")
    engine = load("stylization", variant=options.variant)
    held = [clip for split in ("val", "test") for clip in datasets.load(split, ["bandai-namco"]) if clip.style]
    given = [] if engine.styles else datasets.load("train", ["bandai-namco"])
    sheet(rows(engine, held, given), ROOT / f"docs/styles-stylization-{options.variant}.webp")
    (SHIPPED / f"stylization-{options.variant}.md").write_text(card(engine, extra, feet(engine, held)))


if __name__ == "__main__":
    main()
