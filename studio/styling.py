"""What happens when a person puts a take in another manner: in a style, like another take, by chance, off a map."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import param
from jaxtyping import Float

from engines import Motion, registry
from studio import edits, tasks
from studio.given import Given
from studio.jobs import Job
from studio.mapping import DRAWS, Mapping
from studio.settings import A_SURPRISE, MAX_COUNT, MAX_SEED, MAX_STRENGTH, GenerateSettings
from studio.takes import Take
from studio.wording import counted, duration

if TYPE_CHECKING:
    from studio.session import Session

WAYS = ("style", "like", "chance", "map")
"""How the manner is said."""
CLEAN = ("feet",)
"""What a take in another manner is shown with, unless told otherwise; see `studio.edits`."""


class StylingState(param.Parameterized):
    """What a view of the tab shows and changes."""

    engine = param.String("", doc="The engine asked; empty: none has weights.")
    variant = param.String("", doc="Its variant; empty for the usual one.")
    variants = param.List([], doc="Variants there are.")
    capabilities = param.ClassSelector(class_=frozenset, default=frozenset(), doc="What it can do.")
    styles = param.List([], doc="Styles it knows, by name.")
    fps = param.Number(30.0, doc="Its frames a second.")
    ready = param.Boolean(False, doc="Loaded.")
    source = param.String("", doc="Id of the take that is put in another manner.")
    way = param.Selector(default="style", objects=list(WAYS), doc="How the manner is said.")
    style = param.String("", doc="The style.")
    like = param.String("", doc="Id of the take whose manner is taken.")
    strength = param.Number(1.0, bounds=(0, MAX_STRENGTH), doc="How much of it.")
    count = param.Integer(1, bounds=(1, MAX_COUNT), doc="How many.")
    tempo = param.Boolean(False, doc="Whether the take becomes as fast as the style is.")
    feet = param.Boolean(True, doc="Whether what is made is shown with standing feet held.")
    error = param.String("", doc="Why the engine cannot be had.")


class Styling:
    """The manners of one session's takes.

    Args:
        session: whose takes they are.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.state = StylingState(engine=next(iter(registry.stylisers()), ""))
        self.map = StyleMap(session)
        self._known = ""
        session.state.param.watch(self._load, "compose_tab")
        session.state.param.watch(self._look, "compose_tab")
        self.state.param.watch(self._look, "way")
        session.state.param.watch(self._follow, "selected")
        session.state.param.watch(self._left, "takes")
        self.state.param.watch(self._load, "variant")
        self.state.param.watch(lambda _: self.map.forget(), ["source", "variant"])

    # ---- what is asked ------------------------------------------------------------------------------------

    def open(self, take_id: str) -> None:
        """Show the tab with a take."""
        if take_id in self.session.takes:
            self.state.source = take_id
            self.session.state.compose_tab = "style"

    def refer(self, take: Take) -> None:
        """Take the manner from a take."""
        self.state.param.update(way="like", like=take.id)

    def wants_a_file(self) -> bool:
        """Whether a file that is dropped is one to take the manner from."""
        return self.session.state.compose_tab == "style" and self.state.way == "like"

    def take(self) -> Take | None:
        """The take that is put in another manner."""
        return self.session.takes.get(self.state.source)

    def problem(self) -> str:
        """Why nothing can be made; empty where it can."""
        state = self.state
        if self.take() is None:
            return "Generate or import a motion first."
        if not state.ready:
            return state.error or "Loading the engine…"
        if state.way == "style" and state.style not in state.styles:
            return "Choose a style."
        if state.way == "like" and self.session.takes.get(state.like) is None:
            return "Choose a take, or drop a file, to take the manner from."
        return ""

    def forecast(self) -> str:
        """One line on what will come."""
        take = self.take()
        if take is None:
            return ""
        taken = {"style": self.state.style, "like": f"as in {self.state.like.replace('-', ' ')}"}
        manner = taken.get(self.state.way, A_SURPRISE)
        return f"{counted(self.state.count, 'take')} of {duration(take.duration)} · {manner} × {self.state.strength:g}"

    def request(self, seed: int) -> Callable[[], GenerateSettings]:
        """What makes up the settings of all that is chosen, off the page's thread; there has to be a take."""
        state, source = self.state, self.take()
        assert source is not None
        like = self.session.takes.get(state.like) if state.way == "like" else None
        made = GenerateSettings(
            engine=state.engine, variant=state.variant, action="", seed=seed, count=state.count,
            strength=state.strength, style=state.style if state.way == "style" else "",
            tempo=state.tempo and "tempo" in state.capabilities,
        )  # fmt: skip

        def prepare() -> GenerateSettings:
            given = _given(source, state.fps)
            told, first = source.settings, source.motion.label_at(0) or ""
            return replace(
                made, given=given, like=like and _given(like, state.fps), frames=given.frames,
                action=told.action if told else first, prompt=told.prompt if told else "",
            )  # fmt: skip

        return prepare

    def stylise(self) -> None:
        """Put the take in the manner chosen; a seed that is not locked is changed first."""
        state = self.session.state
        if state.generating or self.state.way == "map" or self.problem():
            return
        if not state.seed_locked:
            state.seed = random.randrange(10_000)
        prepare = self.request(state.seed)
        state.generate_error = ""

        def show(job: Job) -> None:
            if job.status == "failed":
                state.generate_error = job.error
            elif job.status == "done":
                self.session.ask(job.result)

        self.session.submit("prepare", lambda _progress, _cancel: prepare(), show)

    # ---- what comes of it ---------------------------------------------------------------------------------

    def edits(self, asked: GenerateSettings) -> tuple[str, ...]:
        """What takes of these settings are shown with."""
        return CLEAN if asked.given and self.state.feet else ()

    def beside(self, made: Sequence[Take]) -> None:
        """Show takes beside the one that they are another manner of, in sync."""
        given = made[0].settings.given if made[0].settings else None
        if given is None or made[0].id not in self.session.takes:
            return
        sources = [take.id for take in self.session.takes if _words(take) == given.source]
        if sources:
            self.session.compare_these([sources[-1], *(take.id for take in made)])

    # ---- plumbing -----------------------------------------------------------------------------------------

    def _follow(self, *_: Any) -> None:
        """A take that is picked is the next to be put in another manner; what came of that is only looked at."""
        picked = self.session.state.take()
        if picked is not None and (picked.settings is None or picked.settings.given is None):
            self.state.source = picked.id

    def _left(self, *_: Any) -> None:
        """What was chosen is gone."""
        if self.take() is None:
            self.state.source = self.session.state.selected
        if self.state.like not in self.session.takes:
            self.state.like = ""

    def _look(self, *_: Any) -> None:
        """On the stage stands what the map stands at, or the takes."""
        if self.session.state.compose_tab == "style":
            self.session.state.preview = ()
            if self.state.way == "map":
                self.map.show()

    def _load(self, *_: Any) -> None:
        """Have the engine, once the tab is opened."""
        state = self.state
        name, variant = state.engine, state.variant
        if self.session.state.compose_tab != "style" or (state.ready and variant == self._known):
            return
        state.param.update(ready=False, error="")

        def show(job: Job) -> None:
            if not job.finished or variant != state.variant:
                return
            if job.status == "failed":
                state.error = job.error
            elif job.status == "done":
                self._describe(job.result)

        self.session.submit(f"load {name}", lambda _progress, _cancel: tasks.load_engine(name, variant), show)

    def _describe(self, engine: Any) -> None:
        """Copy what the engine says about itself into the state; the controls are built from it."""
        self._known = engine.variant
        styles, state = list(engine.styles), self.state
        ways = [way for way in WAYS if styles or way != "style"]
        state.param.update(
            variant=engine.variant, variants=list(engine.variants), capabilities=frozenset(engine.capabilities),
            styles=styles, style=state.style if state.style in styles else "", fps=float(engine.fps), ready=True,
            way=state.way if state.way in ways else ways[0],
        )  # fmt: skip


class StyleMap(Mapping):
    """The map of a take's styles: the take in each of them, and what lies between."""

    tab = "style"

    def problem(self) -> str:
        """Why no map can be drawn; empty where it can."""
        styling = self.session.styling
        state = styling.state
        return "" if state.ready and styling.take() else styling.problem()

    def subject(self) -> str:
        """What a map would be of."""
        return self.session.styling.state.source.replace("-", " ")

    def request(self, seed: int) -> Callable[[], list[GenerateSettings]]:
        """The settings of the draws: each style twice, or draws by chance where there are none."""
        prepare, styles = self.session.styling.request(seed), tuple(self.session.styling.state.styles)

        def asked() -> list[GenerateSettings]:
            plain = replace(prepare(), style="", like=None, strength=1.0, tempo=False, count=2)
            if styles:
                return [replace(plain, style=style) for style in styles]
            return [replace(plain, seed=(seed + more) % MAX_SEED, count=DRAWS // 2) for more in (0, 1)]

        return asked

    def called(self, index: int) -> str:
        """What a draw is called: its style."""
        return self._asked[index].style or super().called(index)

    def seen(self, motions: Sequence[Motion], asked: GenerateSettings) -> Float[np.ndarray, "N D"]:
        """(N, D) style codes; what lies between two styles is seen as of the nearer."""
        engine = tasks.load_engine(asked.engine, asked.variant)
        ends = (asked.style, asked.blend["style"]) if asked.blend else ("", "")
        nearer = [ends[2 * index >= len(motions)] for index in range(len(motions))]
        return np.stack([engine.style_code(motion, name or None) for motion, name in zip(motions, nearer, strict=True)])

    def beside(self) -> tuple[tuple[str, Motion], ...]:
        """The take itself."""
        take = self.session.styling.take()
        motion = self.session.editing.motion(take) if take else None
        return ((take.title, motion),) if take and motion else ()

    def forget(self) -> None:
        """There is no map any more: another take, or another engine."""
        self.cancel()
        self._motions, self._place = [], None
        self.state.param.update(subject="", points=[], pictures=[], names=[], at=(), ends=[], line=[], words="")


def _given(take: Take, fps: float) -> Given:
    """A take as it is shown."""
    return Given.of(edits.apply(take.motion, take.edits), _words(take), fps)


def _words(take: Take) -> str:
    """A take as settings name it."""
    return take.title.lower()
