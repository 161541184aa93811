"""The widget itself: controls beside the player, and the chosen take for the cells below."""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets

from engines import Motion
from engines.errors import MotionloomError
from studio import captions
from studio.captions import NOTHING_SAID, Description
from studio.notebook.controls import WIDTH, Ties, controls, field, note
from studio.notebook.maker import Maker
from studio.pinning import as_shown
from studio.settings import GenerateSettings
from studio.takes import Take
from viewers.web.player import MotionPlayer
from viewers.web.standalone import Framed, page

_WELCOME = "Press Generate: the takes appear here, side by side. A click picks one."


class Panel(widgets.HBox):
    """An engine's controls and the player, for a notebook; see `studio.notebook.panel`.

    Drawing goes on beside the cells. `motion` and `motions` wait for a draw that is under way.

    Args:
        engine: name of an engine, or one that is loaded.
        height: of the player, pixels.
        settings: what the controls begin with; see `studio.notebook.maker.BEGIN`.
    """

    def __init__(self, engine: Any = "", height: int = 480, **settings: Any) -> None:
        self.maker = Maker(engine, **settings)
        self.player: MotionPlayer | None = None
        self._height = height
        self._ids: list[str] = []
        self._showing = False
        ties = Ties(self.maker)
        self._welcome = widgets.HTML(note(_WELCOME), layout={"margin": "12px"})
        self._stage = widgets.VBox(
            [self._welcome], layout={"flex": "1 1 420px", "min_width": "0", "margin": "0 0 0 8px"}
        )
        self._takes = field(widgets.Dropdown, "Take", options=[("none yet", "")])
        self._about = widgets.HTML()
        side = widgets.VBox(controls(self.maker), layout={"width": WIDTH, "flex": "0 0 auto", "overflow": "hidden"})
        super().__init__([side, self._stage], layout={"flex_flow": "row wrap", "align_items": "flex-start"})
        ties.act(self._takes, self._chosen)
        ties.follow(["takes", "selected", "captions"], self._show)

    def __repr__(self) -> str:
        return f"<Panel of {self.maker.engine.name}: {len(self.maker.takes)} takes>"

    # ---- for the cells below ------------------------------------------------------------------------------

    @property
    def motion(self) -> Motion:
        """The chosen take.

        Raises:
            MotionloomError: there is none yet, or the draw waited for failed.
        """
        return self.take.motion

    @property
    def motions(self) -> list[Motion]:
        """The takes drawn together with the chosen one, in order; errors as of `motion`."""
        return [take.motion for take in self._there()]

    @property
    def take(self) -> Take:
        """The chosen take with its settings and measures; errors as of `motion`."""
        there = self._there()
        return next(take for take in there if take.id == self.maker.state.selected)

    @property
    def settings(self) -> GenerateSettings:
        """What made the chosen take: these settings make it again; errors as of `motion`."""
        made = self.take.settings
        assert made is not None  # nothing is imported here
        return made

    @property
    def words(self) -> Description:
        """What is said of the chosen take: its sentence, and how well its prompt is met; errors as of `motion`."""
        take = self.take
        known = self.maker.captioning.of(take)
        prompt = take.settings.prompt if take.settings else ""
        return known if known != NOTHING_SAID else captions.describe([take.motion], [prompt])[0]

    def generate(self) -> Panel:
        """Press the button. Returns the panel, so that `panel.generate().wait()` reads well.

        Raises:
            MotionloomError: what the controls say cannot be asked.
        """
        self.maker.generate()
        return self

    def wait(self, timeout: float | None = None) -> Panel:
        """Block until no draw is under way. Returns the panel.

        Raises:
            MotionloomError: the draw failed, or is not done after `timeout` seconds.
        """
        if not self.maker.wait(timeout):
            raise MotionloomError(f"the draw is not done after {timeout:g} s; wait longer, or cancel() it.")
        if self.maker.state.generate_error:
            raise MotionloomError(self.maker.state.generate_error)
        return self

    def cancel(self) -> None:
        """Stop the draw under way."""
        self.maker.cancel()

    def embed(self) -> Framed:
        """The player with these takes, self-contained, for an exported notebook that is read without a network."""
        there = self._there()
        labels = [take.title for take in there]
        return Framed(page([take.motion for take in there], labels=labels if len(there) > 1 else None), self._height)

    def _there(self) -> tuple[Take, ...]:
        self.maker.wait()
        there = self.maker.drawn
        if not there:
            failed = self.maker.state.generate_error
            raise MotionloomError(failed or "there is no take yet: press Generate, or call panel.generate().")
        return there

    # ---- what is shown ------------------------------------------------------------------------------------

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        """The widget; and the chosen take's poses for whoever reads the notebook without widgets."""
        bundle = super()._repr_mimebundle_(**kwargs)
        if bundle is not None and self.player is not None:
            bundle.update(self.player.picture())
        return bundle

    def _show(self) -> None:
        """Show the takes drawn with the chosen one, and pick it."""
        state, there = self.maker.state, self.maker.drawn
        if not there:
            return
        self._showing = True  # a new list of options picks its first
        options = [(f"{take.title} · {take.subject[:32]}", take.id) for take in state.takes[::-1]]
        if options != list(self._takes.options):
            self._takes.options = options
        self._takes.value = state.selected
        self._showing = False
        ids = [take.id for take in there]
        if ids != self._ids:
            self._ids = ids
            motions, names = [take.motion for take in there], [take.title for take in there]
            if self.player is None:
                self.player = self._make(motions, names)
                self._stage.children = [self.player, self._takes, self._about]
            else:
                self.player.show_motions(motions, names)
        if self.player is not None:
            self.player.selected = ids.index(state.selected)
        take = state.take()
        self._about.value = note(_words(take, self.maker.captioning.of(take))) if take else ""

    def _make(self, motions: list[Motion], names: list[str]) -> MotionPlayer:
        state, ties = self.maker.state, Ties(self.maker)
        player = MotionPlayer(motions, labels=names, height=self._height, playing=True)
        ties.tie(player, "tool", "tool")
        ties.tie(player, "open_strips", "open_strips")
        ties.follow(["strips"], lambda: setattr(player, "strips", state.strips))
        pinning = "constraints" in state.capabilities
        ties.follow(
            ["pinned", "fps"], lambda: setattr(player, "pinned", as_shown(state.pinned, state.fps) if pinning else {})
        )
        ties.act(player, self._picked, "selected")
        ties.act(player, self._moved, "frame")
        ties.act(player, self._drawn, "drawn")
        return player

    def _chosen(self, take_id: str) -> None:
        if not self._showing:
            self.maker.choose(take_id)

    def _picked(self, place: int) -> None:
        if 0 <= place < len(self._ids):
            self.maker.choose(self._ids[place])

    def _moved(self, frame: int) -> None:
        if self.player is not None:
            self.maker.state.playhead = frame / self.player.motions[0].fps

    def _drawn(self, what: dict[str, Any]) -> None:
        pins = self.maker.pins
        if what.get("kind") == "path":
            pins.path(what["points"])
        elif what.get("kind") == "joint":
            pins.joint(what["joint"], what["place"], what["frame"] / what["fps"])


def _words(take: Take, said: Description) -> str:
    """What is said of a take, its length, seed and measures, in a line."""
    from studio import quality, wording

    if take.settings is None:
        return ""
    parts = [wording.duration(take.duration), f"seed {take.settings.seed}"]
    measures = [*said.prompt_measure(), *quality.measures(take.metrics)]
    line = " · ".join(parts + [f"{m.name.lower()} {m.text}" for m in measures])
    return f"{said.sentence} · {line}" if said.sentence else line
