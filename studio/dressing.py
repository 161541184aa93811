"""The body that takes are shown with: which one, its shape, and how it is kept with the project."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from engines.errors import MotionloomError
from studio.jobs import Job

if TYPE_CHECKING:
    from studio.session import Session
    from viewers.bodies import Body

NAMED = ("anny", "stick")
"""Bodies that viewers fit to a motion by name, as long as their shape is the usual one."""


class Dressing:
    """The body of one session's project.

    What the project says comes through `follow`; what a person does goes to the project as a step, and comes back the
    same way, so that undo needs nothing of its own.

    Args:
        session: whose takes are shown.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._loaded: dict[str, Body] = {}
        """Bodies as they come, by name; those of files are read once a session."""
        self._kept: Mapping[str, Any] = {}
        """What the project said last."""
        self._worn: tuple[str, Mapping[str, float]] = (_usual(), {})
        """The body that the stage wears, and its shape."""

    @property
    def settled(self) -> bool:
        """Whether the stage wears what the project says: no slider is being dragged, no file being read."""
        said = self.session.takes.store.body
        return self._worn == (said.get("name", _usual()), said.get("shape", {}))

    # ---- what a person does -------------------------------------------------------------------------------

    def wear(self, name: str) -> None:
        """Another body, in its usual shape."""
        if name in self.session.state.bodies:
            self._keep(name, {}, f"wear {name}")

    def renew(self, name: str = "") -> None:
        """Bodies came, went or changed; the one of that name is read anew when it is worn."""
        from viewers import bodies

        self._loaded.pop(name, None)
        self.session.state.bodies = list(bodies.available())

    def reshape(self, values: Mapping[str, float], keep: bool = True) -> None:
        """Move sliders of the body.

        Args:
            values: slider -> value; those not named stay where they are.
            keep: as a step of the project; else it is only shown, while the person still moves the slider.
        """
        state = self.session.state
        limits = {slider.name: slider for slider in state.sliders}
        shape = dict(state.shape)
        for name, value in values.items():
            slider = limits.get(name)
            if slider is None:
                continue
            rounded = round(min(max(float(value), slider.low), slider.high), 3)
            shape.pop(name, None)
            if rounded != slider.usual:
                shape[name] = rounded
        if keep:
            self._keep(state.body, shape, f"change {', '.join(values) or 'shape'}")
        else:
            self._show(state.body, shape)

    def reset(self) -> None:
        """The usual shape again."""
        self._keep(self.session.state.body, {}, "reset shape")

    def _keep(self, name: str, shape: Mapping[str, float], what: str) -> None:
        usual = _usual()
        body = {} if name == usual and not shape else {"name": name, "shape": dict(shape)}
        if body == dict(self.session.takes.store.body):
            self._show(name, shape)  # back to where it was before it was dragged
        self.session.takes.dress(body, what)

    # ---- what the project says ----------------------------------------------------------------------------

    def follow(self) -> None:
        """Show the body that the project says, if it says another than before."""
        from viewers import bodies

        state = self.session.state
        said = self.session.takes.store.body
        if state.bodies and said == self._kept:
            return
        self._kept = said
        state.bodies = list(bodies.available())
        self._show(str(said.get("name", bodies.DEFAULT)), said.get("shape", {}))

    def _show(self, name: str, shape: Mapping[str, float]) -> None:
        """Dress the stage, at once where the body is known, else once it was read."""
        state = self.session.state
        state.param.update(body=name, shape=dict(shape), body_error="")
        if name in self._loaded:
            self._put_on()
            return

        def load(_progress: Any, _cancel: Any) -> Body:
            from viewers import bodies

            return bodies.get(name)

        def show(job: Job) -> None:
            if job.status == "done":
                self._loaded[name] = job.result
            if job.finished and state.body == name:
                self._put_on(job.error)

        self.session.submit(f"body {name}", load, show, lane="file")

    def _put_on(self, problem: str = "") -> None:
        """The body that the state names, in its shape; the usual one, and a word on why, where that cannot be."""
        state = self.session.state
        self._worn = state.body, dict(state.shape)
        base = self._loaded.get(state.body)
        worn: Any = _usual()
        if base is not None:
            try:
                shaped = base.shaped(**state.shape)
                worn = state.body if state.body in NAMED and not state.shape else shaped
            except MotionloomError as error:
                problem = str(error)
        sliders = base.sliders if base is not None else ()
        state.param.update(worn=worn, sliders=sliders, body_error=problem)


def _usual() -> str:
    from viewers import bodies

    return bodies.DEFAULT
