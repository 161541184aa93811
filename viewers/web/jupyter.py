"""The player as a Jupyter widget."""

from __future__ import annotations

import base64
import logging
from collections.abc import Sequence
from typing import Any

import anywidget
import traitlets

from engines.errors import MotionloomError
from viewers import bodies
from viewers.bodies.body import Body
from viewers.web.controls import BUNDLE, FROM_BROWSER, OPTIONS, PAYLOADS, Motions, Option, Player, check_option
from viewers.web.standalone import Framed, page

log = logging.getLogger(__name__)


def trait(option: Option) -> traitlets.TraitType:
    """The synchronised trait of an option."""
    default, bounds = option.default, option.bounds or (None, None)
    if option.choices:
        made = traitlets.Enum(option.choices, default, help=option.doc)
    elif isinstance(default, bool):
        made = traitlets.Bool(default, help=option.doc)
    elif isinstance(default, int):
        made = traitlets.Int(default, min=bounds[0], max=bounds[1], help=option.doc)
    elif isinstance(default, float):
        made = traitlets.Float(default, min=bounds[0], max=bounds[1], help=option.doc)
    elif isinstance(default, bytes):
        made = traitlets.Bytes(default, help=option.doc)
    elif isinstance(default, list):
        made = traitlets.List(traitlets.Int(), default, help=option.doc)
    elif isinstance(default, dict):
        made = traitlets.Dict(default_value=default, help=option.doc)
    else:
        made = traitlets.Unicode(default, help=option.doc)
    return made.tag(sync=True)


_Traits: Any = type("_Traits", (anywidget.AnyWidget,), {name: trait(option) for name, option in OPTIONS.items()})


class MotionPlayer(_Traits, Player):
    """Plays motions in a notebook: body, skeleton, ghosts, timeline, all in the browser.

    Every attribute of `Controls` is a trait: set it, or `observe` what the person does.
    """

    _esm = BUNDLE
    height = traitlets.Int(480, min=120, help="Height in pixels.").tag(sync=True)

    def __init__(
        self,
        motions: Motions,
        body: str | Body | None = bodies.DEFAULT,
        labels: Sequence[str] | None = None,
        height: int = 480,
        **options: Any,
    ) -> None:
        known = set(self.trait_names())
        super().__init__(height=height, **{name: check_option(name, value, known) for name, value in options.items()})
        self._body = body
        self.show_motions(motions, labels)

    def picture(self) -> dict[str, str]:
        """The picked motion's poses as `image/png`, base64, for readers without widgets; empty without OpenGL."""
        from viewers import strips

        place = self.selected if 0 <= self.selected < len(self._actors) else 0
        try:
            return {"image/png": base64.b64encode(strips.as_png(self._actors[place].motion)).decode("ascii")}
        except MotionloomError as problem:
            log.info("no picture of the motion: %s", problem)
            return {}

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        """The widget, and a strip of poses where a notebook is read without widgets."""
        bundle = super()._repr_mimebundle_(**kwargs)
        data = bundle[0] if isinstance(bundle, tuple) else bundle  # with or without metadata
        if data is not None:
            data.update(self.picture())
        return bundle

    def __repr__(self) -> str:
        return f"<MotionPlayer of {len(self._actors)} motion{'' if len(self._actors) == 1 else 's'}>"

    def embed(self) -> Framed:
        """The player as it is now, self-contained: for notebooks that are exported and read without a network.

        A widget in an exported notebook loads Jupyter's widget manager from the network; this needs nothing, at
        about 1.5 MB in the notebook for each one shown.
        """
        skipped = (*PAYLOADS, *FROM_BROWSER, "global_keys")
        options = {name: getattr(self, name) for name in OPTIONS if name not in skipped}
        return Framed(page(self._actors, self._body, **options), self.height)
