"""The MultiAct engine: one action after another, as many as one likes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engines import actions as vocabulary
from engines.actions import Action
from engines.errors import Cancelled, OutOfRangeError, UnknownLabelError, demand_whole
from engines.motion import Motion, Provenance, Segment
from engines.multiact import plan, train
from engines.multiact.cell import Cell, MACVAECell
from engines.multiact.model import LONGEST_TRANSITION
from engines.multiact.plan import Block, BlockLike
from engines.multiact.representation import FPS
from engines.skeletons import SMPL22
from engines.weights_file import SHIPPED

MAX_FRAMES = 200_000
"""Of a sequence that is held as one Motion: over two and a half hours."""
MAX_COUNT = 256

_LICENCES = {
    "small": "CC BY-NC 4.0 (trained on Bandai-Namco clips)",
    "official": "that of the checkpoint; the authors release theirs for research",
}

Progress = Callable[[int, int], None]
Beginning = Callable[[str, int, int], Motion]
"""(action, frames, seed) -> a motion to begin with."""


class MultiActEngine:
    """Actions in turn, with the transitions between them; `engines.load("multiact")` makes one.

    Args:
        cell: makes a step.
        weights_hash: SHA-256 of its weights.
        beginning: makes the first action; Action2Motion if none.
        variant: `small`, or `official` for the authors' networks.
    """

    name = "multiact"
    description = "Actions one after another, as many as one likes, with the transitions between (Lee et al. 2023)."
    fps = FPS
    max_frames = MAX_FRAMES
    longest_transition = LONGEST_TRANSITION / FPS
    """Seconds."""
    capabilities = frozenset({"actions", "sequences", "transition", "outpaint"})

    def __init__(
        self, cell: Cell, weights_hash: str, beginning: Beginning | None = None, variant: str = "small"
    ) -> None:
        self.cell, self.weights_hash, self.variant = cell, weights_hash, variant
        self.variants = (variant,)
        self.licence = _LICENCES[variant]
        self.actions: tuple[Action, ...] = tuple(_action(name) for name in cell.names)
        self._beginning = beginning

    # ---- what a person asks for ---------------------------------------------------------------------------------

    def sequence(  # noqa: PLR0913 - the request of a person, each part but one optional
        self,
        blocks: Sequence[BlockLike],
        seed: int = 0,
        *,
        transition: float | None = None,
        start: Motion | None = None,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> Motion:
        """One motion of actions in turn, such as `[("walk", 2.0), ("wave", 1.5), "sit"]`.

        Args:
            blocks: an action's name, or (name, seconds), 0.1 to 600, which the transition into it is part of. Without
                seconds an action lasts as long as it usually does. Of a name only its beginning may be given.
            seed: 0 to 2^63 - 1; the same seed gives the same motion.
            transition: seconds of the transition into each block, 0.05 to 2 and at most half of what is made at once;
                as learned if none.
            start: what comes before; without it, the first block is begun by the action engine.
            progress: called with (blocks done, blocks).
            cancel: asked between steps; stops with `Cancelled`.

        Returns:
            A Motion at 20 frames a second on smpl22, labelled with actions and transitions. A start is its first part.

        Raises:
            UnknownLabelError: an action is not known; the message lists the nearest.
            OutOfRangeError: no blocks, more than `MAX_FRAMES` frames (`iter_frames` has no end), or a number out of
                its range.
        """
        wanted = list(plan.blocks(self.cell, blocks))
        if not wanted:
            raise OutOfRangeError("blocks", [], "one or more actions, such as [('walk', 2.0), 'sit down']")
        total = sum(block.frames for block in wanted)
        if total > MAX_FRAMES:
            raise OutOfRangeError("frames of all blocks", total, f"up to {MAX_FRAMES:,}; iter_frames has no end")
        given = None if start is None else self._house(start)
        pieces = [] if given is None else [given]
        for number, (last, piece) in enumerate(self._pieces(iter(wanted), seed, transition, given)):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {number} steps; nothing was kept")
            pieces.append(piece)
            if progress and last:
                progress(last, len(wanted))
        told: dict[str, Any] = {"blocks": [[block.name, block.frames / FPS] for block in wanted]}
        if transition is not None:
            told["transition"] = transition
        if start is not None:
            told["of"] = start.provenance.source
        asked = " > ".join(block.name for block in wanted)
        origin = Provenance(self.name, self.weights_hash, asked, seed, 0, told)
        return pieces[0].concat(*pieces[1:]).replaced(provenance=origin)

    def continue_from(
        self, motion: Motion, action: str, seconds: float | None = None, seed: int = 0, **options: Any
    ) -> Motion:
        """A motion of any engine or file, and then an action.

        Args:
            motion: retargeted to smpl22 and resampled to 20 frames a second where it is not so.
            action: a name of `actions`, or its beginning.
            seconds: of transition and action; as it usually takes if none.
            seed: as in `sequence`.
            options: `transition`, as there.
        """
        return self.sequence([(action, seconds)], seed, start=motion, **options)

    def iter_frames(
        self,
        blocks: Iterable[BlockLike],
        seed: int = 0,
        *,
        transition: float | None = None,
        start: Motion | None = None,
    ) -> Iterator[Motion]:
        """The frames of a sequence one by one, each a Motion of one frame, made a step at a time.

        `blocks` may never end: what is held in memory does not grow. Frames are those of `sequence`, without the start.
        """
        given = None if start is None else self._house(start)
        for _, piece in self._pieces(plan.blocks(self.cell, blocks), seed, transition, given):
            for frame in range(len(piece)):
                yield piece[frame : frame + 1]

    # ---- as the studio asks engines -----------------------------------------------------------------------------

    def generate(self, action: str, frames: int = 60, seed: int = 0) -> Motion:
        """One motion of an action; see `generate_many`."""
        return self.generate_many(action, 1, frames, seed)[0]

    def generate_many(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        action: str,
        count: int = 4,
        frames: int = 60,
        seed: int = 0,
        *,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of one action, `frames` long (2 to 12,000); motion i does not depend on `count`."""
        demand_whole("count", count, 1, MAX_COUNT)
        made = []
        for index in range(count):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {index} of {count} motions; none was kept")
            motion = self.transition([(action, frames)], _stream(seed, index))
            origin = Provenance(self.name, self.weights_hash, motion.provenance.prompt, seed, index, {"frames": frames})
            made.append(motion.replaced(provenance=origin))
            if progress:
                progress(index + 1, count)
        return made

    def transition(self, segments: Sequence[tuple[str, int]], seed: int = 0) -> Motion:
        """`sequence` in frames: (action, frames) in turn."""
        for _, frames in segments:
            demand_whole("frames", frames, round(plan.SHORTEST_BLOCK * FPS), round(plan.LONGEST_BLOCK * FPS))
        return self.sequence([(action, frames / FPS) for action, frames in segments], seed)

    def outpaint(  # noqa: PLR0913, PLR0917 - the request of a person, each part optional
        self, motion: Motion, action: str, keep: int = 20, frames: int = 60, count: int = 4, seed: int = 0
    ) -> list[Motion]:
        """Keep the first frames of a motion and go on in different ways; arguments as for Action2Motion."""
        given = self._house(motion)
        demand_whole("keep", keep, 1, len(given))
        demand_whole("frames", frames, keep + 2, MAX_FRAMES)
        demand_whole("count", count, 1, MAX_COUNT)
        more, made = (frames - keep) / FPS, []
        for index in range(count):
            motion = self.continue_from(given[:keep], action, more, _stream(seed, index))
            told = {"keep": keep, "frames": frames, "of": given.provenance.source}
            origin = Provenance(self.name, self.weights_hash, motion.provenance.prompt, seed, index, told)
            made.append(motion.replaced(provenance=origin))
        return made

    # ---- how it is made -----------------------------------------------------------------------------------------

    def _pieces(
        self, blocks: Iterator[Block], seed: int, transition: float | None, start: Motion | None
    ) -> Iterator[tuple[int, Motion]]:
        """Step after step, in the world; with each the number of the block that it ends, or 0."""
        demand_whole("seed", seed, 0, 2**63 - 1)
        told = None if transition is None else _frames_of(transition)
        rng = np.random.default_rng(seed)
        tail = None if start is None else start[-self.cell.sees :]
        before = None if start is None else start.label_at(len(start) - 1)
        for number, block in enumerate(blocks, start=1):
            parts = plan.steps(self.cell, block)
            for place, step in enumerate(parts):
                if tail is None:
                    made = self._begun(block, step, seed)
                else:
                    made = self._made(tail, before, block, step, None if place else told, rng)
                yield (number if place == len(parts) - 1 else 0), made
                tail = (made if tail is None else tail.concat(made))[-self.cell.sees :]
                before = block.name

    def _begun(self, block: Block, step: plan.Step, seed: int) -> Motion:
        """The first step, by the action engine."""
        if self._beginning is None:
            from engines import registry

            self._beginning = registry.load("action2motion").generate
        made = self._house(self._beginning(block.name, step.frames, seed))
        return made.replaced(labels=(Segment(0, len(made), "action", block.name),))

    def _made(  # noqa: PLR0913, PLR0917 - where it comes from, what it becomes, how
        self, tail: Motion, before: str | None, block: Block, step: plan.Step, told: int | None, rng: Any
    ) -> Motion:
        """A step that follows on a motion, labelled; another performance of the same block has no transition."""
        if step.held:
            made, transition = tail[-1:].concat(*[tail[-1:]] * (step.frames - 1)), 0
        else:
            made, transition = self.cell.advance(_at_least(tail, self.cell.sees), block.action, step.frames, told, rng)
        again = before == block.name
        labels = [] if again or not transition else [
            Segment(0, transition, "transition", f"{before or 'given'} > {block.name}")
        ]  # fmt: skip
        labels.append(Segment(0 if again else transition, len(made), "action", block.name))
        return made.replaced(labels=tuple(labels))

    def _house(self, motion: Motion) -> Motion:
        return motion.retarget(SMPL22).resample(FPS)


def load(variant: str = "small", checkpoint: str | Path | None = None) -> MultiActEngine:
    """The engine with shipped weights, with weights of `motionloom train multiact`, or the authors' checkpoint.

    Args:
        variant: small.
        checkpoint: weights (.safetensors with its .json beside it), or the authors' own file (`official_cell`).

    Raises:
        UnknownLabelError: no such variant.
        CheckpointError: the file is missing, damaged or of another architecture.
    """
    if variant != "small":
        raise UnknownLabelError("variant of multiact", variant, ("small",))
    path = Path(checkpoint) if checkpoint else SHIPPED / "multiact.safetensors"
    if checkpoint and path.is_file() and not path.with_suffix(".json").is_file():
        from engines.multiact import official_cell

        cell: Cell = official_cell.load(path)
        variant = "official"
    else:
        cell = MACVAECell(train.read(path))
    return MultiActEngine(cell, hashlib.sha256(path.read_bytes()).hexdigest(), variant=variant)


def _action(name: str) -> Action:
    """Of the vocabulary, or one that only these weights know."""
    try:
        return vocabulary.get(name)
    except UnknownLabelError:
        return Action(name, f"Label {name!r} of the checkpoint.", "of the checkpoint")


def _at_least(motion: Motion, frames: int) -> Motion:
    """A short start stands still before it."""
    return motion if len(motion) >= frames else motion[:1].concat(*[motion[:1]] * (frames - len(motion) - 1), motion)


def _frames_of(transition: float) -> int:
    longest = MultiActEngine.longest_transition
    if isinstance(transition, bool) or not 1 / FPS <= transition <= longest:
        raise OutOfRangeError("transition", transition, f"{1 / FPS:g} to {longest:g} seconds")
    return round(transition * FPS)


def _stream(seed: int, index: int) -> int:
    """A seed of its own for each motion of a draw."""
    demand_whole("seed", seed, 0, 2**63 - 1)
    return seed if index == 0 else int(np.random.SeedSequence([seed, index]).generate_state(1, np.uint64)[0] >> 2)
