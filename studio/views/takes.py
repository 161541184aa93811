"""The takes: a gallery by draw, newest first."""

from __future__ import annotations

from typing import Any

from studio.quality import measures
from studio.session import Session
from studio.takes import Take
from studio.views.binding import follow, tie
from studio.views.parts import TakeGallery
from studio.wording import duration
from viewers.scene import PALETTE


def gallery(session: Session) -> TakeGallery:
    """The cards and what can be done with them."""
    state = session.state
    part = TakeGallery(palette=list(PALETTE), sizing_mode="stretch_both", margin=0)
    tie(
        part, state, selected="selected", compared="compared", shown="shown", thumbnails="thumbnails",
        busy="generating", search="search", found="found",
    )  # fmt: skip
    follow(part, state, ["takes"], lambda: {"takes": [card(take) for take in state.takes]})
    acts = {
        "compare": session.compare,
        "delete": session.delete,
        "again": session.again,
        "clear": lambda _id: session.clear(),
        "favourite": lambda take_id: session.toggle(take_id, "favourite"),
        "accepted": lambda take_id: session.toggle(take_id, "accepted"),
    }
    for what, act in acts.items():
        part.on(what, lambda message, act=act: act(str(message.get("id", ""))))
    return part


def card(take: Take) -> dict[str, Any]:
    """What the gallery shows of a take."""
    seconds = duration(take.duration)
    drawn = take.settings
    line = f"seed {drawn.seed} · {drawn.take} of {drawn.count}" if drawn else f"{take.frames:,} frames"
    return {
        "id": take.id,
        "title": take.title,
        "subject": take.subject,
        "about": f"{drawn.count} × {seconds}" if drawn else f"imported · {seconds}",
        "line": line,
        "group": take.group,
        "measures": [
            {"name": m.name, "text": m.text, "real": m.real, "level": m.level, "word": m.word}
            for m in measures(take.metrics)
        ],
        "favourite": take.favourite,
        "accepted": take.accepted,
        "again": drawn is not None,
        "tags": list(take.tags),
    }
