"""A map: many draws as points, like beside like, and what lies between them.

Engines go from one draw to another, so a place on the map stands on the line between two draws near it. `Mapping` is of
an action; `studio.styling` has that of a take's styles.
"""

from __future__ import annotations

import random
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import param
from jaxtyping import Float

from engines import Motion
from engines.errors import Cancelled
from studio import tasks, thumbnails
from studio.jobs import Cancel, Job, Progress
from studio.settings import BLEND_STEPS, MAX_SEED, GenerateSettings

if TYPE_CHECKING:
    from studio.session import Session

DRAWS = 40
"""Points of a map, drawn with two seeds."""
NEAR = 5
"""So many of the draws nearest to a place may be ends of a line that it stands on."""
SNAP = 0.025
"""Nearer to a draw than that, as a share of the map's width, is that draw."""
MARGIN = 0.06
"""Of the map's width, around the outermost draws."""
_POSES = 16
_AT_HAND = 24
_PICTURES_AT_ONCE = 8


@dataclass(frozen=True)
class Place:
    """What a place on the map stands for."""

    first: int
    """The draw it begins with."""
    second: int
    """The one it goes over to; the same where it is that draw."""
    share: float
    """How far, 0 to 1 in steps of 0.05."""


class MapState(param.Parameterized):
    """What a view shows of the map."""

    subject = param.String("", doc="What it is of; empty: none is drawn yet.")
    names = param.List([], doc="What each draw is called.")
    points = param.List([], doc="[x, y] of each draw, 0 to 1, y upwards.")
    pictures = param.List([], doc="A picture of each as a data URI; empty until it is drawn.")
    at = param.Parameter((), doc="(x, y) of the place chosen; empty: none.")
    ends = param.List([], doc="Indices of the draws it lies between; one where it is that draw.")
    line = param.List([], doc="[x, y] of what lies between these two, from end to end; empty until it is worked out.")
    words = param.String("", doc="What is shown, in words.")
    busy = param.Boolean(False, doc="The draws are made.")
    progress = param.Number(0.0, bounds=(0, 1), doc="How many of them.")
    error = param.String("", doc="Why there is no map.")


class Plane:
    """The two directions in which draws differ most, with the map's edges.

    Args:
        rows: (N, D) what they are compared by, as `Mapping.seen` gives it; two or more.
        names: of each; where some share one, the directions are those in which the names differ most.
    """

    def __init__(self, rows: Float[np.ndarray, "N D"], names: Sequence[str] = ()) -> None:
        self._middle = rows.mean(axis=0)
        kinds = [np.array(names) == name for name in dict.fromkeys(names)]
        told = rows if len(kinds) < 3 else np.stack([rows[kind].mean(axis=0) for kind in kinds])
        directions = np.linalg.svd(told - self._middle, full_matrices=False)[2][:2]
        # towards the side where the largest weight is positive, so that the same draws give one map
        largest = np.abs(directions).argmax(axis=1)
        self._directions = directions * np.sign(directions[np.arange(len(directions)), largest])[:, None]
        flat = (rows - self._middle) @ self._directions.T
        self._low, self._size = flat.min(axis=0), np.maximum(np.ptp(flat, axis=0), 1e-6)

    def places(self, rows: Float[np.ndarray, "N D"]) -> Float[np.ndarray, "N 2"]:
        """(N, 2) places of others seen likewise, 0 to 1 within the map."""
        flat = (rows - self._middle) @ self._directions.T
        return MARGIN + (flat - self._low) / self._size * (1 - 2 * MARGIN)


def stands_for(points: Float[np.ndarray, "N 2"], at: Sequence[float]) -> Place:
    """The draw at a place, or the line between two of the nearest draws that passes nearest to it.

    Args:
        points: (N, 2) of the draws.
        at: (x, y).
    """
    here = np.asarray(at, dtype=np.float64)
    away = np.linalg.norm(points - here, axis=1)
    nearest = np.argsort(away, kind="stable")[:NEAR]
    if away[nearest[0]] <= SNAP or len(points) == 1:
        return Place(int(nearest[0]), int(nearest[0]), 0.0)
    best = (np.inf, Place(int(nearest[0]), int(nearest[0]), 0.0))
    for a, b in combinations(nearest.tolist(), 2):
        along = points[b] - points[a]
        share = float(np.clip((here - points[a]) @ along / max(float(along @ along), 1e-12), 0.0, 1.0))
        off = float(np.linalg.norm(points[a] + share * along - here))
        step = round(share * (BLEND_STEPS - 1)) / (BLEND_STEPS - 1)
        best = min(best, (off, Place(a, b, round(step, 2))), key=lambda found: found[0])
    place = best[1]
    if place.share in (0.0, 1.0):
        end = place.first if place.share == 0.0 else place.second
        return Place(end, end, 0.0)
    return place


def poses(motions: Sequence[Motion]) -> Float[np.ndarray, "N D"]:
    """(N, D) joint positions over time in a row each, metres."""
    frames = [np.round(np.linspace(0, len(motion) - 1, _POSES)).astype(int) for motion in motions]
    return np.stack([motion.positions[own].ravel() for motion, own in zip(motions, frames, strict=True)])


class Mapping:
    """The map of an action, of one session.

    Args:
        session: whose takes are made of it; it shows what is chosen in the state's `preview`.
    """

    tab = "vary"
    """Tab of the left panel that has it."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.state = MapState()
        self._asked: list[GenerateSettings] = []
        """What makes each draw."""
        self._motions: list[Motion] = []
        self._plane: Plane | None = None
        self._points = np.zeros((0, 2))
        self._place: Place | None = None
        self._between: OrderedDict[tuple[int, int], tuple[list[Motion], np.ndarray]] = OrderedDict()
        """What lies between two draws, and how it is seen."""
        self._working = False
        self._jobs: list[Job] = []

    # ---- the draws ----------------------------------------------------------------------------------------

    def draw(self) -> None:
        """Make many draws and put them on the map."""
        state, session = self.state, self.session
        if state.busy:
            return
        self.cancel()
        problem = self.problem()
        if problem:
            state.error = problem
            return
        # another map of the same is of other draws, unless the seed is held
        same = not self._motions or session.state.seed_locked
        subject = self.subject()
        request = self.request(session.state.seed if same else random.randrange(10_000))
        state.param.update(busy=True, progress=0.0, error="", words="")

        def work(progress: Progress, cancel: Cancel) -> tuple[list[GenerateSettings], list[Motion], np.ndarray]:
            asked, made = request(), []
            count = sum(settings.count for settings in asked)
            for settings in asked:
                if cancel():
                    raise Cancelled("the map was cancelled")
                before = len(made)
                made += tasks.generate(settings, lambda done, _all, b=before: progress(b + done, count), cancel)
                progress(len(made), count)
            return asked, made, self.seen(made, asked[0])

        def show(job: Job) -> None:
            state.progress = job.fraction
            if not job.finished:
                return
            state.busy = False
            if job.status == "failed":
                state.error = job.error
            elif job.status == "done":
                self._lay_out(subject, *job.result)

        self._jobs = [session.submit(f"map of {subject}", work, show)]

    def cancel(self) -> None:
        """Stop drawing the map, and its pictures."""
        for job in self._jobs:
            job.cancel()

    def problem(self) -> str:
        """Why no map can be drawn; empty where it can."""
        state = self.session.state
        if not state.engine_ready:
            return "Loading the engine…"
        if "interpolate" not in state.capabilities:
            return f"{state.engine} cannot go over from one draw to another."
        if not state.action.strip() or state.nearest_actions():
            return "Choose an action that this engine knows."
        return ""

    def subject(self) -> str:
        """What a map would be of."""
        return " ".join(self.session.state.action.lower().split())

    def request(self, seed: int) -> Callable[[], list[GenerateSettings]]:
        """What makes up the settings of the draws, off the page's thread: here the action with two seeds."""
        settings, action = self.session.state.generate_settings(), self.subject()
        plain = replace(
            GenerateSettings(engine=settings.engine, action=action), variant=settings.variant, frames=settings.frames,
            style=settings.style, guidance=settings.guidance, bone_scale=settings.bone_scale, count=DRAWS // 2,
        )  # fmt: skip
        return lambda: [replace(plain, seed=seed), replace(plain, seed=(seed + 1) % MAX_SEED)]

    def seen(self, motions: Sequence[Motion], asked: GenerateSettings) -> Float[np.ndarray, "N D"]:
        """(N, D) what draws are compared by; called off the page's thread."""
        return poses(motions)

    def called(self, index: int) -> str:
        """What a draw is called."""
        return f"draw {index + 1}"

    def beside(self) -> tuple[tuple[str, Motion], ...]:
        """What is shown beside the place chosen."""
        return ()

    def _lay_out(self, subject: str, asked: list[GenerateSettings], motions: list[Motion], rows: np.ndarray) -> None:
        self._asked = [replace(each, take=take) for each in asked for take in range(1, each.count + 1)]
        names = [self.called(index) for index in range(len(motions))]
        self._motions, self._plane = motions, Plane(rows, names)
        self._points, self._place = self._plane.places(rows), None
        self._between.clear()
        self.state.param.update(
            subject=subject, names=names, points=self._points.round(4).tolist(), pictures=[""] * len(motions), at=(),
            ends=[], line=[], words="",
        )  # fmt: skip
        self._draw_pictures(motions)

    def _draw_pictures(self, motions: list[Motion]) -> None:
        drawn = [""] * len(motions)

        def work(progress: Progress, _cancel: Cancel) -> None:
            for count, motion in enumerate(motions, 1):
                drawn[count - 1] = thumbnails.thumbnail(motion)
                progress(count, len(motions))

        def show(job: Job) -> None:
            there = sum(map(bool, drawn))
            shown = sum(map(bool, self.state.pictures))
            if motions is self._motions and (there - shown >= _PICTURES_AT_ONCE or (job.finished and there > shown)):
                self.state.pictures = list(drawn)

        self._jobs.append(self.session.submit("pictures of the map", work, show, lane="still"))

    # ---- a place on it ------------------------------------------------------------------------------------

    def move(self, x: float, y: float) -> None:
        """Choose a place and show what is there."""
        if not self._motions:
            return
        at = (min(max(float(x), 0.0), 1.0), min(max(float(y), 0.0), 1.0))
        place = stands_for(self._points, at)
        self._place = place
        ends = [place.first] if place.first == place.second else [place.first, place.second]
        self.state.words = self._words(place)
        self.show()
        self.state.param.update(at=at, ends=ends, line=self._line(place))
        self._work_out()

    def keep(self) -> None:
        """Make a take of what is shown."""
        place, motion = self._place, self._shown()
        if place is None or motion is None:
            return
        self.session.keep(motion, self._settings(place), lambda problem: setattr(self.state, "error", problem))

    def _settings(self, place: Place) -> GenerateSettings:
        """What makes the motion at a place again."""
        first = self._asked[place.first]
        if place.first == place.second:
            return first
        second = self._asked[place.second]
        blend: dict[str, Any] = {"seed": second.seed, "take": second.take or 1, "share": place.share}
        return replace(first, blend=blend | ({"style": second.style} if second.given else {}))

    def _words(self, place: Place) -> str:
        first, second = self.called(place.first), self.called(place.second)
        if place.first == place.second:
            return first[:1].upper() + first[1:]
        return f"{100 * place.share:.0f} % from {first} to {second.removeprefix('draw ')}"

    def _shown(self) -> Motion | None:
        """The motion at the place chosen; None while it is worked out."""
        place = self._place
        if place is None:
            return None
        if place.first == place.second:
            return self._motions[place.first]
        between = self._between.get((place.first, place.second))
        return None if between is None else between[0][round(place.share * (BLEND_STEPS - 1))]

    def show(self) -> None:
        """Show it; until it is worked out, the end that is nearer."""
        state, place = self.session.state, self._place
        if place is None or state.compose_tab != self.tab:
            return
        motion = self._shown()
        nearer = self._motions[place.first if place.share <= 0.5 else place.second]
        state.preview = (*self.beside(), (self.state.words, nearer if motion is None else motion))

    def _line(self, place: Place) -> list[list[float]]:
        """Where what lies between two draws would be on the map itself."""
        between = self._between.get((place.first, place.second))
        if between is None or self._plane is None:
            return []
        return self._plane.places(between[1]).clip(0, 1).round(4).tolist()

    def _work_out(self) -> None:
        """Have the engine make what lies between, one pair at a time: the latest that was asked for."""
        place = self._place
        if place is None or self._working or self._shown() is not None:
            return
        pair, asked, motions = (place.first, place.second), self._settings(place), self._motions
        self._working = True

        def work(_progress: Progress, _cancel: Cancel) -> tuple[list[Motion], np.ndarray]:
            made = tasks.between(asked)
            return made, self.seen(made, asked)

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._working = False
            if job.status == "failed":
                self.state.error = job.error
                return
            if job.status == "done" and motions is self._motions:
                self._between[pair] = job.result
                while len(self._between) > _AT_HAND:
                    self._between.popitem(last=False)
            if self._place is not None:
                self.show()
                self.state.line = self._line(self._place)
                self._work_out()

        self.session.submit("between two draws", work, show)
