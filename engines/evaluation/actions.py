"""Action2Motion's protocol: as many motions of every action, judged beside real ones of the same actions.

Twenty times (thesis section 3.3, paper section 4.2): 3,000 motions are generated, their actions in equal parts; as many
real motions are drawn with replacement from held-out clips; the recogniser looks at both. Ours are the actions (those
that every engine knows and that have a held-out clip), the recogniser, the lengths of real clips that are shorter than
a generated motion, and the physical measures.

Of every repeat the draw of real motions and the seeds of the engines are the same for all rows, so that rows differ by
what they are and not by luck.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from engines.datasets import Clip
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation.real import RealMotions, means
from engines.evaluation.results import Repeat, Row
from engines.evaluation.rounds import BATCH, PARTS, PHYSICAL, REAL, TRAINING, Held, Run
from engines.metrics import distribution, physical, protocol, recognition
from engines.metrics.evaluators import Recogniser
from engines.metrics.recognition import Recognised
from engines.motion import Motion

COMPONENTS = 16
"""Principal components in which one action's motions are compared: too few are drawn of each for all features."""
_LABELS, _REAL, _PAIRS, _SEEDS, _ROW = range(5)


@dataclass(frozen=True)
class Options:
    """What a person chooses."""

    data: Held = "held-out"
    motions: int = 3000
    """Of each repeat."""
    frames: int = 60
    """Of each generated motion, at 20 a second."""
    seed: int = 0

    def check(self) -> None:
        """Raises OutOfRangeError or UnknownLabelError for what is not accepted."""
        if self.data not in PARTS:
            raise UnknownLabelError("data", self.data, PARTS)
        if self.frames < 4:
            raise OutOfRangeError("frames", self.frames, "4 or more")
        if not 0 <= self.seed < 2**63:
            raise OutOfRangeError("seed", self.seed, "0 to 2^63 - 1")


class ActionBench:
    """All that the rows of one table share: actions, real motions, recogniser, draws.

    Args:
        engines: by row name.
        clips: of all splits.
        recogniser: of actions.
        options: see there.

    Raises:
        MotionloomError: an engine that does not go by actions, or no action that can be tested.
        OutOfRangeError: too few motions for the actions.
    """

    def __init__(
        self, engines: Mapping[str, Any], clips: Sequence[Clip], recogniser: Recogniser, options: Options
    ) -> None:
        options.check()
        self.options, self.recogniser = options, recogniser
        held_out = [clip for clip in clips if clip.split in PARTS[options.data]]
        training = [clip for clip in clips if clip.split == "train"]
        self.actions, self.left_out = testable(engines, held_out, recogniser)
        if options.motions < 2 * len(self.actions):
            raise OutOfRangeError(
                "motions",
                options.motions,
                f"{2 * len(self.actions)} or more: two of each of {len(self.actions)} actions",
            )
        self.real = RealMotions(held_out, self.actions, options.frames, recogniser)
        self.training = RealMotions(training, self.actions, options.frames, recogniser)
        self.answers = np.array([recogniser.index(action) for action in self.actions])
        self._components = _principal(self.real.recognised(self.real.firsts()).features)

    def basis(self, evaluator: str) -> dict[str, Any]:
        """What the figures rest on, as JSON values; `evaluator` is the hash of its weights."""
        return {
            "protocol": "action2motion",
            "data": self.options.data,
            "clips": self.real.fingerprint(),
            "training clips": self.training.fingerprint(),
            "evaluator": evaluator,
            "motions": self.options.motions,
            "frames": self.options.frames,
            "seed": self.options.seed,
            "actions": list(self.actions),
        }

    def rng(self, repeat: int, stream: int) -> np.random.Generator:
        """The generator for one purpose in one repeat, the same however many repeats there are."""
        return np.random.default_rng(np.random.SeedSequence(self.options.seed, spawn_key=(repeat, stream)))

    def labels(self, repeat: int) -> np.ndarray:
        """(motions,) which action each is of, in order, as even as can be; chance says which have one more."""
        count, actions = self.options.motions, len(self.actions)
        counts = np.full(actions, count // actions)
        counts[self.rng(repeat, _LABELS).permutation(actions)[: count % actions]] += 1
        return np.repeat(np.arange(actions), counts)

    def seed(self, repeat: int, action: int, batch: int = 0) -> int:
        """Of a batch of motions of an action."""
        drawn = np.random.SeedSequence(self.options.seed, spawn_key=(repeat, _SEEDS, action, batch))
        return int(drawn.generate_state(1, np.uint64)[0] >> 2)

    def sample(self, engine: Any, count: int) -> list[list[Motion]]:
        """Of each action the first `count` motions of the first repeat."""
        return [
            engine.generate_many(action, count=count, frames=self.options.frames, seed=self.seed(0, index))
            for index, action in enumerate(self.actions)
        ]

    @property
    def per_repeat(self) -> int:
        """Motions generated in each repeat."""
        return self.options.motions

    def real_rows(self) -> dict[str, int]:
        """Those that have clips of every action."""
        pools = {REAL: self.real, TRAINING: self.training}
        return {name: pool.clips for name, pool in pools.items() if pool.complete}

    def drawn(self, row: str, repeat: int) -> _Looked:
        """Real motions; held-out ones are another draw than the one they are compared with."""
        pool, labels = self.real if row == REAL else self.training, self.labels(repeat)
        chosen = pool.draw(labels, self.rng(repeat, _ROW))
        return _Looked(pool.recognised(chosen), pool.physical(chosen[_few(labels)]))

    def generated(self, engine: Any, repeat: int, run: Run) -> _Looked:
        """An engine's motions; of each batch only what was seen is kept."""
        features, logits, measured = [], [], []
        few = _few(self.labels(repeat))
        place = 0
        for motions, joints in self._batches(engine, repeat, run):
            seen = self.recogniser.recognised(motions)
            features.append(seen.features)
            logits.append(seen.logits)
            for i, motion in enumerate(motions):
                if few[place + i]:
                    measured.append(physical.table(motion, joints[i] if joints else None))
            place += len(motions)
        return _Looked(Recognised(np.concatenate(features), np.concatenate(logits)), means(measured))

    def _batches(self, engine: Any, repeat: int, run: Run) -> Iterator[tuple[Sequence[Motion], Sequence[np.ndarray]]]:
        """Motions, and the joints an engine gave before they had rigid bones, where it tells."""
        raw = getattr(engine, "generate_joints", None)
        for action, count in enumerate(np.bincount(self.labels(repeat))):
            for batch, start in enumerate(range(0, count, BATCH)):
                run.ask()
                request = {
                    "count": int(min(BATCH, count - start)),
                    "frames": self.options.frames,
                    "seed": self.seed(repeat, action, batch),
                }
                name = self.actions[action]
                yield engine.generate_many(name, **request), raw(name, **request) if raw else ()
                run.tell(request["count"])

    def measured(self, repeat: int, row: Row, made: _Looked, began: float) -> Repeat:
        """All figures of motions that were looked at, for one repeat."""
        labels = self.labels(repeat)
        real = self.real.recognised(self.real.draw(labels, self.rng(repeat, _REAL)))
        wanted = self.answers[labels]
        scores = protocol.action_scores(
            real.features, made.seen, wanted, protocol.ACTION2MOTION, self.rng(repeat, _PAIRS)
        )
        counts = recognition.confusion(made.seen.logits, wanted)[self.answers]
        hits = recognition.hits(made.seen.logits, wanted)
        there, here = self._reduced(real.features), self._reduced(made.seen.features)
        each = [labels == index for index in range(len(self.actions))]
        return Repeat(
            figures={**scores, **made.physical},
            accuracy=[round(float(hits[own].mean()), 6) for own in each],
            frechet=[round(distribution.fid(there[own], here[own]), 6) for own in each],
            confusion=[[int(i), int(j), int(counts[i, j])] for i, j in np.argwhere(counts)],
            seconds=round(time.monotonic() - began, 3),
        )

    def _reduced(self, features: np.ndarray) -> np.ndarray:
        return features @ self._components.T


@dataclass(frozen=True)
class _Looked:
    """What was seen of a repeat's motions, in the order of its labels."""

    seen: Recognised
    physical: dict[str, float]


def _few(labels: np.ndarray) -> np.ndarray:
    """(N,) booleans: the first motions of every action, about `PHYSICAL` in all."""
    each = -(-PHYSICAL // len(np.unique(labels)))
    place = np.arange(len(labels)) - np.searchsorted(labels, labels)
    return place < each


def testable(
    engines: Mapping[str, Any], held_out: Sequence[Clip], recogniser: Recogniser
) -> tuple[tuple[str, ...], dict[str, tuple[str, ...]]]:
    """The actions of the table, and why others that an engine knows are not in it.

    Raises:
        MotionloomError: an engine that does not go by actions, or no action that can be tested.
    """
    if not engines:
        raise OutOfRangeError("engines", [], "one or more")
    for name, engine in engines.items():
        if "actions" not in engine.capabilities:
            able = ", ".join(sorted(engine.capabilities)) or "nothing"
            raise MotionloomError(f"{name} does not go by actions, which this protocol asks for (it can do: {able}).")
    known = [[action.name for action in engine.actions] for engine in engines.values()]
    every = list(dict.fromkeys(action for actions in known for action in actions))
    there = {clip.action for clip in held_out}
    reasons = {
        "not known to every engine": lambda action: not all(action in actions for actions in known),
        "without a held-out clip": lambda action: action not in there,
        "not known to the recogniser": lambda action: action not in recogniser.labels,
    }
    left_out: dict[str, list[str]] = {reason: [] for reason in reasons}
    kept = []
    for action in every:
        reason = next((reason for reason, applies in reasons.items() if applies(action)), None)
        (left_out[reason] if reason else kept).append(action)
    if not kept:
        raise MotionloomError(
            f"none of the {len(every)} actions of {', '.join(engines)} can be tested: the held-out clips show "
            f"{len(there - {None})} actions, the recogniser knows {len(recogniser.labels)}; prepare data that has them."
        )
    return tuple(kept), {reason: tuple(names) for reason, names in left_out.items() if names}


def _principal(features: np.ndarray) -> np.ndarray:
    """(K, D) directions in which features (N, D) vary most."""
    centred = features - features.mean(axis=0)
    return np.linalg.svd(centred, full_matrices=False)[2][:COMPONENTS]
