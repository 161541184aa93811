"""(previous, transition, current) triplets of real clips: what MACVAE learns from.

Our clips show one action each, where BABEL's sequences, which the paper learned from, are labelled as they go on. So
triplets are made in two ways:

- **Cut** out of one recording, as it was captured. A repeating action (walk, run, dribble) is cut anywhere: both sides
  have its label. A walk that turns is cut where its yaw rate rises and falls: walk, turn, walk.
- **Joined** from two recordings: one where an action ends, another where one begins, chosen among some dozens as the
  nearest in pose and speed, set behind the first and let in over the transition (`geometry.seams`). Standing up after
  sitting down, a gesture after a gesture (most begin and end upright), a run out of a walk in step come out as good as
  captured. What no two recordings have in common does not: the further apart the poses, the longer the transition,
  but nobody shifts weight in it before a first step, and it takes the place of the action's first frames.

Other recordings of several actions (CMU's "walk forward, backward, sideways") say no times and are not used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from engines import actions as vocabulary
from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.geometry import rotations, seams
from engines.loom.data import action_of
from engines.motion import Motion
from engines.multiact.representation import FPS, encode
from engines.skeletons import SMPL22

PREVIOUS = 12
"""Frames of the previous motion that a triplet holds: all that tells its phase."""
LONGEST = 100
"""Frames of the current action at most."""
SHORTEST = 16
"""... and at least."""
CHUNK = 64
"""Frames of a repeating action at most: generation goes on with it in further steps."""
TRANSITION = (3, 16)
"""Frames of a transition; in a longer one what is left of a run's speed would carry limbs too far."""
VERSION = 2
"""Raised whenever triplets of the same clips change."""
_CUT = 0.3
"""Share of the triplets that are cut, where there are such."""
_MIDWAY = 0.15
"""Share of the exits out of an action that is done once which lie anywhere in it."""
_AT_AN_END = 6
"""Frames from its end, or its beginning, within which an action that is done once is left, or begun."""
_CANDIDATES = 48
"""Entries that are looked at for an exit."""
_FRAMES_A_METRE = 20.0
"""By which a transition is longer than 4 frames, for poses so far apart."""
_JOINTS = [SMPL22.index(name) for name in (
    "pelvis", "spine3", "head", "left_knee", "right_knee", "left_ankle", "right_ankle", "left_elbow", "right_elbow",
    "left_wrist", "right_wrist",
)]  # fmt: skip
_SPEED_COUNTS = 0.15
"""Seconds: a metre a second apart counts as so many metres."""
_TURNS = frozenset({"turn left", "turn right"})
_GO_ON = frozenset(action.name for action in vocabulary.VOCABULARY if action.repeats) - _TURNS
_TURNING = 0.7
"""Radians a second from which on a walk turns, averaged over half a second."""


@dataclass(frozen=True, eq=False)
class Triplets:
    """Triplets one behind the other."""

    frames: np.ndarray
    """(sum of lengths, D) float16 features."""
    starts: np.ndarray
    """(N,) first frame of each."""
    lengths: np.ndarray
    """(N, 2) frames of transition and current action; `PREVIOUS` come before."""
    actions: np.ndarray
    """(N, 2) previous and current action, counted as in `names`."""
    names: tuple[str, ...]
    captured: np.ndarray
    """(N,) bool: cut out of one recording."""

    def __len__(self) -> int:
        return len(self.starts)


@dataclass(frozen=True)
class Source:
    """A stretch of a clip that shows one action, perhaps in the mirror."""

    clip: Clip
    mirrored: bool
    action: str
    end: int
    """One past its last frame; frames count from the clip's first."""
    entries: range
    """Where it may be begun with after another action."""
    exits: range
    """Where it may be left for another one."""

    def motion(self, first: int, last: int) -> Motion:
        """Frames of the clip."""
        part = self.clip.motion[first:last]
        return part.mirror() if self.mirrored else part


def goes_on(action: str) -> bool:
    """Whether an action can be cut anywhere and is still the same: a walk, but not one that turns."""
    return action in _GO_ON


@dataclass(frozen=True)
class Triplet:
    """One, as a motion."""

    motion: Motion
    """`PREVIOUS` frames, the transition, the current action."""
    transition: int
    actions: tuple[str, str]
    captured: bool


def make(clips: Sequence[Clip], count: int, seed: int = 0, balance: float = 0.3) -> Triplets:
    """Triplets of clips and of their mirror images, as features.

    Args:
        clips: house motions at 20 frames a second; those without an action are left aside.
        count: how many.
        seed: of what is drawn.
        balance: an action with n stretches takes part with a chance proportional to n ** balance.

    Raises:
        MotionloomError: no clip shows an action for long enough.
    """
    rng = np.random.default_rng(seed)
    pool = Pool(clips, balance)
    made = [pool.draw(rng) for _ in range(count)]
    rows = [encode(triplet.motion, PREVIOUS - 1).astype(np.float16) for triplet in made]
    names = tuple(sorted({name for triplet in made for name in triplet.actions}))
    return Triplets(
        frames=np.concatenate(rows),
        starts=np.cumsum([0] + [len(row) for row in rows[:-1]]),
        lengths=np.array([(t.transition, len(t.motion) - PREVIOUS - t.transition) for t in made]),
        actions=np.array([[names.index(name) for name in t.actions] for t in made]),
        names=names,
        captured=np.array([t.captured for t in made]),
    )


class Pool:
    """Clips to make triplets of.

    Args:
        clips: as in `make`.
        balance: as there.

    Raises:
        MotionloomError: no clip shows an action for long enough.
    """

    def __init__(self, clips: Sequence[Clip], balance: float = 0.3) -> None:
        self.sources: list[Source] = []
        self.cuts: list[tuple[int, int]] = []
        """Places of two sources that follow on each other in one recording, or twice the same where one is cut."""
        for clip in clips:
            self._add(clip)
        self._looks = [_look(source.motion(0, len(source.clip.motion))) for source in self.sources]
        self.exits, self.entries = _by_action(self.sources, "exits"), _by_action(self.sources, "entries")
        if not self.exits or not self.entries:
            raise MotionloomError(
                f"no clip shows an action for {SHORTEST + TRANSITION[0]} frames; run: motionloom data prepare."
            )
        self._balance = balance

    def draw(self, rng: np.random.Generator) -> Triplet:
        """One triplet, cut or joined."""
        if self.cuts and rng.random() < _CUT:
            return self._cut(rng)
        return self._joined(rng)

    def _add(self, clip: Clip) -> None:
        for mirrored, seen in ((False, clip), (True, clip.mirror())):
            action = action_of(seen)
            if action is None:
                continue
            frames, place = len(clip.motion), len(self.sources)
            if action in _TURNS:
                self._add_turn(clip, mirrored, action)
            elif goes_on(action):
                whole = range(frames - SHORTEST - TRANSITION[0] + 1)
                self.sources.append(Source(clip, mirrored, action, frames, whole, range(PREVIOUS - 1, frames)))
                if len(whole) > PREVIOUS:
                    self.cuts.append((place, place))
            else:
                begin = range(min(_AT_AN_END, frames - SHORTEST - TRANSITION[0] + 1))
                leave = range(max(PREVIOUS - 1, frames - _AT_AN_END), frames)
                self.sources.append(Source(clip, mirrored, action, frames, begin, leave))

    def _add_turn(self, clip: Clip, mirrored: bool, action: str) -> None:
        """Walk, turn and walk, each following on the one before; and all three as one performance of the turn."""
        seen = clip.motion[:].mirror() if mirrored else clip.motion[:]
        first, last = turning(seen)
        place, frames = len(self.sources), len(seen)
        straight = range(first - SHORTEST - TRANSITION[0] + 1)
        self.sources += [
            Source(clip, mirrored, "walk", first, straight, range(PREVIOUS - 1, first)),
            Source(clip, mirrored, action, last, range(0), range(0)),
            Source(clip, mirrored, "walk", frames, range(last, frames - SHORTEST - TRANSITION[0] + 1), range(0)),
            Source(
                clip, mirrored, action, frames, range(min(max(1, first), frames - SHORTEST - TRANSITION[0] + 1)),
                range(max(last, PREVIOUS), frames),
            ),
        ]  # fmt: skip
        self.cuts += [(place, place + 1), (place + 1, place + 2)]

    def _pick(self, held: dict[str, list[int]], rng: np.random.Generator) -> str:
        chance = np.array([len(places) for places in held.values()], dtype=np.float64) ** self._balance
        return list(held)[int(rng.choice(len(chance), p=chance / chance.sum()))]

    def _cut(self, rng: np.random.Generator) -> Triplet:
        first, second = (self.sources[i] for i in self.cuts[int(rng.integers(len(self.cuts)))])
        transition = int(rng.integers(TRANSITION[0], 9))
        at = int(rng.integers(PREVIOUS, first.end - SHORTEST)) if first is second else first.end - transition // 2
        stays = second.end - at - transition
        if at < PREVIOUS or stays < SHORTEST:  # a walk that begins or ends with its turn
            return self._joined(rng)
        length = _some(second, stays, rng)
        motion = first.motion(at - PREVIOUS, at + transition + length)
        return Triplet(motion, transition, (first.action, second.action), captured=True)

    def _joined(self, rng: np.random.Generator) -> Triplet:
        places = self.exits[self._pick(self.exits, rng)]
        leaving = places[int(rng.integers(len(places)))]
        out = self._exit(self.sources[leaving], rng)
        wanted = self._pick(self.entries, rng)
        entering, begin, apart = self._entry(self._looks[leaving][out], wanted, rng)
        source = self.sources[entering]
        transition = int(np.clip((4 + _FRAMES_A_METRE * apart) * rng.uniform(0.8, 1.4), *TRANSITION))
        transition = min(transition, source.end - begin - SHORTEST)
        length = _some(source, source.end - begin - transition, rng)
        before = self.sources[leaving].motion(out - PREVIOUS + 1, out + 1)
        after = behind(before, source.motion(begin, begin + transition + length))
        motion = seams.join(before, after, transition / FPS)
        return Triplet(motion, transition, (self.sources[leaving].action, source.action), captured=False)

    def _exit(self, source: Source, rng: np.random.Generator) -> int:
        """The last frame of an action."""
        anywhere = rng.random() < _MIDWAY
        return int(rng.choice(range(PREVIOUS - 1, source.end) if anywhere else source.exits))

    def _entry(self, look: np.ndarray, action: str, rng: np.random.Generator) -> tuple[int, int, float]:
        """Where an action begins most like what was seen: a source, a frame of it, and how far apart, metres."""
        best = (-1, 0, np.inf)
        places = self.entries[action]
        for place in rng.integers(len(places), size=_CANDIDATES):
            source = self.sources[places[place]]
            begin = source.entries[int(rng.integers(len(source.entries)))]
            apart = float(np.sqrt(np.mean((self._looks[places[place]][begin] - look) ** 2) * 3))
            if apart < best[2]:
                best = (places[place], begin, apart)
        return best


def behind(before: Motion, after: Motion) -> Motion:
    """`after` turned and set down so that it begins a frame behind the end of `before`: same facing, same way on."""
    turned = after.moved(yaw=float(before[-1:].heading[0] - after[:1].heading[0]))
    step = before.translation[-1] - before.translation[max(len(before) - 2, 0)]
    shift = before.translation[-1] + step - turned.translation[0]
    return turned.moved((float(shift[0]), 0.0, float(shift[2])))


def _look(motion: Motion) -> np.ndarray:
    """(T, K, 3) float32 where joints are, and move to, as seen from the root and its facing; metres."""
    back = rotations.yaw_quaternion(-motion.heading)[:, None]
    joints = motion.positions[:, _JOINTS]
    speed = np.gradient(joints, axis=0) * (motion.fps * _SPEED_COUNTS)
    root = motion.positions[:, :1] * np.array([1.0, 0.0, 1.0])
    return np.concatenate([rotations.rotate(back, joints - root), rotations.rotate(back, speed)], axis=1).astype(
        np.float32
    )


def turning(motion: Motion) -> tuple[int, int]:
    """The first frame of a walk at which it turns, and one past the last; (0, 0) where it goes straight on."""
    half = round(FPS / 4)
    rate = np.gradient(motion.heading) * motion.fps
    smooth = np.convolve(np.pad(rate, half, mode="edge"), np.full(2 * half + 1, 1 / (2 * half + 1)), mode="valid")
    turns = np.flatnonzero(np.abs(smooth) > _TURNING)
    return (int(turns[0]), int(turns[-1]) + 1) if len(turns) else (0, 0)


def _by_action(sources: Sequence[Source], what: Literal["entries", "exits"]) -> dict[str, list[int]]:
    """Action -> places of the sources that have some."""
    found: dict[str, list[int]] = {}
    for place, source in enumerate(sources):
        if len(getattr(source, what)):
            found.setdefault(source.action, []).append(place)
    return found


def _some(source: Source, frames: int, rng: np.random.Generator) -> int:
    """How many of the frames that are left of an action are taken: of one that goes on any number, else all."""
    if goes_on(source.action):
        frames = min(frames, int(rng.integers(SHORTEST, CHUNK + 1)))
    return min(frames, LONGEST)
