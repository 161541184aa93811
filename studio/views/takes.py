"""The takes: a gallery by draw, newest first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from studio.captions import NOTHING_SAID, Description
from studio.edits import WORDS
from studio.quality import measures
from studio.session import Session
from studio.settings import GenerateSettings
from studio.takes import Take
from studio.views.binding import follow, tie
from studio.views.parts import TakeGallery
from studio.wording import counted, duration
from viewers.scene import PALETTE


def gallery(session: Session) -> TakeGallery:
    """The cards and what can be done with them."""
    state = session.state
    part = TakeGallery(palette=list(PALETTE), sizing_mode="stretch_both", margin=0)
    tie(
        part, state, selected="selected", compared="compared", shown="shown", thumbnails="thumbnails",
        busy="generating", search="search", found="found",
    )  # fmt: skip
    metrics = session.editing.metrics
    said = session.captioning.of
    follow(
        part, state, ["takes", "edited", "captions"],
        lambda: {"takes": [card(take, metrics(take), said(take)) for take in state.takes]},
    )  # fmt: skip
    acts = {
        "compare": session.compare,
        "delete": session.delete,
        "style": session.styling.open,
        "again": session.again,
        "clear": lambda _id: session.clear(),
        "favourite": lambda take_id: session.toggle(take_id, "favourite"),
        "accepted": lambda take_id: session.toggle(take_id, "accepted"),
    }
    part.on("compare_these", lambda message: session.compare_these([str(take) for take in message.get("ids", ())]))
    for what, act in acts.items():
        part.on(what, lambda message, act=act: act(str(message.get("id", ""))))
    return part


def drawn_from(made: GenerateSettings) -> str:
    """Which draw a take is, in a line."""
    if made.sequence:
        return counted(len(made.sequence.blocks), "block")
    if made.blend:
        return f"{100 * made.blend['share']:.0f} % of the way · seeds {made.seed}, {made.blend['seed']:.0f}"
    return f"seed {made.seed} · {made.take} of {made.count}"


def card(take: Take, metrics: Mapping[str, float], said: Description = NOTHING_SAID) -> dict[str, Any]:
    """What the gallery shows of a take; `metrics` and what is `said` are of the take as it is shown, edits and all."""
    seconds = duration(take.duration)
    drawn = take.settings
    line = drawn_from(drawn) if drawn else f"{take.frames:,} frames"
    return {
        "id": take.id,
        "title": take.title,
        "subject": take.subject,
        "about": f"{1 if drawn.blend else drawn.count} × {seconds}" if drawn else f"imported · {seconds}",
        "line": line,
        "group": take.group,
        "measures": [
            {"name": m.name, "text": m.text, "real": m.real, "level": m.level, "word": m.word}
            for m in [*said.prompt_measure(), *measures(metrics)]
        ],
        "favourite": take.favourite,
        "accepted": take.accepted,
        "again": drawn is not None and not drawn.blend,
        "tags": list(take.tags),
        "caption": said.sentence,
        "edits": [WORDS[name] for name in take.edits if name in WORDS],
    }
