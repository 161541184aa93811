"""Write the model card and the picture of all actions for a shipped Action2Motion.

    python scripts/model_card.py VARIANT [--run DIR] [--reads a,b] [--limits TEXT]

Needs the prepared data (motionloom data prepare) for the held-out figures. What a picture shows a person has to judge:
`--reads` takes the actions that were looked at and clearly look like what they are, `--limits` what else was seen.
Both are kept in the settings beside the weights. `--run` is the training's folder, for the curves of its losses.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from engines import datasets, load
from engines.action2motion.assess import Assessment, assess
from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.engine import WEIGHTS, Action2MotionEngine
from engines.motion import Motion
from viewers import strips
from viewers.camera import Camera
from viewers.moderngl_renderer import Renderer

ROOT = Path(__file__).resolve().parent.parent
POSES, WIDE, HIGH, COLUMNS = 7, 84, 112, 2


def sheet(engine: Action2MotionEngine, path: Path, seed: int = 1, frames: int = 60) -> None:
    """Draw a strip of poses of every action from the shipped weights; nothing is picked."""
    names = engine.config.actions
    rows = -(-len(names) // COLUMNS)
    picture = Image.new("RGB", (COLUMNS * POSES * WIDE, rows * HIGH), "black")
    pen = ImageDraw.Draw(picture)
    with Renderer(WIDE, HIGH) as renderer:
        for i, name in enumerate(names):
            x, y = (i // rows) * POSES * WIDE, (i % rows) * HIGH
            motion = engine.generate(name, frames=frames, seed=seed)
            for k, pose in enumerate(poses(renderer, motion)):
                picture.paste(Image.fromarray(pose), (x + k * WIDE, y))
            pen.text((x + 4, y + 3), name, fill="white")
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(path, quality=70)


def poses(renderer: Renderer, motion: Motion) -> list[np.ndarray]:
    """A motion as `POSES` pictures, seen from a little above and to the side, all motions from as far."""
    camera = Camera(yaw=0.6, pitch=0.12, distance=4.6, target=(0.0, 0.95, 0.0), fov=0.5)
    return strips.poses(renderer, motion, strips.spread(motion, POSES), camera=camera)


def card(engine: Action2MotionEngine, found: Assessment, reads: list[str], picture: str) -> str:
    """The card as Markdown."""
    config, extra = engine.config, dict(engine.config.extra)
    rows = "\n".join(
        f"| {label} | {found.generated[key]} | {found.real[key]} |"
        for key, label in (
            ("foot_skate", "foot skate, m/s"),
            ("jitter", "jitter, m/s³"),
            ("ground_penetration", "ground penetration, m"),
            ("floating", "feet above the floor, m"),
        )
    )
    order = sorted(config.actions, key=lambda name: -found.recognised[name])
    recognised = ", ".join(f"{name} {found.recognised[name]:.0%}" for name in order)
    weight = f"KL weight to {config.kl_weight[1]:g}"
    steps = int(extra.get("step", 0))
    minutes = float(extra.get("seconds", 0)) / 60
    mine, theirs = (np.mean(list(share.values())) for share in (found.recognised, found.real_recognised))
    others = [name for name in config.actions if name not in reads]
    return f"""# Action2Motion, {engine.variant}

**Licence: CC BY-NC 4.0**, since most of the training clips are Bandai-Namco's (attribution: Kobayashi et al. 2023).
Retrain without them for weights of your own. SHA-256 `{engine.weights_hash}`.

| | |
|---|---|
| method | conditional temporal VAE, pose decoder `{config.decoder}` (Guo et al. 2020; thesis section 3.2.1) |
| settings | the `.json` beside the weights: generator {config.generator_size}, {config.fps:g} fps, {weight} |
| data | Bandai-Namco Motiondataset 1 and 2, CMU subset (free), UTD-MHAD (research use; cite Chen et al. 2015) |
| split | by clip, seeded; UTD by subject (6 validation, 7 test); only the training split, mirrored where sides allow |
| training | {steps:,} steps of {config.batch_size} windows of {config.window} frames, {minutes:.0f} minutes |
| notes | {extra.get("notes", "none")} |

## Held-out figures

`python scripts/model_card.py {engine.variant}`; means with 95 % intervals. Generated: {len(config.actions)} actions,
10 draws each, 60 frames. Real: the first 60 frames of the test clips.

| | generated | real |
|---|---|---|
{rows}

Taken for the action asked for by the shipped recogniser (`evaluator-action.md`): generated {mine:.0%} (mean over
actions), the first 3 s of held-out real clips {theirs:.0%}. Reconstruction of held-out clips, latents from the
posterior, teacher-forced: {found.joint_error_cm:.1f} cm a joint; {found.kl_nats:.2f} nats a frame between posterior and
prior. The papers' whole table: `motionloom evaluate action2motion:all --out report/`.

By action: {recognised}.

## Losses

{losses(extra)}

## What it looks like

![every action](../../{picture})

Looked at and clearly what they are: {", ".join(reads) or "none yet"}.

Do not read, or only at times: {", ".join(others)}.

## Limits

{extra.get("limits", "")} Actions with one to three clips in the data (kick, respond, wash, slash, beckon) cannot be
more than echoes of these clips. Kinect actions (UTD-MHAD) carry the sensor's noise; many are one raised arm to the eye.
"""


def losses(extra: Mapping[str, Any]) -> str:
    """The last mean of every term, and the curves where they were drawn."""
    last = extra.get("losses")
    if not last:
        return "Not recorded."
    terms = ", ".join(f"{name} {value:.3g}" for name, value in last["terms"].items())
    curves = f"\n\n![losses over steps](../../{last['picture']})" if "picture" in last else ""
    return f"Weighted terms, mean of the last {last['steps']} steps: {terms}.{curves}"


def ours(report: str) -> str:
    """Of a report the table and its notes, without title and the papers' figures."""
    return report.partition("\n")[2].partition("## The papers")[0].strip()


def keep_looks(extra: dict[str, Any], reads: str | None, limits: str | None) -> None:
    """Keep what a person saw in pictures: what reads, comma-separated, and what falls short; what is not said stays."""
    if reads is not None:
        extra["reads"] = [name.strip() for name in reads.split(",") if name.strip()]
    if limits is not None:
        extra["limits"] = limits


def curves(run: Path, path: Path) -> dict[str, Any]:
    """Draw the history of a training; its last line as what the card keeps."""
    from matplotlib import pyplot

    history = json.loads((run / "history.json").read_text())
    names = [name for name in history[-1] if name not in {"step", "seconds"}]
    figure, axes = pyplot.subplots(figsize=(7, 3.2))
    for name in names:
        axes.plot([line["step"] for line in history], [line.get(name) for line in history], label=name)
    axes.set(yscale="log", xlabel="step", ylabel="weighted term")
    axes.legend(ncols=3, fontsize=8, frameon=False)
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    steps = history[-1]["step"] - history[-2]["step"]
    return {"terms": {name: history[-1][name] for name in names}, "steps": steps}


def main() -> None:
    """Assess, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("variant")
    parser.add_argument("--reads", default=None, help="actions that read, comma-separated")
    parser.add_argument("--limits", default=None, help="what falls short, in sentences")
    parser.add_argument("--run", type=Path, default=None, help="folder of the training, for its losses")
    options = parser.parse_args()
    engine = load("action2motion", variant=options.variant)
    picture = f"docs/actions-{options.variant}.webp"
    sheet(engine, ROOT / picture)
    settings = WEIGHTS / f"action2motion-{options.variant}.json"
    stored = json.loads(settings.read_text())
    keep_looks(stored["extra"], options.reads, options.limits)
    if options.run is not None:
        drawn = f"docs/losses-{options.variant}.webp"
        stored["extra"]["losses"] = curves(options.run, ROOT / drawn) | {"picture": drawn}
    settings.write_text(json.dumps(stored, indent=1) + "\n")
    engine.config = Action2MotionConfig.from_json(settings.read_text())
    found = assess(engine, datasets.load("test"), draws=10)
    text = card(engine, found, stored["extra"].get("reads", []), picture)
    (WEIGHTS / f"action2motion-{options.variant}.md").write_text(text)


if __name__ == "__main__":
    main()
