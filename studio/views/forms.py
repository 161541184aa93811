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
    # Panel's button for scrolling, never shown here, would take up a gap of its own
    plain = [".scroll-button { display: none; }"]
    return pn.Column(*items, styles={"gap": f"{gap}px"}, stylesheets=plain, margin=0, **options)


def row(*items: Any, gap: int = 8, wrap: int = 0, **options: Any) -> pn.Row:
    """Items beside one another, of equal width; in several lines where each would have fewer than `wrap` pixels."""
    options.setdefault("sizing_mode", "stretch_width")
    for item in items:
        item.styles = {**item.styles, "flex": f"1 1 {wrap}px", "min-width": "0"}
    styles = {"gap": f"{gap}px"} | ({"flex-wrap": "wrap"} if wrap else {})
    return pn.Row(*items, styles=styles, margin=0, **options)


def fold(title: pn.pane.HTML, *items: Any) -> pn.Card:
    """Items under a title that opens and closes; closed at first."""
    return pn.Card(
        *items, header=title, collapsed=True, margin=0,
        sizing_mode="stretch_width", stylesheets=[read_asset("card.css")],
    )  # fmt: skip


def html(text: str = "", **options: Any) -> pn.pane.HTML:
    """A piece of markup in the studio's style."""
    options.setdefault("sizing_mode", "stretch_width")
    return pn.pane.HTML(text, margin=0, stylesheets=[read_asset("base.css"), read_asset("details.css")], **options)
