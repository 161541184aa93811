"""The inspector: what made the selected take, how good it is, how to make it again, and its export."""

from __future__ import annotations

import io
from collections.abc import Mapping
from html import escape
from typing import Any

import panel as pn

from engines import registry
from engines.errors import MotionloomError
from studio import tasks
from studio.captions import NOTHING_SAID, Description
from studio.edits import WORDS
from studio.proportions import proportions
from studio.quality import measures
from studio.session import Session
from studio.settings import A_SURPRISE, GenerateSettings
from studio.takes import Take
from studio.views.binding import follow, tie
from studio.views.body import body_panel
from studio.views.forms import column, dressed, html, row
from studio.views.parts import Check, ExportBox, Segments, Tags
from studio.wording import counted, duration

FORMATS = [
    ("mp4", "MP4"), ("webm", "WebM"), ("gif", "GIF"), ("png", "Strip"), ("bvh", "BVH"), ("glb", "GLB"), ("csv", "CSV"),
    ("npz", "NPZ"), ("amass", "AMASS"),
]  # fmt: skip
SIZES = {
    "mp4": {"1280 × 720": (1280, 720), "1920 × 1080": (1920, 1080), "854 × 480": (854, 480), "720 × 720": (720, 720)},
    "webm": {"1280 × 720": (1280, 720), "1920 × 1080": (1920, 1080), "854 × 480": (854, 480), "720 × 720": (720, 720)},
    "gif": {"480 × 270": (480, 270), "640 × 360": (640, 360), "400 × 400": (400, 400)},
}
CAMERAS = {"Follow": "follow", "Still": "orbit", "Front": "front", "Back": "back", "Left": "left", "Right": "right"}
VIEWS = {"One": "one", "Four: front, side, top, orbit": "four", "All sides": "around"}
MOST_BLOCKS = 12
"""Lines on the blocks of a sequence."""
_ABOUT = {
    "mp4": "Video for players, slides and the web.",
    "webm": "Video for web pages, smaller than MP4.",
    "gif": "Short video that plays anywhere; large for long takes.",
    "png": "Poses side by side in one picture, as papers show motions.",
    "glb": "Body with skin and animation for Blender, game engines and three.js.",
    "csv": "Table of joint positions and rotations for spreadsheets and statistics.",
    "bvh": "Skeleton and rotations for Blender, Maya, Unreal and others.",
    "npz": "motionloom's own: lossless, with labels and all that made it.",
    "amass": "AMASS .npz with SMPL poses, for Python and research tools.",
}


def inspector(session: Session) -> pn.Column:
    """Three tabs: Details, Body and Export."""
    state = session.state
    tabs = Segments(
        options=[("details", "Details"), ("body", "Body"), ("export", "Export")], role="tablist", label="Inspector",
        sizing_mode="stretch_width", margin=0,
    )  # fmt: skip
    tie(tabs, state, value="inspector_tab")
    parts = {"details": _details(session), "body": column(body_panel(session)), "export": _export(session)}

    def show(*_: Any) -> None:
        for name, part in parts.items():
            part.visible = state.inspector_tab == name

    state.param.watch(show, "inspector_tab")
    show()
    return column(tabs, *parts.values())


# ---- details ----------------------------------------------------------------------------------------------


def _details(session: Session) -> pn.Column:
    state = session.state
    text = html()
    save = dressed(
        pn.widgets.FileDownload, callback=lambda: io.StringIO(session.files.settings_file()[1]), filename="take.json",
        label="Save settings file", embed=False,
    )  # fmt: skip

    def show(*_: Any) -> None:
        take = state.take()
        text.object = (
            _described(take, session.editing.metrics(take), session.captioning.of(take))
            if take
            else "<p class='hint'>Pick a take to see what made it.</p>"
        )
        name, _text = session.files.settings_file()
        save.param.update(visible=bool(name), filename=name or "take.json")

    state.param.watch(show, ["selected", "takes", "edited", "captions"])
    show()
    speaks = bool(registry.captioners())
    words = Check(label="Say in words what takes show" if speaks else "Judge how well prompts are met")
    tie(words, state, value="describing")
    return column(_tags(session), text, words, save, gap=8)


def _tags(session: Session) -> Tags:
    """The words given to the selected take."""
    state = session.state
    part = Tags(sizing_mode="stretch_width", margin=0)

    def shown() -> dict[str, Any]:
        take = state.take()
        known = sorted({tag for other in state.takes for tag in other.tags})
        return {"take": take.title if take else "", "words": list(take.tags) if take else [], "known": known}

    follow(part, state, ["selected", "takes"], shown)
    part.on("tags", lambda message: session.tag(state.selected, [str(tag) for tag in message.get("tags", ())]))
    return part


def _described(take: Take, metrics: Mapping[str, float], said: Description) -> str:
    """Markup on a take, or on why its motion cannot be shown."""
    try:
        return describe(take, metrics, said)
    except MotionloomError as problem:
        return f"<section><h4>{take.title}</h4><p class='poor'>{escape(str(problem))}</p></section>"


def describe(take: Take, metrics: Mapping[str, float], said: Description = NOTHING_SAID) -> str:
    """Markup on a take: what it shows, what made it, its quality as it is shown, how to make it again."""
    return _in_words(said) + _made(take) + _unmet(take) + _quality(metrics, said) + _reproduce(take)


def _in_words(said: Description) -> str:
    return f"<section><h4>In words</h4><p class='said'>{escape(said.sentence)}</p></section>" if said.sentence else ""


def _made(take: Take) -> str:
    motion, made = take.motion, take.motion.provenance
    length = f"{motion.frames:,} frames · {motion.fps:g} fps · {duration(motion.duration)}"
    if take.settings is None:
        joints = f"{motion.skeleton.name}, {len(motion.skeleton)} joints"
        rows = {"File": escape(take.source), "Length": length, "Skeleton": escape(joints)}
    else:
        drawn = take.settings
        rows = {
            "Engine": escape(drawn.sequence.engine or " · ".join(filter(None, (drawn.engine, drawn.variant)))),
            "Weights": f"{made.weights[:4]}…{made.weights[-4:]}" if made.weights else "",
            "Action": escape(drawn.action),
            "Prompt": escape(drawn.prompt),
            "Given": escape(drawn.given.source) if drawn.given else "",
            "Style": escape(_style(take)),
            "Pinned": "<br>".join(escape(words) for words in _pinned(drawn, motion.fps)),
            "Then": escape(", ".join(f"{action} {frames / motion.fps:.1f} s" for action, frames in drawn.then)),
            "Blocks": "<br>".join(map(escape, _blocks(drawn))),
            "Seed": "" if drawn.sequence else f"{drawn.seed}<small>{drawn.take} of {drawn.count}</small>",
            "Blend": _blend(drawn),
            "Length": length,
            "Proportions": escape(proportions(drawn.bone_scale)),
            "Guidance": f"{drawn.guidance:g}" if "guidance" in made.parameters else "",
            "Best of": f"{drawn.best_of}" if drawn.best_of > 1 else "",
        }
    rows["Shown with"] = escape(", ".join(WORDS[name].lower() for name in take.edits if name in WORDS))
    return _section(f"What made {take.title.lower()}", rows)


def _blocks(drawn: GenerateSettings) -> list[str]:
    """The blocks of a sequence, a line each; not all of a long one."""
    blocks = drawn.sequence.blocks
    shown = blocks if len(blocks) <= MOST_BLOCKS else blocks[: MOST_BLOCKS - 1]
    lines = [f"{block.what} {block.seconds:g} s{f', {block.style}' if block.style else ''}" for block in shown]
    return lines + ([f"and {len(blocks) - len(shown)} more"] if len(blocks) > len(shown) else [])


def _blend(drawn: GenerateSettings) -> str:
    """How far it lies on the way to another draw."""
    if not drawn.blend:
        return ""
    to = drawn.blend
    return f"{100 * to['share']:.0f} % towards seed {to['seed']:.0f}<small>draw {to['take']:.0f}</small>"


def _style(take: Take) -> str:
    """In which manner, and how much of it."""
    drawn = take.settings
    if drawn is None or drawn.given is None:
        return drawn.style if drawn else ""
    by_chance = take.motion.label_at(0, "style") if drawn.manner == A_SURPRISE else ""
    manner = f"{drawn.manner} ({by_chance})" if by_chance else drawn.manner
    return f"{manner} × {drawn.strength:g}" + (", its tempo too" if drawn.tempo else "")


def _pinned(drawn: GenerateSettings, fps: float) -> list[str]:
    """What was pinned, in words."""
    words = [text for _key, text in drawn.constraints.listed(fps)]
    return [*words, "ends as it began"] if drawn.constraints.loop else words


def _unmet(take: Take) -> str:
    """What of it could not be met, as the engine says it."""
    lines = "".join(f"<p class='fair'>{escape(sentence)}</p>" for sentence in tasks.unmet(take.motion))
    return f"<section><h4>Not met</h4>{lines}</section>" if lines else ""


def _quality(metrics: Mapping[str, float], said: Description) -> str:
    rows = {}
    for measure in [*measures(metrics), *said.measures()]:
        real = f"<small>real {measure.real}</small>" if measure.real else ""
        rows[measure.name] = f"<span class='{measure.level}'>{measure.text}</span>{real}"
    return _section("Quality", rows) if rows else ""


def _reproduce(take: Take) -> str:
    if take.settings is None:
        return ""
    return f"<section><h4>Reproduce</h4><code>motionloom generate --settings {take.id}.json</code></section>"


def _section(title: str, rows: dict[str, str]) -> str:
    """A table under a heading; the values are markup, the empty ones left out."""
    lines = "".join(f"<tr><th scope='row'>{name}</th><td>{value}</td></tr>" for name, value in rows.items() if value)
    return f"<section><h4>{title}</h4><table>{lines}</table></section>"


# ---- export -----------------------------------------------------------------------------------------------


def _export(session: Session) -> pn.Column:
    state = session.state
    kind = Segments(options=FORMATS, label="File format", sizing_mode="stretch_width", margin=0)
    size = dressed(pn.widgets.Select, label="Size", options=SIZES["mp4"])
    camera = dressed(pn.widgets.Select, label="Camera", options=CAMERAS)
    views = dressed(pn.widgets.Select, label="Views", options=VIEWS)
    about = html()
    tie(kind, state, value="export_format")
    tie(size, state, value="export_size")
    tie(camera, state, value="export_camera")
    tie(views, state, value="export_views")
    video = row(size, camera, views, wrap=118)

    def show(*_: Any) -> None:
        sizes = SIZES.get(state.export_format)
        video.visible = sizes is not None
        if sizes and state.export_size not in sizes.values():
            size.options = sizes
            state.export_size = next(iter(sizes.values()))
        about.object = f"<p class='hint' style='margin:0'>{_ABOUT[state.export_format]}</p>"

    state.param.watch(show, "export_format")
    show()
    return column(kind, about, video, _export_box(session))


def _export_box(session: Session) -> ExportBox:
    state = session.state
    box = ExportBox(sizing_mode="stretch_width", margin=0)
    tie(
        box, state, status="export_status", progress="export_progress", error="export_error", file="export_name",
        url="export_url", bytes="export_bytes",
    )  # fmt: skip

    def label() -> dict[str, Any]:
        takes = session.files.chosen()
        name = takes[0].title.lower() if len(takes) == 1 else counted(len(takes), "take") if takes else "a take"
        return {"ready": bool(takes), "label": f"Export {name} as {state.export_format.upper()}"}

    follow(box, state, ["selected", "takes", "compared", "export_format"], label)
    box.on("export", lambda _: session.files.export())
    box.on("cancel", lambda _: session.files.cancel_export())
    return box
