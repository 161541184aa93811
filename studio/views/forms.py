"""Panel's own widgets in the studio's clothes."""

from __future__ import annotations

from typing import Any

import panel as pn

from studio.views.parts import read_asset


def dressed(widget: type, **options: Any) -> Any:
    """A Panel widget with the studio's style, as wide as its place."""
    options.setdefault("sizing_mode", "stretch_width")
    options.setdefault("margin", 0)
    return widget(stylesheets=[read_asset("widgets.css")], **options)


def column(*items: Any, gap: int = 12, **options: Any) -> pn.Column:
    """Items under one another."""
    options.setdefault("sizing_mode", "stretch_width")
    return pn.Column(*items, styles={"gap": f"{gap}px"}, margin=0, **options)


def row(*items: Any, gap: int = 8, **options: Any) -> pn.Row:
    """Items beside one another, of equal width."""
    options.setdefault("sizing_mode", "stretch_width")
    for item in items:
        item.styles = {**item.styles, "flex": "1 1 0", "min-width": "0"}
    return pn.Row(*items, styles={"gap": f"{gap}px"}, margin=0, **options)


def html(text: str = "", **options: Any) -> pn.pane.HTML:
    """A piece of markup in the studio's style."""
    options.setdefault("sizing_mode", "stretch_width")
    return pn.pane.HTML(text, margin=0, stylesheets=[read_asset("base.css"), read_asset("details.css")], **options)
