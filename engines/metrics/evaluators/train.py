"""Train a recogniser on the real clips, and measure it on those held out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from engines import actions as vocabulary
from engines import weights_file
from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.geometry.mirror import mirror_words
from engines.metrics.evaluators.recogniser import Recogniser, RecogniserConfig, RecogniserNet, Task
from engines.metrics.evaluators.trunk import BONES, CHANNELS, HANDS, describe, quickened
from engines.training.loop import TrainingPlan, TrainingState, train

WINDOW = 100
"""Frames of a training window, 5 seconds."""
STYLED = "bandai-namco"
"""The corpus whose clips have styles; its actions are the contents."""


def label_of(clip: Clip, task: Task) -> str | None:
    """What a clip shows for a task; None: nothing, it is not used."""
    if task == "action":
        return clip.action
    if clip.corpus != STYLED:
        return None
    return clip.action if task == "content" else clip.style


class Windows:
    """Clips as descriptions, drawn as windows at varied speed; mirrored where sides allow, with the label's side."""

    def __init__(self, clips: Sequence[Clip], task: Task, labels: Sequence[str] = ()) -> None:
        rows, names = [], []
        for clip in clips:
            name = label_of(clip, task)
            if name is None:
                continue
            rows.append(describe(clip.motion, hands=True))
            names.append(name)
            mirrored = name if task == "style" else mirror_words(name)
            if task == "style" or vocabulary.get(name).mirrors:
                rows.append(describe(clip.motion.mirror(), hands=True))
                names.append(mirrored)
        if not rows:
            raise MotionloomError(f"no clip has a label for the task {task!r}; prepare data that does.")
        self.labels = tuple(labels) or tuple(sorted(set(names)))
        self.rows = rows
        self.names = np.array([self.labels.index(name) for name in names])
        weight = np.bincount(self.names, minlength=len(self.labels))[self.names] ** -0.5
        self.probability = weight / weight.sum()

    def draw(self, rng: np.random.Generator, size: int) -> tuple[Tensor, Tensor, Tensor]:
        """Frames (B, T, C), mask (B, T) and labels (B,)."""
        picks = rng.choice(len(self.rows), size=size, p=self.probability)
        made = [self._window(self.rows[pick], rng) for pick in picks]
        frames = np.stack([frames for frames, _ in made])
        # other people hold their limbs a little differently, and every camera trembles
        for part in (slice(0, BONES), slice(CHANNELS, CHANNELS + HANDS)):
            frames[..., part] += rng.normal(scale=0.05, size=(size, 1, part.stop - part.start))
        frames += rng.normal(scale=0.01, size=frames.shape)
        mask = np.arange(WINDOW) < np.array([there for _, there in made])[:, None]
        return torch.from_numpy(frames), torch.from_numpy(mask), torch.from_numpy(self.names[picks])

    def _window(self, row: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, int]:
        """A stretch of a clip at another speed, mostly all of a short one: (WINDOW, C), and how many frames it has."""
        speed = rng.uniform(0.85, 1.18)
        there = min(WINDOW, int((len(row) - 1) / speed) + 1)
        if rng.random() < 0.5 and there > 30:
            there = int(rng.integers(max(30, int(0.7 * there)), there + 1))
        start = rng.uniform(0, max(1e-6, len(row) - 1 - speed * (there - 1)))
        at = np.clip(start + speed * np.minimum(np.arange(WINDOW), there - 1), 0, len(row) - 1)
        low = at.astype(int)
        share = (at - low)[:, None].astype(np.float32)
        made = (1 - share) * row[low] + share * row[np.minimum(low + 1, len(row) - 1)]
        return quickened(made, speed), there


def fit(  # noqa: PLR0913, PLR0917 - what a training needs, each part but two optional
    config: RecogniserConfig,
    clips: Sequence[Clip],
    checkpoint: Path | None = None,
    seed: int = 0,
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Recogniser:
    """Train on clips (the training split); goes on where there is a checkpoint."""
    windows = Windows(clips, config.task)
    config = replace(config, labels=windows.labels)
    torch.manual_seed(seed)
    net = RecogniserNet(config)
    net.scale_to(windows.rows)
    state = TrainingState(net, TrainingPlan.of(config, seed, final_learning_rate=1e-5, average=0.995))
    if checkpoint and checkpoint.exists():
        state.restore(checkpoint)

    def losses(now: TrainingState) -> dict[str, Tensor]:
        frames, mask, labels = windows.draw(now.rng, config.batch_size)
        torch.manual_seed(int(now.rng.integers(2**31)))  # of the dropout, so that resuming is exact
        logits, _ = now.model.train()(frames, mask)
        return {"entropy": nn.functional.cross_entropy(logits, labels, label_smoothing=config.smoothing)}

    train(state, losses, checkpoint, progress, cancel)
    net.load_state_dict(state.averaged)
    return Recogniser(net)


def accuracy(recogniser: Recogniser, clips: Sequence[Clip]) -> dict[str, tuple[float, int]]:
    """Corpus -> share of its labelled clips that are recognised, and how many there are; "all" as well, if any."""
    task = recogniser.config.task
    known = [(clip, label_of(clip, task)) for clip in clips]
    known = [(clip, name) for clip, name in known if name in recogniser.labels]
    if not known:
        return {}
    said = recogniser.recognise([clip.motion for clip, _ in known])
    right: dict[str, list[bool]] = {}
    for (clip, name), answer in zip(known, said, strict=True):
        for corpus in (clip.corpus, "all"):
            right.setdefault(corpus, []).append(answer == name)
    return {corpus: (float(np.mean(found)), len(found)) for corpus, found in right.items()}


def export(recogniser: Recogniser, path: Path, **notes: object) -> None:
    """Weights (float16; running statistics float32) and settings beside each other."""
    settings = replace(recogniser.config, extra=dict(notes)).to_json()
    weights_file.write(recogniser.net.state_dict(), settings, path)
