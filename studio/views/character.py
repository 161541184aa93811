"""Character: a picture, a mesh or a rigged file becomes the body that takes are shown with."""

from __future__ import annotations

from html import escape
from typing import Any

import panel as pn

from engines.character import landmarks
from engines.character.sighting import Sighting
from studio.casting import DRAWN, SHORTEST, TAB, TALLEST, mask_uri
from studio.exchange import UPLOAD_LIMIT
from studio.likeness import MESHES, PICTURES
from studio.session import Session
from studio.views.binding import follow, tie
from studio.views.forms import column, dressed, html, row
from studio.views.parts import Cast, Generate, Portrait, Upload
from viewers.bodies.character import PREFIX

_NEEDED = (
    "<b>One whole person, standing, seen from the front</b>, arms off the body, before a background unlike skin and "
    "clothes. Or a mesh in an A- or T-pose, or a rigged .glb."
)
_PRIVATE = "Pictures stay on the machine that the studio runs on; nothing is sent anywhere."


def character_form(session: Session) -> pn.Column:
    """The file, who is seen in it, name and height, and those that are kept."""
    casting = session.casting
    told = html()
    name = dressed(pn.widgets.TextInput, label="Name", max_length=60)
    tie(name, casting.state, value="called")
    height = dressed(
        pn.widgets.FloatInput, label="Height, m", value=None, start=SHORTEST, end=TALLEST, step=0.01, format="0.00",
        placeholder="not known",
    )  # fmt: skip
    tie(height, casting.state, value="height")
    fields = row(name, height)

    def show(*_: Any) -> None:
        fields.visible = casting.state.found is not None
        told.object = _told(session)

    casting.state.param.watch(show, ["found", "missing"])
    show()
    return column(_upload(session), told, _portrait(session), fields, _cast(session), gap=10)


def _told(session: Session) -> str:
    """Markup: what is needed, or what was seen."""
    state = session.casting.state
    if state.found is None:
        missing = f"<p class='poor'>{escape(state.missing)}</p>" if state.missing else ""
        return f"{missing}<p class='hint'>{_NEEDED}</p><p class='hint'>{_PRIVATE}</p>"
    remarks = "".join(f"<li>{escape(remark[:1].upper() + remark[1:])}</li>" for remark in state.found.remarks)
    return f"<ul class='hint'>{remarks}</ul>" if remarks else ""


def _upload(session: Session) -> Upload:
    """The file, chosen or dropped."""
    casting = session.casting
    part = Upload(
        accept=[*PICTURES, *MESHES], limit=UPLOAD_LIMIT, text="Drop a picture of one person", label="Picture or mesh",
        sizing_mode="stretch_width", margin=0,
    )  # fmt: skip
    tie(part, casting.state, error="error")

    def show() -> dict[str, Any]:
        state = casting.state
        there = state.found is not None
        return {
            "status": f"Looking at {state.looking}…" if state.looking else "",
            "compact": there,
            "text": "or drop another" if there else "Drop a picture of one person",
        }

    follow(part, casting.state, ["looking", "found"], show)
    follow(part, session.state, ["compose_tab"], lambda: {"active": casting.wants_a_file()})
    part.on("piece", casting.receive)
    return part


def _portrait(session: Session) -> Portrait:
    """The picture, with what is seen in it, to be corrected."""
    casting = session.casting
    part = Portrait(
        names=[[name, name.replace("_", " ").capitalize()] for name in DRAWN], bones=[list(b) for b in landmarks.BONES],
        sizing_mode="stretch_width", margin=0,
    )  # fmt: skip
    drawn: list[Any] = [None]

    def show() -> dict[str, Any]:
        seen = casting.state.found
        if not isinstance(seen, Sighting):
            drawn[0] = None
            return {"picture": "", "mask": ""}
        told = {
            "picture": casting.state.picture,
            "size": list(seen.picture.size),
            "points": {name: seen.points[landmarks.index(name)].round(1).tolist() for name in DRAWN},
            "changes": len(casting.state.corrections),
        }
        if seen.mask is not drawn[0]:  # moving joints leaves it as it is
            drawn[0] = seen.mask
            told["mask"] = mask_uri(seen.mask)
        return told

    follow(part, casting.state, ["found", "corrections", "picture"], show)
    part.on("move", lambda message: casting.move(str(message.get("landmark")), message["to"]))
    part.on("paint", lambda message: casting.paint(message["points"], message["radius"], bool(message["adds"])))
    part.on("undo", lambda _: casting.undo())
    return part


def _cast(session: Session) -> Cast:
    """The characters that are kept."""
    casting = session.casting
    part = Cast(sizing_mode="stretch_width", margin=0)
    tie(part, casting.state, names="characters", error="list_error")
    follow(part, session.state, ["body"], lambda: {"worn": session.state.body.removeprefix(PREFIX)})
    part.on("wear", lambda message: casting.wear(str(message.get("name", ""))))
    part.on("delete", lambda message: casting.delete(str(message.get("name", ""))))
    part.on("rename", lambda message: casting.rename(str(message.get("name", "")), str(message.get("to", ""))))
    return part


def character_button(session: Session) -> Generate:
    """The button, what is being done, and how far it is."""
    state, casting = session.state, session.casting
    button = Generate(label="Make the character", sizing_mode="stretch_width", margin=0)
    tie(button, casting.state, busy="making", progress="progress", error="make_error", doing="words")

    def show() -> dict[str, Any]:
        return {
            "problem": casting.problem(),
            "forecast": casting.forecast(),
            "visible": state.compose_tab == TAB and casting.state.found is not None,
        }

    follow(button, casting.state, ["found", "called", "characters"], show)
    follow(button, state, ["compose_tab"], show)
    button.on("generate", lambda _: casting.make())
    button.on("cancel", lambda _: casting.cancel())
    return button
