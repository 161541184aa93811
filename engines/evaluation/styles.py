"""Generative stylization's protocol: held-out motions put in other manners, judged for manner and for content.

Thirty times (thesis section 5.3): held-out motions are each given a style drawn at random from those of the held-out
styled clips, by its name, by a clip that has it, or by neither (prior). The recogniser of styles says whether the style
is there, and FID compares with the clips that gave the styles; the recogniser of contents says whether it is still the
same movement. For diversity some motions are each put in one style thirty times. Ours are the recognisers, the corpora
and the physical measures.

Of every repeat the contents, the styles, the clips that give them and the seeds are the same for all rows.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from engines.datasets import Clip
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation.real import means
from engines.evaluation.results import Repeat, Row
from engines.evaluation.rounds import BATCH, PARTS, PHYSICAL, REAL, Held, Run
from engines.metrics import distribution, physical
from engines.metrics.evaluators import Recogniser
from engines.metrics.protocol import STYLIZATION
from engines.metrics.recognition import Recognised
from engines.metrics.style import content_scores, pose_distance, style_scores
from engines.motion import Motion

By = Literal["label", "motion", "prior"]
WAYS: Mapping[str, str] = {"label": "styles", "motion": "references", "prior": "references"}
"""Where a style comes from (its name; a clip that has it; chance), and what an engine must be able to do for it."""
STYLED = "bandai-namco"
"""The corpus whose clips have styles and contents."""
SHORTEST, LONGEST = 20, 160
"""Frames of a content at least and at most: 1 and 8 seconds, as much as the recognisers look at."""
CONTENTS_OF_DIVERSITY = 10
"""Contents of a repeat that are put in one style `STYLIZATION.motions_a_prompt` times."""
_ASKED, _REAL, _PAIRS, _MANY = range(4)


@dataclass(frozen=True)
class StyleOptions:
    """What a person chooses."""

    data: Held = "held-out"
    by: By = "label"
    corpus: str = STYLED
    """Whose motions are put in other manners; no engine here is taught styles on any but the default."""
    motions: int = 300
    """Of each repeat."""
    tempo: bool = False
    """Whether engines that can may also change how fast a motion goes; poses are then not compared."""
    seed: int = 0

    def check(self) -> None:
        """Raises OutOfRangeError or UnknownLabelError for what is not accepted."""
        if self.data not in PARTS:
            raise UnknownLabelError("data", self.data, PARTS)
        if self.by not in WAYS:
            raise UnknownLabelError("way to tell a style", self.by, WAYS)
        if self.motions < 2:
            raise OutOfRangeError("motions", self.motions, "2 or more")
        if not 0 <= self.seed < 2**63:
            raise OutOfRangeError("seed", self.seed, "0 to 2^63 - 1")


@dataclass(frozen=True)
class Wish:
    """A motion and the manner it is to have."""

    content: int
    """Place among the bench's contents."""
    style: str
    reference: int
    """Place among the bench's styled clips, of that style."""
    seed: int


@dataclass(frozen=True)
class _Looked:
    """What was seen of a repeat's motions, in the order of its wishes."""

    manner: Recognised
    content: Recognised
    poses: float | None
    """Mean distance to the contents' poses, radians; none for real motions and at another tempo."""
    physical: dict[str, float]
    many: np.ndarray | None = None
    """(contents, stylings, D), for diversity."""


class StyleBench:
    """All that the rows of one table share: contents, styles, judges, draws.

    Args:
        engines: by row name.
        clips: of all splits.
        manners: recogniser of styles.
        contents: recogniser of contents.
        options: see there.

    Raises:
        MotionloomError: an engine that cannot do it; no content or style to try.
        UnknownLabelError: no clip of that corpus.
    """

    def __init__(
        self, engines: Mapping[str, Any], clips: Sequence[Clip], manners: Recogniser, contents: Recogniser,
        options: StyleOptions,
    ) -> None:  # fmt: skip
        options.check()
        _check(engines, options.by)
        self.options, self.manners, self.judge = options, manners, contents
        held = [clip for clip in clips if clip.split in PARTS[options.data]]
        if options.corpus not in {clip.corpus for clip in held}:
            raise UnknownLabelError("corpus with held-out clips", options.corpus, {clip.corpus for clip in held})
        self.contents = [c for c in held if c.corpus == options.corpus and len(c.motion) >= SHORTEST]
        self.known = options.corpus == STYLED
        """Whether the recogniser of contents knows what the contents are."""
        if self.known:
            self.contents = [clip for clip in self.contents if clip.action in contents.labels]
        self.styles, self.left_out = _testable(engines, held, manners)
        self.styled = [clip for clip in held if clip.style in self.styles]
        if not (self.contents and self.styles):
            raise MotionloomError("there is no held-out motion to put in a manner, or none that has a manner.")
        self.per_repeat = options.motions + CONTENTS_OF_DIVERSITY * STYLIZATION.motions_a_prompt
        self._seen: dict[tuple[str, int], tuple[np.ndarray, np.ndarray]] = {}
        self._measured: dict[int, dict[str, float]] = {}

    def basis(self, evaluator: str) -> dict[str, Any]:
        """What the figures rest on, as JSON values; `evaluator` is the hashes of the recognisers' weights."""
        return {
            "protocol": "stylization",
            "data": self.options.data,
            "by": self.options.by,
            "corpus": self.options.corpus,
            "clips": self._fingerprint(),
            "evaluator": evaluator,
            "motions": self.options.motions,
            "tempo": self.options.tempo,
            "styles": list(self.styles),
            "seed": self.options.seed,
        }

    def rng(self, repeat: int, stream: int) -> np.random.Generator:
        """The generator for one purpose in one repeat, the same however many repeats there are."""
        return np.random.default_rng(np.random.SeedSequence(self.options.seed, spawn_key=(repeat, stream)))

    def wishes(self, repeat: int, stream: int = _ASKED) -> list[Wish]:
        """What is asked for in a repeat: styles evenly, any content, any clip of the style."""
        rng = self.rng(repeat, stream)
        count = self.options.motions if stream == _ASKED else CONTENTS_OF_DIVERSITY
        styles = rng.permutation(np.resize(np.array(self.styles), count))
        of = {style: [i for i, clip in enumerate(self.styled) if clip.style == style] for style in self.styles}
        return [
            Wish(
                int(rng.integers(len(self.contents))), str(style), int(rng.choice(of[str(style)])),
                int(rng.integers(2**62)),
            )
            for style in styles
        ]  # fmt: skip

    def content(self, wish: Wish) -> Motion:
        """The motion as it is, at most `LONGEST` frames of it, at the origin and facing +Z at its first."""
        return self.contents[wish.content].motion[:LONGEST].face_front()

    def reference(self, wish: Wish) -> Motion:
        """The clip that gives the style."""
        return self.styled[wish.reference].motion[:LONGEST].face_front()

    def make(self, engine: Any, wish: Wish, count: int = 1) -> list[Motion]:
        """The content in the manner wished for."""
        told: dict[str, Any] = {"count": count, "seed": wish.seed}
        if self.options.tempo and "tempo" in engine.capabilities:
            told["tempo"] = True
        if self.options.by != "prior" and getattr(engine, "styles", ()):
            told["style"] = wish.style
        if self.options.by == "motion":
            told["like"] = self.reference(wish)
        return engine.stylise(self.content(wish), **told)

    # ---- a row, a repeat ----------------------------------------------------------------------------------

    def real_rows(self) -> dict[str, int]:
        """Held-out clips that have the styles by nature."""
        return {REAL: len(self.styled)}

    def drawn(self, row: str, repeat: int) -> _Looked:
        """Clips of the styles wished for, other than those that give the styles where there are others."""
        rng = self.rng(repeat, _REAL)
        chosen = []
        for wish in self.wishes(repeat):
            same = [i for i, clip in enumerate(self.styled) if clip.style == wish.style]
            others = [i for i in same if i != wish.reference] or same
            chosen.append(int(rng.choice(others)))
        for i in chosen[:PHYSICAL]:
            if i not in self._measured:
                self._measured[i] = physical.table(self.styled[i].motion)
        measured = means([self._measured[i] for i in chosen[:PHYSICAL]])
        return _Looked(self._styled("manner", chosen), self._styled("content", chosen), None, measured)

    def generated(self, engine: Any, repeat: int, run: Run) -> _Looked:
        """An engine's motions; of each batch only what was seen is kept."""
        manner, content, poses, measured = [], [], [], []
        wishes = self.wishes(repeat)
        for start in range(0, len(wishes), BATCH):
            made = []
            for wish in wishes[start : start + BATCH]:
                run.ask()
                motion = self.make(engine, wish)[0]
                if not self.options.tempo:
                    poses.append(_distance(self.content(wish), motion))
                made.append(motion.resample(20.0))
                run.tell(1)
            manner.append(self.manners.recognised(made))
            content.append(self.judge.recognised(made))
            measured += [physical.table(motion) for motion in made[: max(0, PHYSICAL - len(measured))]]
        many = []
        for wish in self.wishes(repeat, _MANY):
            run.ask()
            stylings = self.make(engine, wish, STYLIZATION.motions_a_prompt)
            many.append(self.manners.recognised([motion.resample(20.0) for motion in stylings]).features)
            run.tell(len(stylings))
        distance = float(np.mean(poses)) if poses else None
        return _Looked(_joined(manner), _joined(content), distance, means(measured), np.stack(many))

    def measured(self, repeat: int, row: Row, looked: _Looked, began: float) -> Repeat:
        """All figures of motions that were looked at, for one repeat."""
        wishes = self.wishes(repeat)
        figures: dict[str, float] = {}
        if self.options.by != "prior":
            given = self._styled("manner", [wish.reference for wish in wishes])
            wanted = np.array([self.manners.index(wish.style) for wish in wishes])
            figures |= style_scores(looked.manner, wanted, given.features)
        if self.known and row.kind == "made":
            before = self._content([wish.content for wish in wishes])
            shown = np.array([self.judge.index(str(self.contents[wish.content].action)) for wish in wishes])
            figures |= content_scores(looked.content, shown, before.features)
        if looked.poses is not None:
            figures["pose_distance"] = looked.poses
        if looked.many is not None:
            figures["multimodality"] = _spread(looked.many, self.rng(repeat, _PAIRS))
        return Repeat(figures={**figures, **looked.physical}, seconds=round(time.monotonic() - began, 3))

    # ---- what the judges see of real clips ------------------------------------------------------------------

    def _styled(self, what: Literal["manner", "content"], chosen: Sequence[int]) -> Recognised:
        judge = self.manners if what == "manner" else self.judge
        return self._known(what, judge, [clip.motion for clip in self.styled], chosen)

    def _content(self, chosen: Sequence[int]) -> Recognised:
        return self._known("before", self.judge, [clip.motion for clip in self.contents], chosen)

    def _known(self, what: str, judge: Recogniser, motions: Sequence[Motion], chosen: Sequence[int]) -> Recognised:
        """Each clip is looked at once, and alone: what is said of it never depends on what else was drawn."""
        for i in set(chosen):
            if (what, i) not in self._seen:
                seen = judge.recognised([motions[i][:LONGEST].face_front()])
                self._seen[what, i] = seen.features[0], seen.logits[0]
        features, logits = zip(*(self._seen[what, i] for i in chosen), strict=True)
        return Recognised(np.stack(features), np.stack(logits))

    def _fingerprint(self) -> str:
        """Changes with the clips, their order or their frames."""
        digest = hashlib.blake2b(digest_size=8)
        for clip in [*self.contents, *self.styled]:
            digest.update(f"{clip.corpus}/{clip.name}/{clip.style}/{len(clip.motion)};".encode())
            digest.update(clip.motion.translation[-1].tobytes())
        return digest.hexdigest()


def _distance(content: Motion, made: Motion) -> float:
    """Mean angle between the poses of a motion and of what was made of it, radians."""
    content = content.resample(made.fps)
    if abs(len(content) - len(made)) > 1:
        raise MotionloomError(
            f"a motion of {len(content)} frames came back with {len(made)}; this protocol compares them frame by frame."
        )
    frames = min(len(content), len(made))
    return pose_distance(content[:frames], made[:frames])


def _joined(parts: Sequence[Recognised]) -> Recognised:
    return Recognised(np.concatenate([p.features for p in parts]), np.concatenate([p.logits for p in parts]))


def _spread(many: np.ndarray, rng: np.random.Generator) -> float:
    """How far the stylings (M, N, D) of one content in one style lie apart."""
    labels = np.repeat(np.arange(len(many)), many.shape[1])
    return distribution.multimodality(many.reshape(len(labels), -1), labels, STYLIZATION.multimodality_pairs, rng)


def _testable(
    engines: Mapping[str, Any], held: Sequence[Clip], manners: Recogniser
) -> tuple[tuple[str, ...], dict[str, tuple[str, ...]]]:
    """The styles of the table, and why others are not in it."""
    told = [set(engine.styles) for engine in engines.values() if getattr(engine, "styles", ())]
    there = sorted({clip.style for clip in held if clip.style})
    kept = [s for s in there if s in manners.labels and all(s in known for known in told)]
    reasons = {
        "without a held-out clip": sorted(set().union(*told) - set(there)),
        "not known to every engine": [s for s in there if not all(s in known for known in told)],
        "not known to the recogniser": [s for s in there if s not in manners.labels],
    }
    return tuple(kept), {reason: tuple(names) for reason, names in reasons.items() if names}


def _check(engines: Mapping[str, Any], by: By) -> None:
    if not engines:
        raise OutOfRangeError("engines", [], "one or more")
    for name, engine in engines.items():
        missing = {"stylise", WAYS[by]} - set(engine.capabilities)
        if missing:
            able = ", ".join(sorted(engine.capabilities)) or "nothing"
            raise MotionloomError(
                f"{name} cannot be told a style by {by}: it lacks {' and '.join(sorted(missing))} (it can do: {able})."
            )
