"""The state of one browser session: parameters only. Views watch and set them; `studio.session` acts on them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import param

from engines.errors import MotionloomError, UnknownLabelError
from studio.pinned import NOTHING, Pinned
from studio.sequence import EMPTY, Sequence
from studio.settings import (
    DEFAULT_ENGINE,
    FORMATS,
    MAX_BEST_OF,
    MAX_COUNT,
    MAX_FRAMES,
    MAX_GUIDANCE,
    MAX_PROMPT,
    MAX_SEED,
    USUAL_FRAMES,
    VIDEO_FORMATS,
    VIEWS,
    ExportSettings,
    GenerateSettings,
    usual_engine,
)
from studio.takes import Take
from studio.wording import counted, duration

TABS = ("action", "text", "style", "sequence", "vary", "character", "import")
"""Of the left panel."""
FIRST_TAB = TABS[0]
LONGEST_PINNED = 200
"""Frames of a motion of which something is pinned, where an engine does not say."""


class StudioState(param.Parameterized):
    """Everything a view may show or change."""

    # ---- the scene ----
    scene = param.String("Untitled scene", doc="Name of the project; part of exported file names.")
    project = param.String("", doc="Key of the project in the library; empty while it is in memory only.")
    saved = param.Selector(
        default="memory", objects=["saved", "unsaved", "memory"], doc="Whether all that was done is in the library."
    )
    saved_note = param.String("", doc="Where it is saved, or why it is not.")
    projects = param.List([], doc="Projects to open, as dicts: key, name, about, found, more.")
    deleted_projects = param.List([], doc="The same of those that can be brought back.")
    projects_search = param.String("", doc="What projects are looked for.")
    theme = param.Selector(default="dark", objects=["dark", "light"], doc="Colours of the page.")

    # ---- what the engine can do (set when it is loaded) ----
    engines = param.Dict({}, doc="Engine name -> line of description.")
    engine = param.String(DEFAULT_ENGINE, doc="The engine asked.")
    variant = param.String("", doc="Its variant; empty for the usual one.")
    variants = param.List([], doc="Variants there are.")
    capabilities = param.ClassSelector(class_=frozenset, default=frozenset(), doc="What the engine can do.")
    actions = param.Parameter((), doc="Actions it knows (engines.actions.Action).")
    styles = param.List([], doc="Styles it knows, by name.")
    max_pinned = param.Integer(MAX_FRAMES, doc="Longest motion it makes where something is pinned, frames.")
    joints = param.List([], doc="Bones whose length can be set, as joint names.")
    fps = param.Number(20.0, doc="Its frames a second.")
    max_frames = param.Integer(MAX_FRAMES, doc="Longest motion it makes.")
    licence = param.String("", doc="Licence of its weights.")
    weights_hash = param.String("", doc="SHA-256 of its weights.")
    engine_ready = param.Boolean(False, doc="Loaded.")

    # ---- what is asked ----
    request = param.Selector(
        default="action", objects=["action", "text", "sequence"], doc="Asked by an action, in words, or block by block."
    )
    action = param.String("walk", doc="What the person does.")
    frames = param.Integer(USUAL_FRAMES, bounds=(2, MAX_FRAMES), doc="Length, frames.")
    as_long = param.Boolean(True, doc="As long as it takes, where the engine finds how long; `frames` then follows.")
    length_known = param.Boolean(True, doc="`frames` is the length that will come.")
    seed = param.Integer(7, bounds=(0, MAX_SEED), doc="Seed of the draw; shown always.")
    seed_locked = param.Boolean(False, doc="Keep the seed from one draw to the next: an identical repeat.")
    count = param.Integer(4, bounds=(1, MAX_COUNT), doc="How many variations are drawn.")
    bone_scale = param.Dict({}, doc="Joint -> factor.")
    style = param.String("", doc="In which manner; empty: any.")
    prompt = param.String("", doc="What is to be seen, in words.")
    guidance = param.Number(3.0, bounds=(0, MAX_GUIDANCE), doc="How strongly the request is followed.")
    best_of = param.Integer(1, bounds=(1, MAX_BEST_OF), doc="So many are drawn for each take; the best is kept.")
    pinned = param.ClassSelector(class_=Pinned, default=NOTHING, doc="What is pinned of the motion to come.")
    tool = param.Selector(default="none", objects=["none", "path", "joint"], doc="What the mouse draws on the stage.")
    playhead = param.Number(0.0, doc="Where the player is, seconds.")
    frame = param.Integer(-1, doc="Frame at which the player stands still; -1 while it plays or shows nothing.")
    pin_error = param.String("", doc="Why the last thing could not be pinned.")

    # ---- the timeline ----
    sequence = param.ClassSelector(class_=Sequence, default=EMPTY, doc="The blocks that the timeline shows.")
    block = param.String("", doc="Id of the block that is picked.")
    sequence_error = param.String("", doc="Why the last change to the blocks could not be made.")
    heard = param.Integer(0, doc="Counts what was done on the timeline, so that it hears of what was refused too.")

    # ---- variations of takes ----
    blend_from = param.String("", doc="Id of the take that a blend begins with.")
    blend_to = param.String("", doc="Id of the one it goes over to.")
    blend_share = param.Number(0.5, bounds=(0, 1), doc="How far, in steps of 0.05.")
    blend_ready = param.Boolean(False, doc="What lies between them is worked out.")
    blend_strip = param.List([], doc="Pictures of what lies between, as data URIs, evenly from end to end.")
    blend_problem = param.String("", doc="Why these two cannot be blended.")
    blending = param.Boolean(False, doc="What lies between is being worked out.")
    preview = param.Parameter((), doc="(name, Motion) pairs shown in place of the takes; empty: the takes.")
    next_action = param.String("", doc="What follows where the playhead is; empty: as before.")
    next_seconds = param.Number(2.0, bounds=(0.1, 600), doc="How long.")
    vary_error = param.String("", doc="Why the last variation could not be made.")

    # ---- takes ----
    takes = param.Parameter((), doc="Every take, oldest first (studio.takes.Take).")
    selected = param.String("", doc="Id of the take that the inspector shows and an export writes.")
    shown = param.List([], doc="Ids of the takes on the stage.")
    compared = param.List([], doc="Ids ticked for comparison.")
    strips = param.Dict({}, doc="What stands under the timeline of the picked take; see `studio.attention`.")
    open_strips = param.String("words", doc="Those of them that are open, by name, commas between.")
    stage_mode = param.Selector(default="all", objects=["all", "one", "compare"], doc="Which takes the stage shows.")
    thumbnails = param.Dict({}, doc="Take id -> picture as a data URI.")
    captions = param.Dict({}, doc="Take id -> what is said of it (studio.captions.Description).")
    describing = param.Boolean(True, doc="Takes that are looked at are put into words.")
    search = param.String("", doc="What is looked for among the takes; see `studio.library.query`.")
    edited = param.Integer(0, doc="Counts the edits that were worked out; takes may look other than before.")
    found: Any = param.List(
        default=None, allow_None=True, doc="Ids of the takes that fit; None while nothing is looked for."
    )
    undo_name = param.String("", doc="What undo takes back.")
    redo_name = param.String("", doc="What redo brings back.")

    # ---- the body ----
    bodies = param.List([], doc="Names of the bodies there are (viewers.bodies.available).")
    body = param.String("anny", doc="The body that takes are shown and exported with.")
    shape = param.Dict({}, doc="Its sliders and their values, those that are not as usual.")
    worn = param.Parameter("anny", doc="That body as the stage wears it: a name, or a viewers.bodies.Body.")
    sliders = param.Parameter((), doc="What can be changed of its shape (viewers.bodies.Slider).")
    body_error = param.String("", doc="Why the body asked for cannot be shown.")

    # ---- which panels are open ----
    compose_tab = param.Selector(default=FIRST_TAB, objects=list(TABS), doc="Tab of the left panel.")
    inspector_tab = param.Selector(
        default="details", objects=["details", "body", "export"], doc="Tab of the inspector."
    )

    # ---- work in progress ----
    generating = param.Boolean(False, doc="A draw is under way.")
    generate_progress = param.Number(0.0, bounds=(0, 1), doc="How far it is.")
    generate_error = param.String("", doc="Why the last draw failed.")
    generate_note = param.String("", doc="What of the last draw's pins could not be met.")
    generate_rate = param.Number(0.0, doc="Frames a second the last draw made; 0 before the first.")
    import_error = param.String("", doc="Why the last import failed.")
    import_status = param.String("", doc="What the last import brought.")
    message = param.String("", doc="One line for the corner of the screen.")

    # ---- export ----
    export_format = param.Selector(default="mp4", objects=list(FORMATS), doc="Kind of file.")
    export_size = param.Parameter((1280, 720), doc="Video size, pixels.")
    export_camera = param.Selector(
        default="follow", objects=["follow", "orbit", "front", "back", "left", "right"], doc="Video camera."
    )
    export_views = param.Selector(default="one", objects=list(VIEWS), doc="Sides that a video shows at once.")
    export_status = param.Selector(
        default="idle", objects=["idle", "queued", "running", "done", "failed", "cancelled"], doc="Of the last export."
    )
    export_progress = param.Number(0.0, bounds=(0, 1), doc="How far the export is.")
    export_error = param.String("", doc="Why it failed.")
    export_name = param.String("", doc="File name of the last export.")
    export_url = param.String("", doc="Where the finished file is, relative to the page.")
    export_bytes = param.Integer(0, doc="Its size.")

    def __init__(self, **values: Any) -> None:
        super().__init__(**{"engine": usual_engine(), **values})
        self.param.watch(self._tab_changed, "compose_tab")

    def _tab_changed(self, event: Any) -> None:
        if event.new in ("action", "text", "sequence"):
            self.request = event.new
        elif self.request == "sequence":  # what else is made of takes and draws is not made of blocks
            self.request = "action"

    def describe(self, engine: Any, variants: Iterable[str] | None = None) -> None:
        """Copy what an engine says about itself; the controls are built from it.

        Args:
            engine: that is loaded.
            variants: between which there is a choice; the engine's own unless given.
        """
        actions, can = tuple(getattr(engine, "actions", ())), frozenset(engine.capabilities)
        known, styles = [action.name for action in actions], [str(style) for style in getattr(engine, "styles", ())]
        wordless = "text" not in can
        self.param.update(
            variant=engine.variant, capabilities=can, actions=actions, styles=styles,
            variants=list(getattr(engine, "variants", ()) if variants is None else variants), fps=float(engine.fps),
            max_frames=int(getattr(engine, "max_frames", MAX_FRAMES)), licence=engine.licence,
            max_pinned=int(getattr(engine, "max_pinned_frames", LONGEST_PINNED)), weights_hash=engine.weights_hash,
            action=self.action if self.action in known or not known else known[0],
            style=self.style if self.style in styles else "",
            tool=self.tool if "constraints" in can else "none",
            request="action" if self.request == "text" and wordless else self.request,
            compose_tab="action" if self.compose_tab == "text" and wordless else self.compose_tab,
            engine_ready=True,
        )  # fmt: skip

    # ---- derived ------------------------------------------------------------------------------------------

    def take(self, take_id: str = "") -> Take | None:
        """The take of that id, or the selected one."""
        wanted = take_id or self.selected
        return next((take for take in self.takes if take.id == wanted), None)

    def generate_settings(self) -> GenerateSettings:
        """What Generate would ask for.

        Raises:
            MotionloomError: something asked is out of range.
        """
        can = self.capabilities
        words = self.request == "text" and "text" in can
        told: dict[str, Any] = {
            "bone_scale": dict(self.bone_scale) if "scale_bones" in can else None,
            "style": self.style if "styles" in can else None,
            "guidance": self.guidance if "guidance" in can else None,
            "best_of": self.best_of if "best_of" in can else None,
            "constraints": self.pinned if "constraints" in can else None,
        }
        told = {name: value for name, value in told.items() if value is not None}
        if self.request == "sequence":
            told = {name: value for name, value in told.items() if name not in ("style", "constraints")}
            frames = min(max(self.sequence.frames(self.fps), 2), MAX_FRAMES)
            return GenerateSettings(
                engine=self.engine, variant=self.variant, frames=frames, count=1, sequence=self.sequence, **told
            )
        return GenerateSettings(
            engine=self.engine, variant=self.variant, action="" if words else " ".join(self.action.lower().split()),
            prompt=" ".join(self.prompt.split()) if words else "", frames=None if self.finds_length else self.frames,
            seed=self.seed, count=self.count, **told,
        )  # fmt: skip

    @property
    def finds_length(self) -> bool:
        """Whether the engine finds how long the motion is; what is pinned lies in one of known length."""
        return self.as_long and "lengths" in self.capabilities and not self.pinned

    def say_length(self, frames: int) -> None:
        """A person says how long; as near to it as the engine goes."""
        self.param.update(frames=max(2, min(self.max_frames, frames)), as_long=False)

    def expect(self, frames: int) -> None:
        """The length that will come where the engine finds it, frames; 0 where that is not known before."""
        known = {"frames": min(max(frames, 2), MAX_FRAMES)} if frames else {}
        self.param.update(length_known=frames > 0, **known)

    def export_settings(self) -> ExportSettings:
        """How an export would be written."""
        width, height = self.export_size if self.export_format in VIDEO_FORMATS else (None, None)
        return ExportSettings(
            (self.export_format,), width, height, None, self.export_camera, self.export_views, body=self.body,
            shape=dict(self.shape),
        )  # fmt: skip

    def problem(self) -> str:
        """Why Generate cannot be pressed; empty when it can."""
        if not self.engine_ready:
            return "The engine could not be loaded." if self.generate_error else "Loading the engine…"
        said = self._request_problem()
        if said or self.request == "sequence":
            return said
        try:
            asked = self.generate_settings()
        except MotionloomError as error:
            return str(error)
        if self.frames > self.max_frames and not self.finds_length:
            return f"This engine makes at most {self.max_frames / self.fps:g} s."
        if asked.constraints and self.frames > self.max_pinned:
            return f"With something pinned, a motion lasts at most {self.max_pinned / self.fps:g} s."
        return asked.constraints.problem(self.frames, self.fps)

    def _request_problem(self) -> str:
        """What is wrong with the action, the words or the blocks."""
        if self.request == "sequence":
            return self._sequence_problem()
        if self.request == "text" and "text" in self.capabilities:
            if not self.prompt.strip():
                return "Describe the motion."
            return f"A prompt has at most {MAX_PROMPT:,} letters." if len(self.prompt) > MAX_PROMPT else ""
        if not self.action.strip():
            return "Choose an action."
        nearest = ", ".join(f"“{name}”" for name in self.nearest_actions())
        return f"“{self.action}” is not an action this engine knows. Nearest: {nearest}." if nearest else ""

    def _sequence_problem(self) -> str:
        """What is wrong with the blocks."""
        if not self.sequence:
            return "Drag actions onto the timeline, or press them."
        for number, block in enumerate(self.sequence.blocks, 1):
            if block.engine:
                continue
            if block.kind == "prompt" and "text" not in self.capabilities:
                return f"Block {number} is described in words, which this engine does not read."
            nearest = self.nearest_actions(block.what) if block.kind == "action" else []
            if nearest:
                names = ", ".join(f"“{name}”" for name in nearest)
                return f"Block {number}: “{block.what}” is not an action this engine knows. Nearest: {names}."
        return ""

    def nearest_actions(self, action: str | None = None) -> list[str]:
        """Known actions most like one, the one typed unless given, when that one is not known."""
        known = [action.name for action in self.actions]
        typed = " ".join((self.action if action is None else action).lower().split())
        if not typed or typed in known or not known:
            return []
        return UnknownLabelError("action", typed, known).nearest

    def forecast(self) -> str:
        """One line on what Generate will bring."""
        if self.request == "sequence":
            frames = self.sequence.frames(self.fps)
            rate = f" · {_seconds(frames / self.generate_rate)} on this machine" if self.generate_rate > 0 else ""
            blocks = counted(len(self.sequence.blocks), "block")
            return f"{blocks} · {duration(self.sequence.seconds)} · {frames:,} frames{rate}"
        known = self.length_known or not self.finds_length
        length = f"{self.frames} frames" if known else "as long as it takes"
        text = f"{self.count} × {length} at {self.fps:g} fps"
        tries = self.best_of if "best_of" in self.capabilities else 1
        text += f" · the best of {tries} each" if tries > 1 else ""
        if self.generate_rate > 0 and known:
            seconds = self.count * self.frames * tries / self.generate_rate
            text += f" · {_seconds(seconds)} on this machine"
        return text


def _seconds(value: float) -> str:
    if value < 0.095:
        return "under 0.1 s"
    return f"about {value:.1f} s" if value < 9.95 else f"about {value:.0f} s"
