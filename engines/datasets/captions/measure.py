"""What a motion does, in numbers: where it goes, how it turns, which hand or foot acts, how often.

Everything is measured in the body's own frame, so the mirrored motion has the same facts with left and right changed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from engines.geometry.canonical import leg_length
from engines.motion import Motion
from engines.skeletons import SMPL22

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")

_SMOOTHING = 0.08
"""Seconds; standard deviation of the filter before speeds and peaks are read."""
_GAIN = 1.35
"""One limb acts alone if it does this many times as much as the other."""
_STEP_PROMINENCE = 0.12
"""Of the distance between the ankles along the way, in leg lengths."""
_LIFT_PROMINENCE = 0.045
"""Of one ankle's height over the other's, in leg lengths."""
_AIRBORNE = 0.05
"""Both feet this far above where they stand, in leg lengths, is off the ground."""


@dataclass(frozen=True)
class Hand:
    """What one hand does."""

    path: float
    """Metres the wrist goes relative to the chest."""
    peak_speed: float
    """Its highest speed relative to the chest, m/s."""
    highest: float
    """Highest place of the wrist over the shoulder, metres."""
    lifts: int
    """How often the wrist comes up from below to shoulder height or above."""
    swings: int
    """How often the raised wrist swings to a side and back."""
    thrusts: int
    """How often the wrist shoots out from the shoulder."""


@dataclass(frozen=True)
class Facts:
    """A motion in numbers; metres, seconds, radians."""

    motion: Motion

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.motion.duration

    # ---- the way -----------------------------------------------------------------------------------------

    @cached_property
    def distance(self) -> float:
        """Length of the way the pelvis goes over the ground, sway and wobble left out."""
        return float(np.linalg.norm(np.diff(self._way, axis=0), axis=-1).sum())

    @property
    def speed(self) -> float:
        """Mean speed over the ground, m/s."""
        return self.distance / self.duration

    @cached_property
    def still(self) -> bool:
        """Is it one pose, held?"""
        speed = np.linalg.norm(np.diff(self.motion.positions, axis=0), axis=-1) * self.motion.fps
        return bool(len(speed) == 0 or np.quantile(speed.max(axis=1), 0.9) < 0.15)

    @cached_property
    def drift(self) -> tuple[float, float]:
        """Metres gone ahead and to the left, each step seen in the body's heading at that time."""
        steps = np.diff(self._way, axis=0)
        yaw = self.motion.heading[:-1]
        ahead = steps[:, 0] * np.sin(yaw) + steps[:, 1] * np.cos(yaw)
        left = steps[:, 0] * np.cos(yaw) - steps[:, 1] * np.sin(yaw)
        return float(ahead.sum()), float(left.sum())

    @cached_property
    def turn(self) -> float:
        """Change of heading from start to end, positive to the left."""
        yaw = self._smooth(self.motion.heading)
        return float(yaw[-1] - yaw[0])

    @cached_property
    def steps(self) -> int:
        """Steps taken: the times one foot passes the other, or on the spot the times a foot is lifted."""
        left, right = (self._joint(f"{side}_ankle") for side in SIDES)
        apart = left - right
        travelling = self.distance > 0.25 * self.duration
        series = apart[:, 2] if travelling else apart[:, 1]
        limit = (_STEP_PROMINENCE if travelling else _LIFT_PROMINENCE) * self._leg
        return len(_peaks(series, limit)) + len(_peaks(-series, limit))

    # ---- hands ------------------------------------------------------------------------------------------

    @cached_property
    def hands(self) -> dict[Side, Hand]:
        """What each hand does."""
        return {side: self._hand(side) for side in SIDES}

    @cached_property
    def acting_hand(self) -> Side | None:
        """The hand that goes clearly farther than the other, or None if both or neither act."""
        return _greater({side: hand.path for side, hand in self.hands.items()}, 0.3)

    @cached_property
    def faster_hand(self) -> Side | None:
        """The hand that gets clearly faster than the other."""
        return _greater({side: hand.peak_speed for side, hand in self.hands.items()}, 0.5)

    @cached_property
    def raised(self) -> tuple[Side, ...]:
        """The hands that are lifted to the shoulder or above."""
        return tuple(side for side in SIDES if self.hands[side].lifts > 0)

    @cached_property
    def sweep(self) -> Side | None:
        """To which side the acting hand goes in its fastest stretch, if it is sideways."""
        acting = self.acting_hand or self.faster_hand
        if acting is None:
            return None
        wrist = self._wrist(acting)
        speed = np.gradient(wrist, 1 / self.motion.fps, axis=0)
        fastest = int(np.abs(speed[:, 0]).argmax())
        across, others = speed[fastest, 0], np.linalg.norm(speed[fastest, 1:])
        if abs(across) < max(others, 0.5):
            return None
        return "left" if across > 0 else "right"

    @cached_property
    def circle(self) -> Literal["clockwise", "counterclockwise"] | None:
        """Sense in which the acting hand circles in front of the body, as the person sees it."""
        if self.acting_hand is None:
            return None
        wrist = self._wrist(self.acting_hand)
        up = wrist[:, 1] > np.median(wrist[:, 1]) - 0.4
        right, high = -wrist[up, 0], wrist[up, 1]
        right, high = right - right.mean(), high - high.mean()
        area = float((right[:-1] * np.diff(high) - high[:-1] * np.diff(right)).sum() / 2)
        if abs(area) < 0.02:
            return None
        return "counterclockwise" if area > 0 else "clockwise"

    @cached_property
    def arm_swing(self) -> float:
        """How far the hand that swings less goes to and fro along the body, usually, in metres."""
        ahead = [self._wrist(side)[:, 2] for side in SIDES]
        return min(float(np.quantile(z, 0.9) - np.quantile(z, 0.1)) for z in ahead)

    @cached_property
    def claps(self) -> int:
        """Times the hands come together."""
        apart = np.linalg.norm(self._wrist("left") - self._wrist("right"), axis=-1)
        near = apart.min() + 0.5 * (np.quantile(apart, 0.9) - apart.min())
        return sum(apart[peak] < max(near, 0.2) for peak in _peaks(-apart, 0.06))

    @cached_property
    def thrusts(self) -> tuple[Side, ...]:
        """Punches in order of time, each by the hand that throws it."""
        timed: list[tuple[int, Side]] = [(int(peak), side) for side in SIDES for peak in self._thrust_peaks(side)]
        return tuple(side for _, side in sorted(timed, key=lambda item: item[0]))

    # ---- legs and trunk -------------------------------------------------------------------------------------

    @cached_property
    def kicking_foot(self) -> Side | None:
        """The foot that is lifted clearly higher than the other."""
        return _greater({side: float(np.ptp(self._joint(f"{side}_ankle")[:, 1])) for side in SIDES}, 0.15)

    @cached_property
    def standing_foot(self) -> Side | None:
        """The foot stood on while the other is up, for most of the motion's middle."""
        middle = slice(len(self.motion) // 5, -(len(self.motion) // 5) or None)
        lift = self._joint("left_ankle")[middle, 1] - self._joint("right_ankle")[middle, 1]
        up = {"right": float((lift > 0.08).mean()), "left": float((lift < -0.08).mean())}
        side: Side = "right" if up["right"] > up["left"] else "left"
        return side if up[side] > 0.4 and up[side] > 2 * min(up.values()) else None

    @cached_property
    def leading_foot(self) -> Side | None:
        """The foot in front when the pelvis is lowest."""
        low = int(self.motion.positions[:, 0, 1].argmin())
        apart = float((self._joint("left_ankle") - self._joint("right_ankle"))[low, 2])
        return None if abs(apart) < 0.15 else "left" if apart > 0 else "right"

    @cached_property
    def jumps(self) -> int:
        """Times both feet leave the ground together."""
        feet = np.stack([self._joint(f"{side}_foot")[:, 1] for side in SIDES])
        lowest = (feet - np.quantile(feet, 0.1, axis=1, keepdims=True)).min(axis=0)
        return len(_peaks(lowest, _AIRBORNE * self._leg))

    @cached_property
    def crouch(self) -> float:
        """How far the pelvis comes down from its usual height, in leg lengths."""
        height = self.motion.positions[:, 0, 1]
        return float((np.quantile(height, 0.9) - height.min()) / self._leg)

    @cached_property
    def crouches(self) -> int:
        """Times the pelvis comes down and up again."""
        return len(_peaks(-self._smooth(self.motion.positions[:, 0, 1]), max(0.1, 0.5 * self.crouch) * self._leg))

    @cached_property
    def rise(self) -> float:
        """How much higher the pelvis is at the end than at the start, in leg lengths."""
        height = self._smooth(self.motion.positions[:, 0, 1])
        return float((height[-1] - height[0]) / self._leg)

    @cached_property
    def bends(self) -> int:
        """Times the trunk bows forward, by 15 degrees more than before and after, and comes up again."""
        return len(_peaks(self._pitch, np.radians(15)))

    @cached_property
    def bend(self) -> float:
        """Largest forward lean of the trunk."""
        return float(self._pitch.max())

    @cached_property
    def lean(self) -> float:
        """Usual forward lean of the trunk."""
        return float(np.median(self._pitch))

    @cached_property
    def somersaults(self) -> int:
        """Times the head is below the pelvis."""
        over = self._smooth(self.motion.positions[:, 0, 1] - self.motion.positions[:, SMPL22.index("head"), 1])
        return len(find_peaks(np.concatenate([[-1.0], over, [-1.0]]), height=0.0, prominence=0.3)[0])

    # ---- how ------------------------------------------------------------------------------------------------

    def _hand(self, side: Side) -> Hand:
        wrist = self._wrist(side)
        step = np.linalg.norm(np.diff(wrist, axis=0), axis=-1)
        over = wrist[:, 1] - self._local(f"{side}_shoulder", "spine3")[:, 1]
        return Hand(
            path=float(step.sum()),
            peak_speed=float(step.max(initial=0.0) * self.motion.fps),
            highest=float(over.max()),
            lifts=len(find_peaks(np.concatenate([[-1.0], over, [-1.0]]), height=-0.1, prominence=0.3)[0]),
            swings=self._swings(wrist, over),
            thrusts=len(self._thrust_peaks(side)),
        )

    def _swings(self, wrist: np.ndarray, over: np.ndarray) -> int:
        """Turning points to one side of the raised hand's back and forth."""
        up = over > min(-0.25, over.max() - 0.3)
        if up.sum() < 5:
            return 0
        first, last = np.flatnonzero(up)[[0, -1]]
        across = wrist[first : last + 1, 0]
        return max(len(_peaks(across, 0.08)), len(_peaks(-across, 0.08)))

    def _thrust_peaks(self, side: Side) -> np.ndarray:
        reach = self._local(f"{side}_wrist", f"{side}_shoulder")
        return _peaks(np.linalg.norm(reach[:, [0, 2]], axis=-1), 0.18)

    @cached_property
    def _pitch(self) -> np.ndarray:
        """(T,) lean of the trunk to the front."""
        trunk = self._local("neck", "pelvis")
        return np.arctan2(trunk[:, 2], trunk[:, 1])

    @cached_property
    def _way(self) -> np.ndarray:
        """(T, 2) path of the pelvis over the ground, smoothed over a step."""
        return gaussian_filter1d(self.motion.positions[:, 0, [0, 2]], 0.3 * self.motion.fps, axis=0, mode="nearest")

    @cached_property
    def _leg(self) -> float:
        return leg_length(self.motion.skeleton)

    def _wrist(self, side: Side) -> np.ndarray:
        return self._local(f"{side}_wrist", "spine3")

    def _joint(self, joint: str) -> np.ndarray:
        """(T, 3) a joint seen from the ground below the pelvis, in the body's heading: x left, y up, z ahead."""
        places = self._local(joint, "pelvis")
        return places + self._smooth(self.motion.positions[:, 0]) * np.array([0.0, 1.0, 0.0])

    def _local(self, joint: str, origin: str) -> np.ndarray:
        """(T, 3) from one joint to another in the body's heading, smoothed."""
        skeleton = self.motion.skeleton
        apart = self.motion.positions[:, skeleton.index(joint)] - self.motion.positions[:, skeleton.index(origin)]
        yaw = self.motion.heading
        x = apart[:, 0] * np.cos(yaw) - apart[:, 2] * np.sin(yaw)
        z = apart[:, 0] * np.sin(yaw) + apart[:, 2] * np.cos(yaw)
        return self._smooth(np.stack([x, apart[:, 1], z], axis=-1))

    def _smooth(self, values: np.ndarray) -> np.ndarray:
        return gaussian_filter1d(values, _SMOOTHING * self.motion.fps, axis=0, mode="nearest")


def _greater(amounts: dict[Side, float], least: float) -> Side | None:
    """The side with clearly more of it, if that is at least `least`."""
    more: Side = max(SIDES, key=lambda side: amounts[side])
    less: Side = "right" if more == "left" else "left"
    return more if amounts[more] >= least and amounts[more] > _GAIN * amounts[less] else None


def _peaks(series: np.ndarray, prominence: float) -> np.ndarray:
    """Indices of the maxima that stand out by `prominence`."""
    return find_peaks(series, prominence=prominence)[0]
