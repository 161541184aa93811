"""The Loom engine: actions, styles and sentences in, and whatever is pinned; Motions out."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from engines import actions as vocabulary
from engines import weights_file
from engines.actions import Action
from engines.errors import Cancelled, OutOfRangeError, UnknownLabelError, demand_whole
from engines.loom import output
from engines.loom.asking import Asking
from engines.loom.config import LoomConfig
from engines.loom.constraints import NOTHING, Constraints, Keep, Pin
from engines.loom.constraints import Path as FloorPath
from engines.loom.known import PARTS
from engines.loom.model import Loom
from engines.loom.passes import FPS, GUIDANCE, LOOP, How, Passes, Request
from engines.loom.plan import windows
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22
from engines.weights_file import SHIPPED

MAX_FRAMES = 12_000
"""Ten minutes."""
MAX_COUNT = 1024
_CHUNK_FRAMES = 64 * 200
"""So many frames are generated together: bounds memory, lets progress and cancel be heard."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Draw:
    """The noise behind one motion: what `interpolate` walks between."""

    action: str
    noise: Tensor
    """(T, D)."""
    frames: int
    seed: int


class LoomEngine:
    """One model, many jobs; `engines.load("loom")` makes one."""

    name = "loom"
    description = "Actions, styles, sentences, poses and paths become a motion (flow matching, our own engine)."
    licence = "CC BY-NC 4.0 (trained on Bandai-Namco clips)"
    fps = FPS
    max_frames = MAX_FRAMES
    variant = "small"
    variants = ("small",)
    capabilities = frozenset({
        "actions", "styles", "text", "interpolate", "transition", "outpaint", "constraints", "stylise", "parts",
        "scale_bones", "best_of", "guidance", "lengths",
    })  # fmt: skip

    def __init__(self, model: Loom, weights_hash: str) -> None:
        self.model = model.eval().requires_grad_(False)
        self.config: LoomConfig = model.config
        self.weights_hash = weights_hash
        self.actions: tuple[Action, ...] = tuple(vocabulary.get(name) for name in self.config.actions)
        self.styles: tuple[str, ...] = self.config.styles
        self.max_pinned_frames = self.config.longest
        self._passes = Passes(model)
        self._asking = Asking(model.config)

    # ---- what a person asks for ---------------------------------------------------------------------------

    def generate(self, action: str | None = None, frames: int | None = 60, seed: int = 0, **options: Any) -> Motion:
        """One motion; see `generate_many`."""
        return self.generate_many(action, count=1, frames=frames, seed=seed, **options)[0]

    def generate_many(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        action: str | None = None,
        count: int = 4,
        frames: int | None = 60,
        seed: int = 0,
        *,
        style: str | None = None,
        prompt: str | None = None,
        constraints: Constraints | None = None,
        guidance: float = GUIDANCE,
        steps: int = 6,
        best_of: int = 1,
        bone_scale: Mapping[str, float] | None = None,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of what is asked, in batched passes.

        Args:
            action: a name of `actions`; left out, it is read out of the prompt or left to chance. A prompt of several,
                one "then" the other, becomes all of them in turn, unless something is pinned.
            count: 1 to 1024.
            frames: 1 to 12,000 at 20 fps; None for as long as it takes, see `expected_frames`.
            seed: 0 to 2^63 - 1; the same seed gives the same motions, and motion i does not depend on `count`
                beyond rounding.
            style: a name of `styles`; left out, it is read out of the prompt.
            prompt: a sentence.
            constraints: what is pinned; all within the first 10 s, unless it is only frames to begin with.
            guidance: how strongly action, style and words are followed; 1 plainly, up to 10.
            steps: of the sampler, 1 to 100.
            best_of: so many are drawn for each that is kept, the one that is physically best; 1 to 16.
            bone_scale: joint -> factor for the bone that leads to it, "*" for all.
            progress: called with (motions done, count).
            cancel: asked between batches; stops with `Cancelled`.

        Raises:
            UnknownLabelError: an action or a style that is not known; the message lists the nearest.
            OutOfRangeError: a number is outside its range.
            MotionloomError: constraints contradict each other.
        """
        pinned = constraints or NOTHING
        most = self.config.longest - LOOP * pinned.loop
        if frames is None:
            expected = self.expected_frames(action, prompt)
            frames = min(expected, most) if pinned else expected
        demand_whole("count", count, 1, MAX_COUNT)
        demand_whole("frames", frames, 1, MAX_FRAMES)
        demand_whole("steps", steps, 1, 100)
        demand_whole("best_of", best_of, 1, 16)
        if not 0.0 <= guidance <= 10.0:
            raise OutOfRangeError("guidance", guidance, "0 to 10")
        asked = self._asking.asked(action, style, prompt, frames, apart=not pinned)
        if pinned and frames > most:
            raise OutOfRangeError(
                "frames", frames, f"up to {most} where something is pinned; go on from there after it"
            )
        how = How(guidance, steps, pinned)
        parameters = {"frames": frames, "guidance": guidance, "steps": steps, "style": style, "best_of": best_of}
        made: list[Motion] = []
        for indices in _chunks(count, frames * best_of):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {count} motions; none was kept")
            drawn = [i * best_of + k for i in indices for k in range(best_of)]
            motions, said = self._passes.perform(asked, seed, drawn, how)
            motions = output.best(motions, best_of)
            made += self._finished(
                motions, asked, seed, indices, parameters, bone_scale=bone_scale, said=said, pinned=pinned
            )
            if progress:
                progress(len(made), count)
        return made

    def transition(self, segments: Sequence[tuple[str, int]], seed: int = 0, **told: Any) -> Motion:
        """One motion that changes its action on the way, as often as one likes.

        Args:
            segments: (action, frames), in order.
            seed: as in `generate_many`.
            told: `style`, `prompt`, `guidance` or `steps`, for all of it.
        """
        if not segments:
            raise OutOfRangeError("segments", segments, "one or more (action, frames)")
        how = How(told.get("guidance", GUIDANCE), told.get("steps", 6))
        asked = []
        for action, frames in segments:
            demand_whole("frames", frames, 1, MAX_FRAMES)
            asked.append((self._asking.request(action, told.get("style"), told.get("prompt")), frames))
        demand_whole("frames", sum(frames for _, frames in asked), 1, MAX_FRAMES)
        motions, _ = self._passes.perform(asked, seed, [0], how)
        parameters = {"segments": [[name, int(frames)] for name, frames in segments], **told}
        return self._finished(motions, asked, seed, range(1), parameters)[0]

    def outpaint(  # noqa: PLR0913, PLR0917 - the request of a person, each part optional
        self,
        motion: Motion,
        action: str | None,
        keep: int = 20,
        frames: int = 60,
        count: int = 4,
        seed: int = 0,
        **told: Any,
    ) -> list[Motion]:
        """Keep the first frames of a motion and go on in different ways.

        Args:
            motion: any; it is retargeted to smpl22 and resampled to 20 fps where needed.
            action: what is to follow.
            keep: how many of its first frames stay exactly as they are; 1 up to all of them.
            frames: length of the results, more than `keep`.
            count: how many.
            seed: as in `generate_many`.
            told: `style`, `prompt`, `guidance`, `steps`.
        """
        house = motion.retarget(SMPL22).resample(FPS)
        demand_whole("keep", keep, 1, len(house))
        demand_whole("frames", frames, keep + 1, MAX_FRAMES)
        demand_whole("count", count, 1, MAX_COUNT)
        request = self._asking.request(action, told.get("style"), told.get("prompt"))
        how = How(told.get("guidance", GUIDANCE), told.get("steps", 6))
        made: list[Motion] = []
        for indices in _chunks(count, frames):
            given = [house[:keep]] * len(indices)
            motions, _ = self._passes.perform([(request, frames - keep)], seed, indices, how, given)
            made += motions
        labels = (
            Segment(0, keep, "action", house.label_at(0) or "given"),
            Segment(keep, frames, "action", request.action or request.name),
        )
        parameters = {"keep": keep, "frames": frames, "of": motion.provenance.source, **told}
        return [
            m.replaced(labels=labels, provenance=self._origin(request.name, seed, i, parameters))
            for i, m in enumerate(made)
        ]

    def latents(self, action: str, seed: int = 0, frames: int = 60, index: int = 0) -> Draw:
        """The noise that motion `index` of `generate_many(action, count, frames, seed)` begins from."""
        self._asking.request(action, None, None)
        demand_whole("frames", frames, 1, self.config.longest)
        demand_whole("index", index, 0, MAX_COUNT - 1)
        return Draw(action, self._passes.noise(seed, [index], frames)[0], frames, seed)

    def interpolate(
        self, action: str, a: Draw, b: Draw, steps: int = 5, style: str | None = None, **told: Any
    ) -> list[Motion]:
        """Motions between two draws: noise on the arc between theirs.

        Args:
            action: of the motions to make.
            a: one end; its length is that of the results.
            b: the other end, of the same length.
            steps: how many motions, both ends included; 2 to 64.
            style: a name of `styles`.
            told: `prompt`, `guidance`.
        """
        demand_whole("steps", steps, 2, 64)
        if a.noise.shape != b.noise.shape:
            raise OutOfRangeError("length of the second draw", b.frames, f"{a.frames} frames, as the first")
        request = self._asking.request(action, style, told.get("prompt"))
        share = torch.linspace(0, 1, steps)[:, None, None] * (math.pi / 2)
        # two independent normal draws are at right angles, so this keeps the length of the noise
        noise = torch.cos(share) * a.noise + torch.sin(share) * b.noise
        how = How(told.get("guidance", GUIDANCE), 6)
        (window,) = windows(self.config, [(request.action, a.frames)], again=False)
        motions, _ = self._passes.window(window, request, noise, how)
        parameters = {"frames": a.frames, "interpolate": [a.seed, b.seed], "style": style}
        return self._finished(motions, [(request, a.frames)], a.seed, range(steps), parameters)

    def stylise(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        motion: Motion,
        style: str,
        *,
        action: str | None = None,
        strength: float = 0.7,
        keep_path: bool = True,
        count: int = 1,
        seed: int = 0,
        guidance: float = GUIDANCE,
    ) -> list[Motion]:
        """The same motion in another manner.

        Args:
            motion: up to 10 s are changed at a time.
            style: a name of `styles`.
            action: what the motion shows; told by its label if there is one.
            strength: how much of it is made anew, 0 (nothing) to 1 (all).
            keep_path: the body goes where it went.
            count: how many.
            seed: as in `generate_many`.
            guidance: how strongly the style is followed.
        """
        if not 0.0 < strength <= 1.0:
            raise OutOfRangeError("strength", strength, "above 0 and up to 1")
        house = motion.retarget(SMPL22).resample(FPS)
        demand_whole("frames of the motion", len(house), 1, self.config.longest)
        shown = action or house.label_at(0)
        request = self._asking.request(shown if shown in self.config.actions else None, style, None)
        constraints = NOTHING
        if keep_path:
            line = FloorPath(house.positions[:, 0, [0, 2]], tuple(range(len(house))), recorded=True)
            constraints = Constraints(path=line) if len(house) > 1 else constraints
        how = How(guidance, 8, constraints, (self._passes.features(house), 1.0 - strength))
        motions, said = self._passes.perform([(request, len(house))], seed, range(count), how)
        parameters = {"of": motion.provenance.source, "style": style, "strength": strength, "keep_path": keep_path}
        return self._finished(
            motions, [(request, len(house))], seed, range(count), parameters, said=said, pinned=constraints
        )

    def regenerate(
        self,
        motion: Motion,
        parts: Sequence[str],
        action: str | None = None,
        count: int = 4,
        seed: int = 0,
        **told: Any,
    ) -> list[Motion]:
        """New movement of some parts of the body; the others stay.

        Args:
            motion: up to 10 s.
            parts: to be made anew, of `PARTS`.
            action: what they do.
            count: how many.
            seed: as in `generate_many`.
            told: as in `generate_many`.
        """
        for part in parts:
            if part not in PARTS:
                raise UnknownLabelError("part of the body", part, PARTS)
        free = {joint for part in parts for joint in PARTS[part]}
        kept = tuple(name for name, joints in PARTS.items() if not free & set(joints))
        if not kept:
            raise OutOfRangeError("parts", list(parts), "fewer, so that something is left to keep")
        house = motion.retarget(SMPL22).resample(FPS)
        constraints = Constraints(kept=(Keep(house, 0, kept),))
        return self.generate_many(action, count, len(house), seed, constraints=constraints, **told)

    def understood(self, prompt: str) -> str:
        """What is made of a prompt, a sentence or two for the person who typed it; nothing of an empty one."""
        return self._asking.understood(prompt)

    def expected_frames(self, action: str | None = None, prompt: str | None = None) -> int:
        """How long a motion of that is where nobody says it: as long as such clips usually are.

        What goes on for as long as one likes (walking) is 5 s at most.

        Raises:
            UnknownLabelError: the action is not known.
            OutOfRangeError: the prompt is too long.
        """
        return self._asking.expected_frames(action, prompt)

    # ---- how it is made ---------------------------------------------------------------------------------------

    def _finished(  # noqa: PLR0913 - what goes into labels and provenance
        self,
        motions: Sequence[Motion],
        segments: Sequence[tuple[Request, int]],
        seed: int,
        indices: Sequence[int],
        parameters: Mapping[str, Any],
        *,
        bone_scale: Mapping[str, float] | None = None,
        said: Sequence[str] = (),
        pinned: Constraints = NOTHING,
    ) -> list[Motion]:
        """With labels and provenance."""
        labels = output.labels(segments, pinned, FPS)
        name = " > ".join(request.name for request, _ in segments)
        made = []
        for index, motion in zip(indices, motions, strict=True):
            told = {key: value for key, value in parameters.items() if value is not None}
            missed = [*said, *output.unmet(motion, pinned)]
            if missed:
                told["unmet"] = missed
            if bone_scale:
                told["bone_scale"] = dict(bone_scale)
            done = motion.replaced(labels=labels, provenance=self._origin(name, seed, index, told))
            made.append(done.scale_bones(bone_scale) if bone_scale else done)
        return made

    def _origin(self, name: str, seed: int, index: int, parameters: Mapping[str, Any]) -> Provenance:
        return Provenance(self.name, self.weights_hash, name, seed, index, dict(parameters))


def load(variant: str = "small", checkpoint: str | Path | None = None) -> LoomEngine:
    """The engine with shipped weights, or with a checkpoint.

    Args:
        variant: small.
        checkpoint: weights written by `motionloom train loom` (.safetensors with its .json beside it).

    Raises:
        UnknownLabelError: no such variant.
        CheckpointError: the file is missing, damaged or of another architecture.
    """
    if variant != "small":
        raise UnknownLabelError("variant of loom", variant, ("small",))
    path = Path(checkpoint) if checkpoint else SHIPPED / "loom.safetensors"
    settings = weights_file.read_settings(path, "train them (motionloom train loom)")
    model = Loom(LoomConfig.from_json(settings))
    weights_file.fill(model, path)
    return LoomEngine(model, hashlib.sha256(path.read_bytes()).hexdigest())


def _chunks(count: int, frames: int) -> Iterator[range]:
    """Indices of `count` motions of so many frames, as many at a time as are made together."""
    size = max(1, _CHUNK_FRAMES // min(frames, 200))
    for start in range(0, count, size):
        yield range(start, min(count, start + size))


__all__ = ["Constraints", "FloorPath", "Keep", "LoomEngine", "Pin", "load"]
