"""The player as a Panel component."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import param
from panel.custom import AnyWidgetComponent

from viewers import bodies
from viewers.bodies.body import Body
from viewers.web.controls import BUNDLE, OPTIONS, Motions, Option, Player, check_option


def parameter(option: Option) -> param.Parameter:
    """The parameter of an option."""
    common: dict[str, Any] = {"default": option.default, "doc": option.doc}
    if option.choices:
        return param.Selector(objects=list(option.choices), **common)
    kinds: dict[type, Any] = {bool: param.Boolean, int: param.Integer, float: param.Number, bytes: param.Bytes}
    kinds |= {list: param.List, dict: param.Dict}
    kind = kinds.get(type(option.default), param.String)
    if option.bounds:
        common["bounds"] = option.bounds
    return kind(**common)


_metaclass: Any = type(AnyWidgetComponent)
_Parameters: Any = _metaclass(
    "_Parameters",
    (AnyWidgetComponent,),
    {"__module__": __name__, **{name: parameter(option) for name, option in OPTIONS.items()}},
)


class PanelPlayer(_Parameters, Player):
    """Plays motions in a Panel app; the same bundle, options and behaviour as `MotionPlayer`.

    Every attribute of `Controls` is a parameter: set it, or `param.watch` what the person does. For a player that
    fills its column pass `sizing_mode="stretch_both"` and `height=None`.
    """

    _bundle = BUNDLE

    def __init__(
        self,
        motions: Motions,
        body: str | Body | None = bodies.DEFAULT,
        labels: Sequence[str] | None = None,
        height: int | None = 480,
        **options: Any,
    ) -> None:
        if "sizing_mode" not in options and "width" not in options:
            options["sizing_mode"] = "stretch_width"
        known = set(type(self).param)
        super().__init__(height=height, **{name: check_option(name, value, known) for name, value in options.items()})
        self._body = body
        self.show_motions(motions, labels)
