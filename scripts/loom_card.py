"""Write Loom's model card and the pictures of all actions and styles.

    python scripts/loom_card.py [--run DIR] [--table DIR] [--reads a,b] [--limits TEXT] [--draws N]

Needs the prepared data (motionloom data prepare) for the held-out figures. What a picture shows a person has to judge:
`--reads` takes the actions and styles that were looked at and are what they say, `--limits` what else was seen. Both
are kept in the settings beside the weights. `--run` is the training's folder, for the curves of its losses; `--table`
is a folder that `motionloom evaluate loom action2motion:all` wrote.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from model_card import POSES, curves, keep_looks, losses, ours, poses
from PIL import Image, ImageDraw

from engines import datasets, load
from engines.loom.assess import Assessment, assess
from engines.loom.engine import LoomEngine
from engines.motion import Motion
from engines.weights_file import SHIPPED
from viewers.moderngl_renderer import Renderer

ROOT = Path(__file__).resolve().parent.parent
WIDE, HIGH, COLUMNS = 84, 112, 2
STYLED = ("walk", "raise right hand", "run")
"""Actions shown in every style that is known of them."""


def sheet(rows: list[tuple[str, Motion]], path: Path) -> None:
    """Draw a strip of poses of every motion; nothing is picked."""
    high = -(-len(rows) // COLUMNS)
    picture = Image.new("RGB", (COLUMNS * POSES * WIDE, high * HIGH), "black")
    pen = ImageDraw.Draw(picture)
    with Renderer(WIDE, HIGH) as renderer:
        for i, (name, motion) in enumerate(rows):
            x, y = (i // high) * POSES * WIDE, (i % high) * HIGH
            for k, pose in enumerate(poses(renderer, motion)):
                picture.paste(Image.fromarray(pose), (x + k * WIDE, y))
            pen.text((x + 4, y + 3), f"{name}, {motion.duration:.1f} s", fill="white")
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(path, quality=70)


def actions(engine: LoomEngine) -> list[tuple[str, Motion]]:
    """Every action, as long as it usually is, the first draw of seed 1."""
    lengths = dict(zip(engine.config.actions, engine.config.usual_frames, strict=True))
    return [(a, engine.generate(a, frames=min(lengths[a][1], engine.config.longest), seed=1)) for a in lengths]


def styles(engine: LoomEngine) -> list[tuple[str, Motion]]:
    """Some actions in every style."""
    return [
        (f"{action}, {style}", engine.generate(action, frames=70, seed=1, style=style))
        for action in STYLED
        for style in engine.styles
    ]


def card(engine: LoomEngine, found: Assessment) -> str:
    """The card as Markdown."""
    config, extra = engine.config, dict(engine.config.extra)
    answers = [*found.prompts, *found.more]
    right, more = ([answer.share for answer in group] for group in (found.prompts, found.more))
    wrong = [f"“{a.prompt}” (seen: {', '.join(sorted(set(a.seen)))})" for a in answers if a.share < 0.5]
    seldom = [name for name in config.actions if name not in found.held]
    often = np.mean([share for name, share in found.by_action.items() if name in found.held])
    rows = "\n".join(f"| {name} | {ours} | {real} |" for name, ours, real in _figures(found))
    by_action = ", ".join(f"{name} {share:.0%}" for name, share in sorted(found.by_action.items(), key=lambda x: -x[1]))
    by_style = ", ".join(f"{name} {share:.0%}" for name, share in sorted(found.by_style.items(), key=lambda x: -x[1]))
    others = [name for name in (*config.actions, *config.styles) if name not in extra.get("reads", [])]
    return f"""# Loom, small

**Licence: CC BY-NC 4.0**, since most of the training clips are Bandai-Namco's (attribution: Kobayashi et al. 2023).
Retrain without them for weights of your own. SHA-256 `{engine.weights_hash}`.

| | |
|---|---|
| method | rectified flow over whole motions, transformer with adaptive layer norm ({config.depth} x {config.width}) |
| settings | the `.json` beside the weights |
| data | Bandai-Namco Motiondataset 1 and 2, CMU subset (free), UTD-MHAD (research use; cite Chen et al. 2015) |
| captions | of the project's grammar from measured facts, people's own, everyday requests; encoder all-MiniLM-L6-v2 |
| split | by clip, seeded; UTD by subject (6 validation, 7 test); only the training split, and its mirror images |
| training | {extra.get("step", 0):,} steps of {config.batch_size} windows, {extra.get("seconds", 0) / 60:.0f} minutes |
| notes | {extra.get("notes", "none")} |

## Held-out figures

`python scripts/loom_card.py`. Recognisers: `evaluator-*.md`. Real: validation and test clips.

| | generated | real |
|---|---|---|
{rows}

Of the actions that have held-out clips {often:.1%} are recognised on average; without: {", ".join(seldom)}.

Sentences as people type them (`engines/evaluation/prompts.py`): {np.mean(right):.0%} of four motions of each of the
sixty are recognised as what was asked; {np.mean(more):.0%} of two motions of each of {len(more)} by another writer
(`prompts_more.py`). What a sentence asks for is read first (`prompt-reader.md`), whose thresholds were
chosen with both lists in sight.
Not: {"; ".join(wrong) or "none"}.

By action: {by_action}.

By style: {by_style}.

## Beside the published engines

`motionloom evaluate loom action2motion:all --repeats 20 --motions 500 --out report/`

{extra.get("table", "Not measured.")}

## Losses

{losses(extra)}

## What it looks like

![every action](../../docs/actions-loom.webp)

![styles](../../docs/styles-loom.webp)

Looked at and clearly what they are: {", ".join(extra.get("reads", [])) or "none yet"}.

Do not read, or only at times: {", ".join(others)}.

## Limits

{extra.get("limits", "")} Actions with one to three clips in the data (kick, respond, wash, slash, beckon) cannot be
more than echoes of these clips. Kinect actions (UTD-MHAD) carry the sensor's noise; many are one raised arm to the eye.
"""


def _figures(found: Assessment) -> list[tuple[str, str, str]]:
    def row(name: str, pair: tuple[float, float], form: str) -> tuple[str, str, str]:
        return name, format(pair[0], form), format(pair[1], form)

    return [
        *(row(f"recognised, {corpus} actions", pair, ".1%") for corpus, pair in found.accuracy.items()),
        row("style recognised", found.styles, ".1%"),
        row("FID to held-out clips (real: of training clips)", found.fid, ".2f"),
        row("multimodality", found.multimodality, ".2f"),
        row("foot skate, m/s", found.physics["foot_skate"], ".3f"),
        row("jitter, m/s³", found.physics["jitter"], ".0f"),
        row("ground penetration, m", found.physics["ground_penetration"], ".4f"),
        row("nearest training clip of the action, cm a joint", found.nearest, ".1f"),
    ]


def main() -> None:
    """Assess, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reads", default=None, help="actions and styles that read, comma-separated")
    parser.add_argument("--limits", default=None, help="what falls short, in sentences")
    parser.add_argument("--run", type=Path, default=None, help="folder of the training, for its losses")
    parser.add_argument("--table", type=Path, default=None, help="folder of a report")
    parser.add_argument("--draws", type=int, default=8, help="motions an action")
    options = parser.parse_args()
    settings = SHIPPED / "loom.json"
    stored = json.loads(settings.read_text())
    keep_looks(stored["extra"], options.reads, options.limits)
    if options.table is not None:
        stored["extra"]["table"] = ours((options.table / "table.md").read_text())
    if options.run is not None:
        drawn = "docs/losses-loom.webp"
        stored["extra"]["losses"] = curves(options.run, ROOT / drawn) | {"picture": drawn}
    settings.write_text(json.dumps(stored, indent=1) + "\n")
    engine = load("loom")
    sheet(actions(engine), ROOT / "docs/actions-loom.webp")
    sheet(styles(engine), ROOT / "docs/styles-loom.webp")
    found = assess(engine, datasets.load(), draws=options.draws)
    (SHIPPED / "loom.md").write_text(card(engine, found))


if __name__ == "__main__":
    main()
