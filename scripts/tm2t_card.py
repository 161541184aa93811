"""Write the model card of the shipped TM2T weights.

    python scripts/tm2t_card.py [--limits TEXT] [--table DIR]

Needs the prepared data (motionloom data prepare). `--limits` says what was seen beside the figures, `--table` is a
folder that `motionloom evaluate tm2t` wrote; both are kept in the settings beside the weights.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from model_card import keep_looks

from engines import datasets, load
from engines.datasets.captions import encoded
from engines.tm2t.assess import Assessment, assess
from engines.tm2t.engine import TM2TEngine
from engines.weights_file import SHIPPED

ROOT = Path(__file__).resolve().parent.parent
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
| training | {stages} |

## Motion tokens, there and back

`python scripts/tm2t_card.py`, {found.clips} held-out clips, of at most {config.longest} frames. They use {found.codes}
of the {config.codes} tokens.

| | after tokens and back | real |
|---|---|---|
{rows}

The tokenizer's loss has a term for movement that the thesis has not (`movement_weight`): with it 76 % of 160 clips were
recognised after 1,200 steps, without it 66 %, and jitter was 66 m/s³ beside 112 (real 70).

## Motion to text

How well a sentence fits its clip, by `evaluator-text.md`: {fit:.2f} on average, sentences of the data {human:.2f}.

| clip | a sentence of the data | made | fits (that of the data) |
|---|---|---|---|
{listed}

## Text to motion

{_text2motion(found)}

{extra.get("table", "")}

## Limits

{extra.get("limits", "")} Most captions of the data come from a grammar, so those that are made sound like it.
"""


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
    parser.add_argument("--limits")
    parser.add_argument("--table", type=Path)
    options = parser.parse_args()
    path = SHIPPED / "tm2t.safetensors"
    settings = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    keep_looks(settings["extra"], None, options.limits)
    if options.table:
        settings["extra"]["table"] = (options.table / "table.md").read_text(encoding="utf-8")
    path.with_suffix(".json").write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
    engine = load("tm2t")
    told = encoded.load()
    clips = [c for split in ("val", "test") for c in datasets.load(split) if c.action and len(c.motion) >= 20]
    sentences = [told.sentences[int(told.of(clip)[0])] for clip in clips]
    path.with_suffix(".md").write_text(card(engine, assess(engine, clips, sentences)), encoding="utf-8")


if __name__ == "__main__":
    main()
