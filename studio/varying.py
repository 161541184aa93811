"""What happens when a person makes something of takes: a blend of two, another action from here on, other ways on."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from engines import Motion
from engines.errors import MotionloomError
from studio import tasks, thumbnails
from studio.jobs import Job
from studio.mapping import Mapping
from studio.pinned import Kept, Pinned
from studio.settings import BLEND_STEPS, GenerateSettings
from studio.takes import Take

if TYPE_CHECKING:
    from studio.session import Session

VARIES = frozenset({"interpolate", "transition", "outpaint"})
"""Capabilities of engines with which something is made of takes."""
PICTURES = 7
"""In the strip of what lies between, both ends included."""
_SAME = (
    ("engine", "of different engines"),
    ("variant", "of different models"),
    ("action", "of different actions"),
    ("prompt", "of different prompts"),
    ("style", "of different styles"),
    ("frames", "of different lengths"),
    ("bone_scale", "of bodies of different proportions"),
    ("guidance", "drawn with different guidance"),
)
"""Settings in which two takes have to agree to be blended, and what is said where they do not."""


class Varying:
    """The variations of one session; why one cannot be made is said in the state.

    Args:
        session: whose takes they are made of.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.map = Mapping(session)
        self._between: tuple[str, list[Motion]] = ("", [])
        """What lies between two takes, and which two."""
        state = session.state
        state.param.watch(self._paired, ["blend_from", "blend_to", "takes", "compose_tab"])
        state.param.watch(self._show, "blend_share")
        state.param.watch(self._leave, ["selected", "stage_mode", "project"])

    # ---- between two takes --------------------------------------------------------------------------------

    def sources(self) -> list[Take]:
        """The takes that a blend may begin or end with, newest first."""
        return [take for take in reversed(self.session.state.takes) if not alone(take)]

    def keep(self) -> None:
        """Make a take of what is shown between two."""
        state = self.session.state
        pair, key = self._pair(), self._key()
        if pair is None or self._between[0] != key:
            return
        settings = between_settings(*pair, state.blend_share)
        self.session.keep(
            self._between[1][settings.blend_step], settings, lambda problem: setattr(state, "vary_error", problem)
        )

    def _pair(self) -> tuple[GenerateSettings, GenerateSettings] | None:
        state = self.session.state
        a, b = state.take(state.blend_from), state.take(state.blend_to)
        if not (state.blend_from and state.blend_to and a and b) or apart(a, b) or not (a.settings and b.settings):
            return None
        return a.settings, b.settings

    def _key(self) -> str:
        state = self.session.state
        return f"{state.project} {state.blend_from} {state.blend_to}"

    def _paired(self, *_: Any) -> None:
        """Two takes were chosen, or one of them went: work out what lies between."""
        state = self.session.state
        if state.compose_tab != "vary":
            self._leave()
            return
        a, b = (state.take(key) if key else None for key in (state.blend_from, state.blend_to))
        state.blend_problem = apart(a, b) if a and b else ""
        pair, key = self._pair(), self._key()
        if pair is None:
            state.param.update(blend_ready=False, blend_strip=[], preview=())
        elif key != self._between[0] and not state.blending:
            self._work_out(pair, key)

    def _work_out(self, pair: tuple[GenerateSettings, GenerateSettings], key: str) -> None:
        state = self.session.state
        settings = between_settings(*pair, 0.5)
        state.param.update(blending=True, blend_ready=False, vary_error="", blend_strip=[], preview=())

        def work(_progress: Any, _cancel: Any) -> list[Motion]:
            return tasks.between(settings)

        def show(job: Job) -> None:
            if not job.finished:
                return
            state.blending = False
            if job.status == "failed":
                state.blend_problem = job.error
            elif job.status == "done":
                self._between = (key, job.result)
                if key == self._key():
                    state.blend_ready = True
                    self._show()
                    self._draw(key, job.result)
                else:
                    self._paired()  # others were chosen meanwhile

        self.session.submit("blend", work, show)

    def _draw(self, key: str, motions: list[Motion]) -> None:
        """Pictures of what lies between."""
        state = self.session.state
        places = [round(i * (BLEND_STEPS - 1) / (PICTURES - 1)) for i in range(PICTURES)]

        def work(_progress: Any, _cancel: Any) -> list[str]:
            return [thumbnails.thumbnail(motions[place]) for place in places]

        def show(job: Job) -> None:
            if job.status == "done" and key == self._key():
                state.blend_strip = job.result

        self.session.submit("strip", work, show, lane="still")

    def _show(self, *_: Any) -> None:
        """Show both ends and what lies between them at the slider."""
        state = self.session.state
        key, motions = self._between
        if key != self._key() or self._pair() is None or state.compose_tab != "vary":
            return
        step = round(state.blend_share * (BLEND_STEPS - 1))
        a, b = state.take(state.blend_from), state.take(state.blend_to)
        if a and b:
            state.preview = (
                (a.title, motions[0]), (f"{100 * state.blend_share:.0f} % of the way", motions[step]),
                (b.title, motions[-1]),
            )  # fmt: skip

    def _leave(self, *_: Any) -> None:
        self.session.state.preview = ()

    # ---- from the playhead on -----------------------------------------------------------------------------

    def go_problem(self) -> str:
        """Why the engine cannot go on from a take; empty where it can."""
        state = self.session.state
        able = state.capabilities & {"outpaint", "constraints"}
        return "" if able else f"{state.engine} cannot go on from a start."

    def change_problem(self) -> str:
        """Why the selected take cannot change its action; empty where it can."""
        state, take = self.session.state, self.session.state.take()
        made = take.settings if take else None
        if take is None:
            return ""
        if made is None or not made.action:
            return f"{take.title} has no action that could change."
        if made.constraints or made.blend:
            return f"{take.title} {'is a blend' if made.blend else 'has pins'}; go on from it instead."
        able = made.engine != state.engine or "transition" in state.capabilities
        return "" if able else f"{made.engine} cannot change its action on the way."

    def change(self) -> None:
        """The action of the selected take up to the playhead, and then another."""

        def wanted(take: Take, at: int) -> GenerateSettings:
            made = take.settings
            problem = self.change_problem()
            if problem or made is None:
                raise MotionloomError(problem)
            first, *more = _before(made, at, take.frames)
            then = (*more, (self._action(take), self._frames()))
            return replace(made, frames=first[1], then=then, take=None, count=self._count(), best_of=1)

        self._ask(wanted)

    def go_on(self) -> None:
        """The selected take as it is up to the playhead, and different ways on."""
        state = self.session.state

        def wanted(take: Take, at: int) -> GenerateSettings:
            if self.go_problem():
                raise MotionloomError(self.go_problem())
            usual = GenerateSettings(engine=state.engine)
            kept = Kept.of(take.motion, 0, at, 0, take.title.lower(), state.fps)
            return GenerateSettings(
                engine=state.engine, variant=state.variant, action=self._action(take), frames=at + self._frames(),
                seed=random.randrange(10_000), count=self._count(),
                guidance=state.guidance if "guidance" in state.capabilities else usual.guidance,
                constraints=Pinned(kept=(kept,)),
            )  # fmt: skip

        self._ask(wanted)

    def _ask(self, wanted: Callable[[Take, int], GenerateSettings]) -> None:
        state = self.session.state
        take = state.take()
        state.vary_error = ""
        try:
            if take is None:
                raise MotionloomError("Pick a take first.")
            last = max(1, round(take.duration * state.fps))
            asked = wanted(take, min(max(1, round(state.playhead * state.fps)), last))
        except MotionloomError as problem:
            text = str(problem)
            state.vary_error = text[:1].upper() + text[1:]
        else:
            self.session.ask(asked)

    def _action(self, take: Take) -> str:
        """What is to follow: what was chosen, or what is shown there."""
        state = self.session.state
        known = [action.name for action in state.actions]
        shown = (take.settings.action if take.settings else "") or take.motion.label_at(0) or ""
        action = state.next_action or (shown if shown in known else state.action)
        return " ".join(action.lower().split())

    def _frames(self) -> int:
        return max(1, round(self.session.state.next_seconds * self.session.state.fps))

    def _count(self) -> int:
        return self.session.state.count


def _before(made: GenerateSettings, at: int, length: int) -> list[tuple[str, int]]:
    """The actions of a take of so many frames up to one of them."""
    parts, start = [], 0
    first = length - sum(frames for _action, frames in made.then)
    for action, frames in ((made.action, first), *made.then):
        if start < at:
            parts.append((action, min(frames, at - start)))
        start += frames
    return parts


def alone(take: Take) -> str:
    """Why a take cannot be an end of a blend; empty where it can."""
    made = take.settings
    if made is None:
        return f"{take.title} was imported; only what an engine drew can be blended."
    if made.blend:
        return f"{take.title} is a blend itself."
    if made.then:
        return f"{take.title} is a sequence of actions."
    if made.constraints:
        return f"Something is pinned in {take.title.lower()}."
    if made.best_of > 1:
        return f"{take.title} is the best of {made.best_of} draws; only single draws can be blended."
    return ""


def apart(a: Take, b: Take) -> str:
    """Why two takes cannot be blended; empty where they can."""
    said = alone(a) or alone(b)
    if said or a.settings is None or b.settings is None:
        return said
    if a.number == b.number:
        return "Choose two takes."
    for name, words in _SAME:
        if getattr(a.settings, name) != getattr(b.settings, name):
            return f"{a.title} and {b.title.lower()} are {words}; a blend is between two draws of the same."
    return ""


def between_settings(a: GenerateSettings, b: GenerateSettings, share: float) -> GenerateSettings:
    """The settings of what lies between two takes of the same settings but for seed and place."""
    step = round(share * (BLEND_STEPS - 1)) / (BLEND_STEPS - 1)
    return replace(a, blend={"seed": b.seed, "take": b.take or 1, "share": round(step, 2)})
