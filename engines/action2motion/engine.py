"""The Action2Motion engine: an action's name in, Motions out."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from engines import actions as vocabulary
from engines.action2motion.config import DECODERS, Action2MotionConfig, Decoder
from engines.action2motion.model import Action2Motion
from engines.action2motion.output import Upsampler, to_motions
from engines.action2motion.plan import HOUSE_FPS, Plan
from engines.action2motion.representation import encode
from engines.actions import Action
from engines.errors import Cancelled, MotionloomError, OutOfRangeError, UnknownLabelError, demand_whole
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22
from engines.weights_file import fill, read_settings

WEIGHTS = Path(__file__).resolve().parent.parent / "weights"
MAX_FRAMES = 12_000
"""Ten minutes."""
MAX_COUNT = 1024
_CHUNK = 320
"""At most so many motions are generated together: lets progress and cancel be heard."""
_CHUNK_FRAMES = 64 * 600
"""And of long ones so many that they have no more frames than this: bounds memory."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Latents:
    """The draw behind one motion: what `interpolate` walks between."""

    action: str
    values: Tensor
    """(T, Z) latents of the model's frames."""
    frames: int
    """Length of the motion at the house rate."""
    seed: int


class Action2MotionEngine:
    """Generates, interpolates, changes action, goes on from a start; `engines.load("action2motion")` makes one."""

    name = "action2motion"
    description = "An action's name becomes a motion (temporal VAE with a learned prior, Guo et al. 2020)."
    licence = "CC BY-NC 4.0 (trained on Bandai-Namco clips)"
    fps = HOUSE_FPS
    max_frames = MAX_FRAMES
    capabilities = frozenset({"actions", "interpolate", "transition", "outpaint", "scale_bones", "variants"})

    def __init__(self, model: Action2Motion, weights_hash: str) -> None:
        self.model = model.eval()
        self.config: Action2MotionConfig = model.config
        self.variant = self.config.decoder
        self.variants = shipped_variants()
        self.weights_hash = weights_hash
        self.actions: tuple[Action, ...] = tuple(vocabulary.get(name) for name in self.config.actions)

    # ---- what a person asks for ---------------------------------------------------------------------------

    def generate(self, action: str, frames: int = 60, seed: int = 0, **options: Any) -> Motion:
        """One motion of an action; see `generate_many`."""
        return self.generate_many(action, count=1, frames=frames, seed=seed, **options)[0]

    def generate_many(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        action: str,
        count: int = 4,
        frames: int = 60,
        seed: int = 0,
        *,
        bone_scale: Mapping[str, float] | None = None,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of one action, in batched passes.

        Args:
            action: a name of `actions`.
            count: 1 to 1024.
            frames: 1 to 12,000 at 20 fps.
            seed: 0 to 2^63 - 1; the same seed gives the same motions, and motion i does not depend on `count`
                beyond rounding.
            bone_scale: joint -> factor for the bone that leads to it (body scale), "*" for all.
            progress: called with (motions done, count).
            cancel: asked between batches; stops with `Cancelled`.

        Raises:
            UnknownLabelError: the action is not known; the message lists the nearest.
            OutOfRangeError: a number is outside its range.
        """
        label = self._label(action)
        demand_whole("count", count, 1, MAX_COUNT)
        plan = self._plan([(label, frames)])
        parameters: dict[str, Any] = {"variant": self.variant, "frames": plan.frames}
        if bone_scale:
            parameters["bone_scale"] = dict(bone_scale)
        made: list[Motion] = []
        for indices in _chunks(count, plan.frames):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {count} motions; none was kept")
            hidden, _ = self._sample(plan, self._noise(seed, indices, plan.steps))
            motions = self._motions(hidden, plan)
            made += self._finished(motions, plan, seed, indices, parameters, bone_scale=bone_scale)
            if progress:
                progress(len(made), count)
        return made

    def latents(self, action: str, seed: int = 0, frames: int = 60, index: int = 0) -> Latents:
        """The latents that motion `index` of `generate_many(action, count, frames, seed)` draws."""
        demand_whole("index", index, 0, MAX_COUNT - 1)
        plan = self._plan([(self._label(action), frames)])
        _, drawn = self._sample(plan, self._noise(seed, [index], plan.steps))
        return Latents(plan.name, drawn[:, 0], frames, seed)

    def interpolate(self, action: str, a: Latents, b: Latents, steps: int = 5, whole: bool = True) -> list[Motion]:
        """Motions between two draws of an action (thesis, motion interpolation).

        Args:
            action: of the motions to make, mostly that of `a` and `b`.
            a: one end; its length is the length of the results.
            b: the other end, of the same length.
            steps: how many motions, both ends included; 2 to 64.
            whole: walk between the latents of every frame, or (False) only between those of the first pose, the
                rest being drawn from the prior with the seed of `a`.
        """
        demand_whole("steps", steps, 2, 64)
        if a.values.shape != b.values.shape:
            raise OutOfRangeError("length of the second latents", b.frames, f"{a.frames} frames, as the first")
        plan = self._plan([(self._label(action), a.frames)])
        share = torch.linspace(0, 1, steps)[None, :, None]
        between = _spherical(a.values[:, None], b.values[:, None], share)
        if whole:
            hidden = self._replay(plan, between)
        else:
            noise = self._noise(a.seed, [0] * steps, plan.steps)
            hidden, _ = self._sample(plan, torch.cat([self._noise_of(plan, between[:1]), noise[1:]]))
        parameters = {"variant": self.variant, "frames": a.frames, "interpolate": [a.seed, b.seed], "whole": whole}
        motions = self._motions(hidden, plan)
        return self._finished(motions, plan, a.seed, range(steps), parameters)

    def transition(self, segments: Sequence[tuple[str, int]], seed: int = 0) -> Motion:
        """One motion that changes its action on the way, as often as one likes (thesis, action transition).

        Args:
            segments: (action, frames), in order; the label fed to the networks switches at each boundary while
                their memory goes on.
            seed: as in `generate_many`.
        """
        if not segments:
            raise OutOfRangeError("segments", segments, "one or more (action, frames)")
        plan = self._plan([(self._label(action), frames) for action, frames in segments])
        hidden, _ = self._sample(plan, self._noise(seed, range(1), plan.steps))
        parameters = {"variant": self.variant, "segments": [[name, int(frames)] for name, frames in segments]}
        return self._finished(self._motions(hidden, plan), plan, seed, range(1), parameters)[0]

    def outpaint(  # noqa: PLR0913, PLR0917 - the request of a person, each part optional
        self, motion: Motion, action: str, keep: int = 20, frames: int = 60, count: int = 4, seed: int = 0
    ) -> list[Motion]:
        """Keep the first frames of a motion and go on in different ways (thesis, motion outpainting).

        Args:
            motion: any; it is retargeted to smpl22 and resampled to 20 fps where needed.
            action: what is to follow.
            keep: how many of its first frames stay exactly as they are; 1 up to all of them.
            frames: length of the results, more than `keep`.
            count: how many.
            seed: as in `generate_many`.
        """
        if self.variant == "plain":
            raise MotionloomError("the plain variant has no rotations to go on from; outpaint with 'glmi-m' or 'lie'")
        house = motion.retarget(SMPL22).resample(HOUSE_FPS)
        demand_whole("keep", keep, 1, len(house))
        demand_whole("frames", frames, keep + 1, MAX_FRAMES)
        demand_whole("count", count, 1, MAX_COUNT)
        plan = self._plan([(self._label(action), frames)])
        stride = round(HOUSE_FPS / self.config.fps)
        # the model's frames end on the last kept one, so that what follows sets in right after it
        offset = (keep - 1) % stride
        shown = house[offset:keep:stride]
        features = encode(shown)
        given = torch.from_numpy(np.concatenate([features.height, features.lie.reshape(len(shown), -1)], axis=-1))
        plan = plan.until(len(shown) + -(-(frames - keep) // stride) + 1)
        begin = (len(shown) - 1) * stride
        results = []
        for indices in _chunks(count, frames):
            start = given[:, None].expand(-1, len(indices), -1)
            noise = self._noise(seed, indices, plan.steps)
            hidden, _ = self._sample(plan, noise, start)
            for whole in self._motions(hidden, plan, start):
                results.append(_join(house[:keep], whole[begin : begin + frames - keep + 1]))
        labels = (Segment(0, keep, "action", house.label_at(0) or "given"), Segment(keep, frames, "action", plan.name))
        parameters = {"variant": self.variant, "keep": keep, "frames": frames, "of": motion.provenance.source}
        return self._finished(results, plan, seed, range(count), parameters, labels=labels)

    # ---- how it is made ---------------------------------------------------------------------------------------

    def _label(self, action: str) -> int:
        cleaned = " ".join(str(action).lower().split())
        if cleaned not in self.config.actions:
            raise UnknownLabelError("action", action, self.config.actions)
        return self.config.actions.index(cleaned)

    def _plan(self, parts: Sequence[tuple[int, int]]) -> Plan:
        for _, frames in parts:
            demand_whole("frames", frames, 1, MAX_FRAMES)
        total = sum(frames for _, frames in parts)
        demand_whole("frames", total, 1, MAX_FRAMES)
        return Plan(self.config, tuple((label, int(frames)) for label, frames in parts))

    def _conditions(self, plan: Plan, count: int) -> Tensor:
        labels = torch.nn.functional.one_hot(plan.labels, len(self.config.actions)).float()
        parts = torch.cat([labels, plan.progress[:, None]], dim=-1) if self.config.time_counter else labels
        return parts[:, None].expand(-1, count, -1)

    def _noise(self, seed: int, indices: Sequence[int], steps: int) -> Tensor:
        """(T, B, Z) standard normal, each motion's from its own stream."""
        demand_whole("seed", seed, 0, 2**63 - 1)
        draws = []
        for index in indices:
            generator = torch.Generator().manual_seed((seed * 1_000_003 + index) % 2**63)
            draws.append(torch.randn(steps, self.config.latent_size, generator=generator))
        return torch.stack(draws, dim=1)

    def _sample(self, plan: Plan, noise: Tensor, given: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Hidden (T, B, H) and latents (T, B, Z) of draws from the prior; `given` (K, B, D) poses begin them."""
        conditions = self._conditions(plan, noise.shape[1])
        drawn = []

        def run(rows: list[int], start: Tensor | None) -> Tensor:
            hidden, latents = self.model.sample(conditions[rows], noise[rows], start)
            drawn.append(latents)
            return hidden

        hidden = self._performed(plan, run, given)
        return hidden, torch.cat([drawn[0], *(latents[1:] for latents in drawn[1:])])

    def _replay(self, plan: Plan, latents: Tensor) -> Tensor:
        """Hidden (T, B, H) for latents (T, B, Z) chosen beforehand."""
        conditions = self._conditions(plan, latents.shape[1])
        return self._performed(plan, lambda rows, start: self.model.replay(conditions[rows], latents[rows], start))

    def _performed(
        self, plan: Plan, run: Callable[[list[int], Tensor | None], Tensor], given: Tensor | None = None
    ) -> Tensor:
        """Hidden (T, B, H) of a plan, performance by performance.

        An action that is done again begins again, with the pose the last performance ended in for its first: the
        networks' memory would otherwise hold them at its end, as nothing they were trained on begins again.
        """
        hidden: list[Tensor] = []
        with torch.inference_mode():
            for part in plan.performances:
                if hidden:
                    again = run([part.start, *part], self.model.head(hidden[-1][-1:]))
                    hidden.append(again[1:])
                else:
                    hidden.append(run(list(part), given))
        return torch.cat(hidden)

    def _noise_of(self, plan: Plan, first: Tensor) -> Tensor:
        """The draw (1, B, Z) that makes the prior give a latent (1, B, Z) for the first frame."""
        known = self._conditions(plan, first.shape[1])[:1]
        nothing = torch.zeros_like(self.model.pose_mean).expand(1, first.shape[1], -1)
        with torch.inference_mode():
            mu, logvar, _, _ = self.model.prior(torch.cat([nothing, known], dim=-1))
            return (first - mu) * torch.exp(-0.5 * logvar)

    def _motions(self, hidden: Tensor, plan: Plan, given: Tensor | None = None) -> list[Motion]:
        """Motions at the house rate from the generator's hidden vectors (T, B, H)."""
        upsampler = Upsampler(plan.steps, self.config.fps, HOUSE_FPS, plan.frames)
        made: list[Motion] = []
        for rows in _chunks(hidden.shape[1], plan.frames):
            part = slice(rows.start, rows.stop)
            with torch.inference_mode():
                poses = self.model.decode(hidden[:, part], given=None if given is None else given[:, part])
            made += to_motions(poses, upsampler)
        return made

    def _finished(  # noqa: PLR0913 - what goes into the provenance
        self,
        motions: Sequence[Motion],
        plan: Plan,
        seed: int,
        indices: Sequence[int],
        parameters: Mapping[str, Any],
        *,
        bone_scale: Mapping[str, float] | None = None,
        labels: tuple[Segment, ...] | None = None,
    ) -> list[Motion]:
        """With labels and provenance."""
        made = []
        for index, motion in zip(indices, motions, strict=True):
            origin = Provenance(self.name, self.weights_hash, plan.name, seed, index, dict(parameters))
            done = motion.replaced(labels=plan.segments if labels is None else labels, provenance=origin)
            made.append(done.scale_bones(bone_scale) if bone_scale else done)
        return made


def load(variant: str = "glmi-m", checkpoint: str | Path | None = None) -> Action2MotionEngine | Any:
    """The engine with shipped weights, or with a checkpoint.

    Args:
        variant: pose decoder: plain, lie, glmi-m (default) or glmi-r.
        checkpoint: weights written by `motionloom train` (.safetensors with its .json beside it), or the authors' own
            checkpoint file, which gives an engine on the released networks.

    Raises:
        UnknownLabelError: no such variant.
        CheckpointError: the file is missing, damaged or of another architecture.
    """
    if variant not in DECODERS:
        raise UnknownLabelError("variant of action2motion", variant, DECODERS)
    path = Path(checkpoint) if checkpoint else _weights(variant)
    if checkpoint and path.is_file() and not path.with_suffix(".json").is_file():
        from engines.action2motion.official_engine import load_official_engine

        return load_official_engine(path)
    how = "ship or train them (motionloom train action2motion)"
    model = Action2Motion(Action2MotionConfig.from_json(read_settings(path, how)))
    fill(model, path)
    return Action2MotionEngine(model, hashlib.sha256(path.read_bytes()).hexdigest())


def shipped_variants() -> tuple[Decoder, ...]:
    """The pose decoders whose weights are there."""
    return tuple(name for name in DECODERS if _weights(name).is_file())


def _weights(variant: str) -> Path:
    return WEIGHTS / f"action2motion-{variant}.safetensors"


def _chunks(count: int, frames: int) -> Iterator[range]:
    """Indices of `count` motions of so many frames, as many at a time as are made together."""
    size = max(1, min(_CHUNK, _CHUNK_FRAMES // frames))
    for start in range(0, count, size):
        yield range(start, min(count, start + size))


def _spherical(a: Tensor, b: Tensor, share: Tensor) -> Tensor:
    """Between latents a and b (T, 1, Z) at shares (1, N, 1): along the arc, which keeps a Gaussian draw's norm."""
    cosine = torch.nn.functional.cosine_similarity(a, b, dim=-1)[..., None].clamp(-0.9995, 0.9995)
    angle = torch.arccos(cosine)
    return (torch.sin((1 - share) * angle) * a + torch.sin(share * angle) * b) / torch.sin(angle)


def _join(first: Motion, after: Motion) -> Motion:
    """`after`, whose first frame is the last pose of `first`, turned and set down there; its first frame is dropped."""
    yaw = float(first.heading[-1] - after.heading[0])
    turned = after.moved(yaw=yaw)
    shift = first.translation[-1] - turned.translation[0]
    placed = turned.moved((float(shift[0]), 0.0, float(shift[2])))
    return first.concat(placed[1:]) if len(placed) > 1 else first
