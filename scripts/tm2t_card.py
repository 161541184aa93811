"""Write the model card of the shipped TM2T weights, and the sheet of prompts.

    python scripts/tm2t_card.py [--runs DIR] [--table DIR] [--notes TEXT] [--reads a,b] [--limits TEXT]

Needs the prepared data (motionloom data prepare). `--runs` has the folders vq, m2t and t2m of the trainings, for their
losses; `--table` is a folder that `motionloom evaluate tm2t` wrote; `--notes` says how the weights came about;
`--reads` takes the prompts that were looked at in the sheet and are what they say, `--limits` what else was seen. All
of it is kept in the settings beside the weights.
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
from engines.datasets.captions import encoded
from engines.tm2t.assess import Assessment, assess
from engines.tm2t.config import STAGES
from engines.tm2t.engine import TM2TEngine
from engines.weights_file import SHIPPED

ROOT = Path(__file__).resolve().parent.parent
SHEET = "docs/prompts-tm2t.webp"
PROMPTS = (
    "a person walks forward", "someone runs", "a person waves the right hand", "an old person walks slowly",
    "a person raises both hands", "she bows", "a person sits down", "a person throws a ball",
    "walk forward then turn left", "a person jumps", "he boxes with both fists", "a person squats down",
)  # fmt: skip
"""Of the sheet."""
LISTED = 20
"""Captions shown beside those of people."""


def card(engine: TM2TEngine, found: Assessment) -> str:
    """The card as Markdown."""
    config, extra = engine.config, dict(engine.config.extra)
    stages = ", ".join(
        f"{name} {extra[f'{name}_step']:,} steps ({extra[f'{name}_seconds'] / 60:.0f} min)"
        for name in ("vq", "m2t", "t2m")
        if f"{name}_step" in extra
    )
    rows = "\n".join(f"| {name} | {back} | {real} |" for name, back, real in _figures(found))
    listed = "\n".join(
        f"| {one.clip} | {one.human} | {one.made} | {one.fit:.2f} ({one.human_fit:.2f}) |"
        for one in found.captions[:LISTED]
    )
    fit, human = (float(np.mean([getattr(one, key) for one in found.captions])) for key in ("fit", "human_fit"))
    return f"""# TM2T, small

**Licence: CC BY-NC 4.0**, since most of the training clips are Bandai-Namco's (attribution: Kobayashi et al. 2023).
Retrain without them for weights of your own. SHA-256 `{engine.weights_hash}`.

| | |
|---|---|
| method | motion tokens, motion to text, text to motion (Guo et al. 2022; thesis, chapter 6) |
| parts | {", ".join(config.parts)} |
| settings | the `.json` beside the weights |
| data | Bandai-Namco Motiondataset 1 and 2, CMU subset (free), UTD-MHAD (research use; cite Chen et al. 2015) |
| captions | of the project's grammar from measured facts, people's own; tokens' vectors of all-MiniLM-L6-v2 |
| split | by clip, seeded; UTD by subject; only the training split, and its mirror images |
| training | {stages}; one core, bfloat16 |
| notes | {extra.get("notes", "none")} |

## Motion tokens, there and back

`python scripts/tm2t_card.py`, {found.clips} held-out clips, of at most {config.longest} frames. They use {found.codes}
of the {config.codes} tokens.

| | after tokens and back | real |
|---|---|---|
{rows}

Clips that are recognised only before: {_lost(found)}.

## Motion to text

How well a sentence fits its clip, by `evaluator-text.md`: {fit:.2f} on average, sentences of the data {human:.2f}.

| clip | a sentence of the data | made | fits (that of the data) |
|---|---|---|---|
{listed}

## Text to motion

{_text2motion(found)}

First draw of seed 1, nothing picked:

![prompts](../../{SHEET})

Looked at and what they say: {", ".join(extra.get("reads", [])) or "none yet"}.

{extra.get("table", "Not measured.")}

## Losses

{_curves(extra)}

## Limits

{extra.get("limits", "")} Most captions of the data come from a grammar, so those that are made sound like it.
"""


def _lost(found: Assessment) -> str:
    worst = sorted(((lost, name, count) for name, (lost, count) in found.lost.items() if lost), reverse=True)
    return ", ".join(f"{name} {lost} of {count}" for lost, name, count in worst) or "none"


def _curves(extra: dict[str, Any]) -> str:
    told = extra.get("losses", {})
    return "\n\n".join(f"{stage}: {losses({'losses': found})}" for stage, found in told.items()) or "Not recorded."


def _text2motion(found: Assessment) -> str:
    if not found.prompts:
        return "Not trained yet: the weights describe motions and do not make any."
    wrong = [f"“{a.prompt}” (seen: {', '.join(sorted(set(a.seen)))})" for a in found.prompts if a.share < 0.5]
    right = np.mean([answer.share for answer in found.prompts])
    return (
        f"Of four motions of each of the sixty prompts (`engines/evaluation/prompts.py`) {right:.0%} are recognised as "
        f"what was asked.\nNot: {'; '.join(wrong) or 'none'}."
    )


def _figures(found: Assessment) -> list[tuple[str, str, str]]:
    names = {"foot_skate": ("foot skate, m/s", ".3f"), "jitter": ("jitter, m/s³", ".0f"),
             "ground_penetration": ("ground penetration, m", ".4f")}  # fmt: skip
    physics = [
        (name, format(found.physics[key][0], form), format(found.physics[key][1], form))
        for key, (name, form) in names.items()
    ]
    back, real = found.recognised
    return [
        ("distance of a joint, seen from the root, cm", f"{100 * found.error:.1f}", "0"),
        ("recognised as its action", f"{back:.1%}", f"{real:.1%}"),
        *physics,
    ]


def main() -> None:
    """Judge the shipped weights and write the card beside them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=Path, help="folder of the trainings, for their losses")
    parser.add_argument("--table", type=Path, help="folder of a report")
    parser.add_argument("--notes", help="how the weights came about, in sentences")
    parser.add_argument("--reads", help="prompts of the sheet that read, comma-separated")
    parser.add_argument("--limits", help="what falls short, in sentences")
    options = parser.parse_args()
    path = SHIPPED / "tm2t.safetensors"
    settings = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    extra = settings["extra"]
    keep_looks(extra, options.reads, options.limits)
    if options.notes is not None:
        extra["notes"] = options.notes
    if options.table is not None:
        extra["table"] = ours((options.table / "table.md").read_text(encoding="utf-8"))
    if options.runs is not None:
        drawn = {stage: f"docs/losses-tm2t-{stage}.webp" for stage in STAGES}
        extra["losses"] = {
            stage: curves(options.runs / stage, ROOT / path) | {"picture": path} for stage, path in drawn.items()
        }
    path.with_suffix(".json").write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
    engine = load("tm2t")
    if "text2motion" in engine.config.parts:
        sheet([(prompt, engine.generate(prompt, seed=1)) for prompt in PROMPTS], ROOT / SHEET)
    told = encoded.load()
    clips = [c for split in ("val", "test") for c in datasets.load(split) if c.action and len(c.motion) >= 20]
    sentences = [told.sentences[int(told.of(clip)[0])] for clip in clips]
    path.with_suffix(".md").write_text(card(engine, assess(engine, clips, sentences)), encoding="utf-8")


if __name__ == "__main__":
    main()
