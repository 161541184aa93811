"""MultiAct's protocol: many actions in a row, judged for the transitions and for what is left of them after a while.

Actions follow on each other at random, twenty steps of as many seconds (paper, "Long-term generation", figure 6).
Transition FID compares what lies around each seam with transitions of held-out real clips; accuracy is that of the
recogniser of actions over all steps, and over the last quarter of them, where errors have had time to add up. Ours are
the simple ways beside it (`ways`), the jerk at seams and the physical measures.

The real transitions are made of held-out clips as the training ones are of theirs (`engines.multiact.triplets`): some
cut as captured, most joined where two clips are nearest. Of every repeat the actions and seeds are the same for all
rows.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from engines.datasets import Clip
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation.actions import testable
from engines.evaluation.real import means
from engines.evaluation.results import Repeat, Row
from engines.evaluation.rounds import PARTS, REAL, Held, Run
from engines.metrics import distribution, physical
from engines.metrics.evaluators import Recogniser
from engines.motion import Motion
from engines.multiact.triplets import PREVIOUS, Pool, Triplet

STEPS = 20
AROUND = 10
"""Frames on both sides of a transition that are looked at with it."""
TRIPLETS = 600
"""Real transitions that are drawn from."""
_ASKED, _REAL, _ROW, _POOL = range(4)


@dataclass(frozen=True)
class SequenceOptions:
    """What a person chooses."""

    data: Held = "held-out"
    motions: int = 1000
    """Steps of each repeat: sequences have `STEPS` each."""
    frames: int = 60
    """Of each step, transition included, at 20 a second."""
    seed: int = 0

    def check(self) -> None:
        """Raises OutOfRangeError or UnknownLabelError for what is not accepted."""
        if self.data not in PARTS:
            raise UnknownLabelError("data", self.data, PARTS)
        if self.motions < STEPS:
            raise OutOfRangeError("motions", self.motions, f"{STEPS} or more: steps, {STEPS} to a sequence")
        if not 2 * AROUND <= self.frames <= 200:
            raise OutOfRangeError("frames", self.frames, f"{2 * AROUND} to 200")
        if not 0 <= self.seed < 2**63:
            raise OutOfRangeError("seed", self.seed, "0 to 2^63 - 1")


@dataclass(frozen=True)
class Passage:
    """From one action into the next."""

    seam: Motion
    """The transition and `AROUND` frames of what is before and after it."""
    action: Motion
    """What follows the transition."""
    name: str


@dataclass(frozen=True)
class _Looked:
    """What was seen of a repeat's passages, sequence after sequence."""

    seams: np.ndarray
    """(N, D) features."""
    hits: np.ndarray
    """(N,) bool: the action was recognised."""
    jerk: np.ndarray
    """(N,) largest at each seam, m/s^3."""
    physical: dict[str, float]


class SequenceBench:
    """All that the rows of one table share: sequences, real transitions, recogniser, draws.

    Args:
        engines: by row name.
        clips: of all splits.
        recogniser: of actions.
        options: see there.

    Raises:
        MotionloomError: an engine that makes no sequences, or no two actions that can be tested.
        OutOfRangeError: see `SequenceOptions`.
    """

    def __init__(
        self, engines: Mapping[str, Any], clips: Sequence[Clip], recogniser: Recogniser, options: SequenceOptions
    ) -> None:
        options.check()
        for name, engine in engines.items():
            if "sequences" not in engine.capabilities:
                able = ", ".join(sorted(engine.capabilities)) or "nothing"
                raise MotionloomError(f"{name} makes no sequences, which this protocol asks for (it can do: {able}).")
        self.options, self.recogniser = options, recogniser
        held = [clip for clip in clips if clip.split in PARTS[options.data]]
        self.actions, self.left_out = testable(engines, held, recogniser)
        if len(self.actions) < 2:
            raise MotionloomError(f"only {', '.join(self.actions)} can be tested: a sequence needs two actions.")
        pool, rng = Pool([clip for clip in held if clip.action in self.actions]), self.rng(0, _POOL)
        self.real = [pool.draw(rng) for _ in range(TRIPLETS)]
        found = [passage_of(triplet) for triplet in self.real]
        self._physical = [physical.table(passage.action) for passage in found]
        self._real = self._look(found)
        self._clips = _fingerprint(held)

    @property
    def sequences(self) -> int:
        """Of a repeat."""
        return self.options.motions // STEPS

    @property
    def per_repeat(self) -> int:
        """Steps generated in each repeat."""
        return self.sequences * STEPS

    def basis(self, evaluator: str) -> dict[str, Any]:
        """What the figures rest on, as JSON values; `evaluator` is the hash of its weights."""
        return {
            "protocol": "multiact",
            "data": self.options.data,
            "clips": self._clips,
            "evaluator": evaluator,
            "sequences": self.sequences,
            "steps": STEPS,
            "frames": self.options.frames,
            "seed": self.options.seed,
            "asked": list(self.actions),
            "captured": round(float(np.mean([triplet.captured for triplet in self.real])), 3),
        }

    def rng(self, repeat: int, stream: int) -> np.random.Generator:
        """The generator for one purpose in one repeat, the same however many repeats there are."""
        return np.random.default_rng(np.random.SeedSequence(self.options.seed, spawn_key=(repeat, stream)))

    def asked(self, repeat: int) -> list[tuple[list[tuple[str, float]], int]]:
        """Blocks and seed of each sequence: no action follows on itself."""
        rng, count = self.rng(repeat, _ASKED), len(self.actions)
        found = []
        for _ in range(self.sequences):
            on = np.concatenate([rng.integers(count, size=1), rng.integers(1, count, size=STEPS - 1)])
            names = [self.actions[i] for i in np.cumsum(on) % count]
            found.append(([(name, self.options.frames / 20) for name in names], int(rng.integers(2**62))))
        return found

    def sample(self, engine: Any, count: int) -> list[Motion]:
        """The first sequences of the first repeat."""
        return [engine.sequence(blocks, seed) for blocks, seed in self.asked(0)[:count]]

    # ---- a row, a repeat ----------------------------------------------------------------------------------

    def real_rows(self) -> dict[str, int]:
        """The transitions that there are."""
        return {REAL: len(self.real)}

    def drawn(self, row: str, repeat: int) -> _Looked:
        """Real transitions and what follows them; another draw than the one they are compared with."""
        chosen = self.rng(repeat, _ROW).integers(len(self.real), size=self.per_repeat)
        seen = (self._real.seams[chosen], self._real.hits[chosen], self._real.jerk[chosen])
        return _Looked(*seen, means([self._physical[i] for i in chosen]))

    def generated(self, engine: Any, repeat: int, run: Run) -> _Looked:
        """An engine's sequences."""
        parts, measured = [], []
        for blocks, seed in self.asked(repeat):
            run.ask()
            whole = engine.sequence(blocks, seed)
            found = passages(whole)
            if len(found) != STEPS - 1:
                raise MotionloomError(f"{engine.name} gave {len(found)} transitions between {STEPS} actions.")
            parts.append(self._look(found))
            measured.append(physical.table(whole))
            run.tell(STEPS)
        seams, hits, jerk = (np.concatenate([getattr(p, what) for p in parts]) for what in ("seams", "hits", "jerk"))
        return _Looked(seams, hits, jerk, means(measured))

    def measured(self, repeat: int, row: Row, looked: _Looked, began: float) -> Repeat:
        """All figures of what was seen, for one repeat."""
        real = self._real.seams[self.rng(repeat, _REAL).integers(len(self.real), size=len(looked.seams))]
        figures = {
            "transition_fid": distribution.fid(real, looked.seams),
            "accuracy_top1": float(looked.hits.mean()),
            "seam_jerk": float(looked.jerk.mean()),
            **looked.physical,
        }
        if row.kind == "made":
            late = looked.hits.reshape(-1, STEPS - 1)[:, -(STEPS // 4) :]
            figures["accuracy_late"] = float(late.mean())
        return Repeat(figures=figures, seconds=round(time.monotonic() - began, 3))

    def _look(self, found: Sequence[Passage]) -> _Looked:
        """Without physical measures."""
        seen = self.recogniser.recognised([passage.seam for passage in found]).features
        said = self.recogniser.recognised([passage.action for passage in found]).logits.argmax(-1)
        hits = said == np.array([self.recogniser.index(passage.name) for passage in found])
        return _Looked(seen, hits, np.array([peak_jerk(passage.seam) for passage in found]), {})


def passages(motion: Motion) -> list[Passage]:
    """The transitions of a labelled sequence, each with the action after it."""
    seams = [s for s in motion.labels if s.kind == "transition"]
    found = []
    for seam, until in zip(seams, [*(s.start for s in seams[1:]), len(motion)], strict=True):
        around = motion[max(0, seam.start - AROUND) : min(until, seam.end + AROUND)].face_front()
        name = motion.label_at(seam.end) or ""
        found.append(Passage(around, motion[seam.end : until].face_front(), name))
    return found


def passage_of(triplet: Triplet) -> Passage:
    """A real transition."""
    end = PREVIOUS + triplet.transition
    seam = triplet.motion[PREVIOUS - AROUND : end + AROUND].face_front()
    return Passage(seam, triplet.motion[end:].face_front(), triplet.actions[1])


def peak_jerk(motion: Motion) -> float:
    """The largest third derivative of a joint's position, m/s^3."""
    if len(motion) < 4:
        return 0.0
    return float(physical.jerk(motion).max())


def _fingerprint(clips: Sequence[Clip]) -> str:
    """Changes with the clips, their order or their frames."""
    digest = hashlib.blake2b(digest_size=8)
    for clip in clips:
        digest.update(f"{clip.corpus}/{clip.name}/{clip.action}/{len(clip.motion)};".encode())
        digest.update(clip.motion.translation[-1].tobytes())
    return digest.hexdigest()
