"""From measured facts to words: the fields of the verb phrases, and the details that may follow them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engines.datasets.captions import phrases
from engines.datasets.captions.grammar import number, times
from engines.datasets.captions.measure import SIDES, Facts, Side

_EIGHTHS = (
    "forward", "diagonally forward to the left", "to the left", "diagonally backward to the left", "backward",
    "diagonally backward to the right", "to the right", "diagonally forward to the right",
)  # fmt: skip
_STEADY = 0.7
"""Share of the way that must lie in one direction for the direction to be named."""
_ASIDE = math.radians(8)
"""A walk that is meant to go aside and does by more than this is said to, even if it goes forward most of all."""
_TURNS = ((35.0, None), (65.0, "a slight turn"), (120.0, "a quarter turn"), (235.0, "half a turn"),
          (300.0, "three quarters of a turn"), (420.0, "a full turn"))  # fmt: skip
"""Degrees up to which a change of heading has that name."""
_WALKING = (0.75, 1.5)
_RUNNING = (2.0, 3.3)
"""Speeds, m/s, below which one is slow and above which fast."""
_PASSING = 0.25
"""Of one who goes about faster than this, m/s, hands are not what is to be told."""
_AT_ONCE = 8
"""Seconds; what takes longer was not done once."""
_HANDS = (1.1, 3.0)
"""Peak speeds of a hand, m/s, below which it is slow and above which quick."""


@dataclass(frozen=True)
class Details:
    """What may be said beyond the action; every item is true of the motion. Any may be empty."""

    counts: tuple[str, ...]
    speeds: tuple[str, ...]
    durations: tuple[str, ...]
    extras: tuple[str, ...]
    """Participles that follow a comma."""


def fields(facts: Facts, action: str | None) -> dict[str, str]:
    """The words that fill phrases; a field that the motion does not show is missing.

    Args:
        facts: of the motion.
        action: its name in `engines.actions` (or a data set's own), which says whether both hands are meant, or None.
    """
    words = _way(facts, action) | _turning(facts, action) | _hand_fields(facts, action) | _leg_fields(facts, action)
    if facts.distance > 2.0:
        words["across"] = "across the floor"
    if facts.sweep:
        words["sweep"] = f"to the {facts.sweep}"
    if facts.circle:
        words["sense"] = facts.circle
    if 2 <= facts.claps <= 12:
        words["claps"] = times(facts.claps)
    if 2 <= len(facts.thrusts) <= 4:
        words["punches"] = f"{', '.join(facts.thrusts[:-1])} and {facts.thrusts[-1]}"
    if 1 <= facts.bends <= 6:
        words |= {"bends": times(facts.bends)} if facts.bends > 1 else {}
        if not math.radians(30) < facts.bend <= math.radians(50):
            words["depth"] = "deeply" if facts.bend > math.radians(50) else "slightly"
    return words


def hands(facts: Facts, action: str | None) -> tuple[Side, ...]:
    """The hand or hands that act: as measured; where that is not clear, as the action says."""
    said: tuple[Side, ...] = tuple(side for side in SIDES if side in (action or "").split())
    if action is None and facts.speed > _PASSING:
        return ()
    if facts.acting_hand:
        return (facts.acting_hand,)
    if facts.faster_hand:
        return (facts.faster_hand,)
    if len(facts.raised) == 1:
        return facts.raised
    if "both" in (action or "") or action in {"wave goodbye big", "push", "basketball shot", "catch"}:
        return SIDES
    return said if action and action.startswith(("raise", "wave")) else ()


def details(facts: Facts, action: str | None) -> Details:
    """What may be said of count, speed and duration, and what else the body does."""
    return Details(_counts(facts, action), _speeds(facts, action), _durations(facts, action), _extras(facts, action))


def _way(facts: Facts, action: str | None) -> dict[str, str]:
    ahead, left = facts.drift
    straight = math.hypot(ahead, left)
    words: dict[str, str] = {}
    if straight > 0.6 and straight > _STEADY * facts.distance:
        angle = math.atan2(left, ahead)
        words["going"] = _EIGHTHS[round(angle / (math.pi / 4)) % 8]
        if action in {"walk left", "walk right"} and words["going"] == "forward" and abs(angle) > _ASIDE:
            words["going"] = f"forward and slightly to the {'left' if left > 0 else 'right'}"
    if 3 <= facts.steps <= 12 and facts.distance > 0.25 * facts.duration:
        words["steps"] = f"{number(facts.steps)} steps"
    return words


def _turning(facts: Facts, action: str | None) -> dict[str, str]:
    degrees = abs(math.degrees(facts.turn))
    name = next((name for limit, name in _TURNS if degrees < limit), "several turns")
    if name is None:
        return {}
    side = "left" if facts.turn > 0 else "right"
    words = {"turned": f"{name} to the {side}", "turn": f"to the {side}", "turning": f"in a curve to the {side}"}
    if 150 < degrees < 215:
        words["turn"] = f"around to the {side}"
        words["turning"] = f"and turning around to the {side}"
    elif degrees >= 300:
        words["turn"] = words["turning"] = (
            f"around and around to the {side}" if degrees > 600 else f"in a circle to the {side}"
        )
    elif action in {"turn left", "turn right"}:
        words["turning"] = f"around a bend to the {side}"
    return words


def _hand_fields(facts: Facts, action: str | None) -> dict[str, str]:
    acting = hands(facts, action)
    if not acting:
        return {}
    both = len(acting) == 2
    which = "both" if both else f"the {acting[0]}"
    words = {
        "hand": f"{which} hand{'s' if both else ''}", "arm": f"{which} arm{'s' if both else ''}",
        "it": "them" if both else "it",
    }  # fmt: skip
    highest = min(facts.hands[side].highest for side in acting)
    heights = (
        (0.3, "above the head"), (0.12, "to the height of the head"), (-0.12, "to shoulder height"),
        (-0.32, "to chest height"),
    )  # fmt: skip
    height = next((name for limit, name in heights if highest > limit), None)
    if height:
        words["to_height"] = height
        words["over"] = height if height.startswith("above") else height.replace("to ", "at ", 1)
    swings = min(facts.hands[side].swings for side in acting)
    if 2 <= swings <= 12:
        words["swings"] = times(swings)
    return words


def _leg_fields(facts: Facts, action: str | None) -> dict[str, str]:
    words: dict[str, str] = {}
    if facts.kicking_foot and action == "kick":
        words |= {"foot": f"the {facts.kicking_foot} foot", "leg": f"the {facts.kicking_foot} leg"}
    if facts.standing_foot:
        words |= {"standing_foot": f"the {facts.standing_foot} foot", "standing_leg": f"the {facts.standing_foot} leg"}
    if facts.leading_foot:
        words["front_foot"] = f"the {facts.leading_foot} foot"
    if 1 <= facts.jumps <= 12:
        words["jumps"] = times(facts.jumps)
        words["a_jump"] = "a jump" if facts.jumps == 1 else f"{number(facts.jumps)} jumps"
    ahead, left = facts.drift
    if ahead > 0.4 and abs(left) < ahead:
        words["ahead"] = "forward"
    elif facts.distance < 0.4:
        words["ahead"] = "on the spot"
    if 2 <= facts.crouches <= 6 and facts.crouch > 0.15:
        words["crouches"] = times(facts.crouches)
    return words


def _counts(facts: Facts, action: str | None) -> tuple[str, ...]:
    """How often, where it is more than once; what is counted depends on the action."""
    acting = hands(facts, action)
    counted = {
        "squat": facts.crouches, "bow": facts.bends, "clap": facts.claps, "jump": facts.jumps, "hop": facts.jumps,
        "cartwheel": facts.somersaults,
    }.get(action or "")  # fmt: skip
    if action in {"raise left hand", "raise right hand", "raise both hands"} and acting:
        counted = min(facts.hands[side].lifts for side in acting)
    if counted is None or not 2 <= counted <= 12:
        return ()
    return (times(counted), f"{number(counted)} times in a row") if counted > 2 else ("twice", "two times")


def _speeds(facts: Facts, action: str | None) -> tuple[str, ...]:
    if action in phrases.TRAVELLING:
        slow, fast = _RUNNING if action in {"run", "dash", "leap"} else _WALKING
        if facts.speed < slow:
            return ("slowly", "at a slow pace", "at a leisurely pace")
        if facts.speed > fast:
            return ("fast", "at a fast pace", "quickly")
        return ("at a steady pace", "at a normal pace")
    acting = hands(facts, action)
    if not acting or action is None:
        return ()
    peak = max(facts.hands[side].peak_speed for side in acting)
    pace = "slow" if peak < _HANDS[0] else "quick" if peak > _HANDS[1] else None
    if pace is None:
        return ()
    return (f"{pace}ly", f"with {pace} movements" if action in phrases.ONGOING else f"in a {pace} movement")


def _durations(facts: Facts, action: str | None) -> tuple[str, ...]:
    seconds = round(facts.duration)
    if seconds >= 45:
        long = "about a minute" if seconds < 90 else f"about {number(round(seconds / 60))} minutes"
    else:
        long = "about a second" if seconds <= 1 else f"about {number(seconds)} seconds"
    if action in phrases.ONGOING or action is None:
        return (f"for {long}",) if seconds >= 2 else ()
    if seconds > _AT_ONCE:
        return ()
    return (f"in {long}", f"in {long}", f"taking {long}")


def _extras(facts: Facts, action: str | None) -> tuple[str, ...]:
    """Participles true of the whole motion: how steps are, how arms swing, how the trunk is held."""
    extras: list[str] = []
    if action in phrases.TRAVELLING - {"dribble", "leap"}:
        if facts.steps >= 4:
            length = facts.distance / (facts.steps + 0.5)  # the first and last are seen in part
            limits = (0.75, 1.15) if action in {"run", "dash"} else (0.5, 0.8)
            if length < limits[0]:
                extras.append("taking short steps")
            elif length > limits[1]:
                extras.append("taking long strides")
        extras += {True: ["swinging both arms"], False: []}[facts.arm_swing > 0.35]
        if facts.lean > math.radians(18):
            extras += ["leaning forward", "with the upper body bent forward"]
    elif action in phrases.STILL and facts.distance < 0.4 and facts.steps < 3:
        extras += ["standing in place", "while standing still", "without moving the feet"]
    return tuple(extras)
