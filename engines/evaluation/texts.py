"""Text2Motion's protocol: a motion for every held-out sentence, judged beside the real motion of that sentence.

Twenty times (paper section 5, thesis section 4.4): a motion is generated for a sentence of every held-out clip, as long
as the clip; the co-embedding looks at sentences and motions. R-precision: is a motion's own sentence among the nearest
of 32. For multimodality 100 sentences get 30 motions each. Ours are the judge, the captions (drawn as no training draws
them), the physical measures, and that no pool holds a sentence twice.

Of every repeat the sentences, the real motions that FID compares with, and the seeds of the engines are the same for
all rows, so that rows differ by what they are and not by luck.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from engines.datasets import Clip
from engines.datasets.captions import captions
from engines.datasets.captions.encoded import HELD_OUT_SEED
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation.real import means
from engines.evaluation.results import Repeat, Row
from engines.evaluation.rounds import BATCH, PARTS, PHYSICAL, REAL, Held, Run
from engines.metrics import physical, protocol
from engines.metrics.evaluators import CoEmbedding
from engines.metrics.protocol import TEXT2MOTION
from engines.metrics.retrieval import POOL
from engines.motion import Motion

SHORTEST, LONGEST = 20, 200
"""Frames a motion is asked to have at least and at most: 1 and 10 seconds."""
_PROMPTS, _REAL, _PAIRS, _SEEDS, _MANY = range(5)


@dataclass(frozen=True)
class TextOptions:
    """What a person chooses."""

    data: Held = "held-out"
    motions: int = 3000
    """Of each repeat, as many at most for single sentences, one for each clip, and again for multimodality."""
    seed: int = 0

    def check(self) -> None:
        """Raises OutOfRangeError or UnknownLabelError for what is not accepted."""
        if self.data not in PARTS:
            raise UnknownLabelError("data", self.data, PARTS)
        if self.motions < 2 * POOL:
            raise OutOfRangeError("motions", self.motions, f"{2 * POOL} or more: pools have {POOL}")
        if not 0 <= self.seed < 2**63:
            raise OutOfRangeError("seed", self.seed, "0 to 2^63 - 1")


@dataclass(frozen=True)
class Prompt:
    """A sentence an engine is asked for."""

    clip: int
    """The held-out clip it describes, by its place."""
    sentence: str
    frames: int
    """Of the motion to be made, at 20 a second: the clip's own length."""
    seed: int


@dataclass(frozen=True)
class _Looked:
    """What was seen of a repeat's motions, in the order of its prompts."""

    motions: np.ndarray
    """(N, D)."""
    physical: dict[str, float]
    many: np.ndarray | None = None
    """(prompts, motions a prompt, D), for multimodality."""


class TextBench:
    """All that the rows of one table share: sentences, real motions, judge, draws.

    Args:
        engines: by row name.
        clips: of all splits.
        judge: of motions and sentences.
        options: see there.

    Raises:
        MotionloomError: an engine that takes no text.
        OutOfRangeError: too few held-out clips, or motions, to fill a pool.
    """

    left_out: Mapping[str, tuple[str, ...]] = {}

    def __init__(
        self, engines: Mapping[str, Any], clips: Sequence[Clip], judge: CoEmbedding, options: TextOptions
    ) -> None:
        options.check()
        _check(engines)
        self.options, self.judge = options, judge
        self.clips = [clip for clip in clips if clip.split in PARTS[options.data]]
        if len(self.clips) < 2 * POOL:
            raise OutOfRangeError("number of held-out clips", len(self.clips), f"{2 * POOL} or more: pools have {POOL}")
        self.said = [captions(clip, HELD_OUT_SEED) for clip in self.clips]
        self.count = min(options.motions, len(self.clips))
        """Sentences of a repeat."""
        each = TEXT2MOTION.motions_a_prompt
        self.many = max(1, min(TEXT2MOTION.multimodality_prompts, options.motions // each))
        """Sentences of a repeat that get many motions."""
        self.per_repeat = self.count + self.many * each
        self.real = judge.motions([clip.motion for clip in self.clips])
        self._texts: dict[str, np.ndarray] = {}
        self._measured: dict[int, dict[str, float]] = {}

    def basis(self, evaluator: str) -> dict[str, Any]:
        """What the figures rest on, as JSON values; `evaluator` is the hash of its weights."""
        return {
            "protocol": "text2motion",
            "data": self.options.data,
            "clips": self._fingerprint(),
            "evaluator": evaluator,
            "motions": self.count,
            "sentences with many": self.many,
            "seed": self.options.seed,
        }

    def rng(self, repeat: int, stream: int) -> np.random.Generator:
        """The generator for one purpose in one repeat, the same however many repeats there are."""
        return np.random.default_rng(np.random.SeedSequence(self.options.seed, spawn_key=(repeat, stream)))

    def prompts(self, repeat: int) -> list[Prompt]:
        """The sentences of a repeat: of different clips, each one of its captions."""
        rng = self.rng(repeat, _PROMPTS)
        chosen = rng.permutation(len(self.clips))[: self.count]
        return [self._prompt(int(clip), rng, (repeat, _SEEDS, place)) for place, clip in enumerate(chosen)]

    def prompts_for_many(self, repeat: int) -> list[Prompt]:
        """Those of a repeat that get many motions each."""
        rng = self.rng(repeat, _MANY)
        chosen = rng.choice(len(self.clips), self.many, replace=self.many > len(self.clips))
        return [self._prompt(int(clip), rng, (repeat, _MANY, place)) for place, clip in enumerate(chosen)]

    def sample(self, engine: Any, count: int) -> list[Motion]:
        """Motions for the first sentences of the first repeat."""
        return [_make(engine, prompt, 1)[0] for prompt in self.prompts(0)[:count]]

    # ---- a row, a repeat ----------------------------------------------------------------------------------

    def real_rows(self) -> dict[str, int]:
        """The clips that the sentences describe."""
        return {REAL: len(self.clips)}

    def drawn(self, row: str, repeat: int) -> _Looked:
        """The real motions of a repeat's sentences; each sentence has but one, so there is no multimodality."""
        chosen = [prompt.clip for prompt in self.prompts(repeat)]
        for i in chosen[:PHYSICAL]:
            if i not in self._measured:
                self._measured[i] = physical.table(self.clips[i].motion)
        return _Looked(self.real[chosen], means([self._measured[i] for i in chosen[:PHYSICAL]]))

    def generated(self, engine: Any, repeat: int, run: Run) -> _Looked:
        """An engine's motions; of each batch only what was seen is kept."""
        seen, measured = [], []
        for motions in self._batches(engine, repeat, run):
            seen.append(self.judge.motions(motions))
            measured += [physical.table(motion) for motion in motions[: max(0, PHYSICAL - len(measured))]]
        many = []
        for prompt in self.prompts_for_many(repeat):
            run.ask()
            many.append(self.judge.motions(_make(engine, prompt, TEXT2MOTION.motions_a_prompt)))
            run.tell(TEXT2MOTION.motions_a_prompt)
        return _Looked(np.concatenate(seen), means(measured), np.stack(many))

    def measured(self, repeat: int, row: Row, looked: _Looked, began: float) -> Repeat:
        """All figures of motions that were looked at, for one repeat."""
        sentences = [prompt.sentence for prompt in self.prompts(repeat)]
        identity = np.unique(sentences, return_inverse=True)[1]
        made = protocol.TextFeatures(self.texts(sentences), looked.motions, looked.many, identity)
        real = self.real[self.rng(repeat, _REAL).integers(len(self.real), size=self.count)]
        scores = protocol.text_scores(real, made, TEXT2MOTION, self.rng(repeat, _PAIRS))
        return Repeat(figures={**scores, **looked.physical}, seconds=round(time.monotonic() - began, 3))

    def texts(self, sentences: Sequence[str]) -> np.ndarray:
        """(N, D) of sentences; each is encoded once."""
        new = [sentence for sentence in dict.fromkeys(sentences) if sentence not in self._texts]
        if new:
            self._texts |= dict(zip(new, self.judge.texts(new), strict=True))
        return np.stack([self._texts[sentence] for sentence in sentences])

    def _batches(self, engine: Any, repeat: int, run: Run) -> Iterator[list[Motion]]:
        prompts = self.prompts(repeat)
        for start in range(0, len(prompts), BATCH):
            made = []
            for prompt in prompts[start : start + BATCH]:
                run.ask()
                made += _make(engine, prompt, 1)
                run.tell(1)
            yield made

    def _prompt(self, clip: int, rng: np.random.Generator, key: tuple[int, int, int]) -> Prompt:
        said = self.said[clip]
        frames = int(np.clip(len(self.clips[clip].motion), SHORTEST, LONGEST))
        seed = np.random.SeedSequence(self.options.seed, spawn_key=key).generate_state(1, np.uint64)[0] >> 2
        return Prompt(clip, said[int(rng.integers(len(said)))], frames, int(seed))

    def _fingerprint(self) -> str:
        """Changes with the clips, their order, their frames or what is said of them."""
        digest = hashlib.blake2b(digest_size=8)
        for clip, said in zip(self.clips, self.said, strict=True):
            digest.update(f"{clip.corpus}/{clip.name}/{len(clip.motion)}/{'/'.join(said)};".encode())
            digest.update(clip.motion.translation[-1].tobytes())
        return digest.hexdigest()


def _make(engine: Any, prompt: Prompt, count: int) -> list[Motion]:
    return engine.generate_many(prompt=prompt.sentence, count=count, frames=prompt.frames, seed=prompt.seed)


def _check(engines: Mapping[str, Any]) -> None:
    if not engines:
        raise OutOfRangeError("engines", [], "one or more")
    for name, engine in engines.items():
        if "text" not in engine.capabilities:
            able = ", ".join(sorted(engine.capabilities)) or "nothing"
            raise MotionloomError(f"{name} takes no text, which this protocol gives it (it can do: {able}).")
