"""The state of one browser session: parameters only. Views watch and set them; `studio.session` acts on them."""

from __future__ import annotations

import param

from engines.errors import MotionloomError, UnknownLabelError
from studio.settings import FORMATS, MAX_COUNT, MAX_FRAMES, MAX_SEED, VIDEO_FORMATS, ExportSettings, GenerateSettings
from studio.takes import Take


class StudioState(param.Parameterized):
    """Everything a view may show or change."""

    # ---- the scene ----
    scene = param.String("Untitled scene", doc="Name of the scene; part of exported file names.")
    theme = param.Selector(default="dark", objects=["dark", "light"], doc="Colours of the page.")

    # ---- what the engine can do (set when it is loaded) ----
    engines = param.Dict({}, doc="Engine name -> line of description.")
    engine = param.String("action2motion", doc="The engine asked.")
    variant = param.String("", doc="Its variant; empty for the usual one.")
    variants = param.List([], doc="Variants there are.")
    capabilities = param.ClassSelector(class_=frozenset, default=frozenset(), doc="What the engine can do.")
    actions = param.Parameter((), doc="Actions it knows (engines.actions.Action).")
    joints = param.List([], doc="Bones whose length can be set, as joint names.")
    fps = param.Number(20.0, doc="Its frames a second.")
    max_frames = param.Integer(MAX_FRAMES, doc="Longest motion it makes.")
    licence = param.String("", doc="Licence of its weights.")
    weights_hash = param.String("", doc="SHA-256 of its weights.")
    engine_ready = param.Boolean(False, doc="Loaded.")

    # ---- what is asked ----
    action = param.String("walk", doc="What the person does.")
    frames = param.Integer(60, bounds=(2, MAX_FRAMES), doc="Length, frames.")
    seed = param.Integer(7, bounds=(0, MAX_SEED), doc="Seed of the draw; shown always.")
    seed_locked = param.Boolean(False, doc="Keep the seed from one draw to the next: an identical repeat.")
    count = param.Integer(4, bounds=(1, MAX_COUNT), doc="How many variations are drawn.")
    bone_scale = param.Dict({}, doc="Joint -> factor.")

    # ---- takes ----
    takes = param.Parameter((), doc="Every take, oldest first (studio.takes.Take).")
    selected = param.String("", doc="Id of the take that the inspector shows and an export writes.")
    shown = param.List([], doc="Ids of the takes on the stage.")
    compared = param.List([], doc="Ids ticked for comparison.")
    stage_mode = param.Selector(default="all", objects=["all", "one", "compare"], doc="Which takes the stage shows.")
    thumbnails = param.Dict({}, doc="Take id -> picture as a data URI.")
    undo_name = param.String("", doc="What undo takes back.")
    redo_name = param.String("", doc="What redo brings back.")

    # ---- which panels are open ----
    compose_tab = param.Selector(default="action", objects=["action", "import"], doc="Tab of the left panel.")
    inspector_tab = param.Selector(default="details", objects=["details", "export"], doc="Tab of the inspector.")

    # ---- work in progress ----
    generating = param.Boolean(False, doc="A draw is under way.")
    generate_progress = param.Number(0.0, bounds=(0, 1), doc="How far it is.")
    generate_error = param.String("", doc="Why the last draw failed.")
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
    export_status = param.Selector(
        default="idle", objects=["idle", "queued", "running", "done", "failed", "cancelled"], doc="Of the last export."
    )
    export_progress = param.Number(0.0, bounds=(0, 1), doc="How far the export is.")
    export_error = param.String("", doc="Why it failed.")
    export_name = param.String("", doc="File name of the last export.")
    export_url = param.String("", doc="Where the finished file is, relative to the page.")
    export_bytes = param.Integer(0, doc="Its size.")

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
        return GenerateSettings(
            engine=self.engine, variant=self.variant, action=" ".join(self.action.lower().split()),
            frames=self.frames, seed=self.seed, count=self.count, bone_scale=dict(self.bone_scale),
        )  # fmt: skip

    def export_settings(self) -> ExportSettings:
        """How an export would be written."""
        width, height = self.export_size if self.export_format in VIDEO_FORMATS else (None, None)
        return ExportSettings((self.export_format,), width, height, None, self.export_camera)

    def problem(self) -> str:
        """Why Generate cannot be pressed; empty when it can."""
        if not self.engine_ready:
            return "The engine could not be loaded." if self.generate_error else "Loading the engine…"
        if not self.action.strip():
            return "Choose an action."
        try:
            asked = self.generate_settings()
            known = [action.name for action in self.actions]
            if asked.action not in known:
                raise UnknownLabelError("action", self.action, known)
        except UnknownLabelError as error:
            nearest = ", ".join(f"“{name}”" for name in error.nearest)
            return f"“{error.value}” is not an action this engine knows. Nearest: {nearest}."
        except MotionloomError as error:
            return str(error)
        if self.frames > self.max_frames:
            return f"This engine makes at most {self.max_frames / self.fps:g} s."
        return ""

    def nearest_actions(self) -> list[str]:
        """Known actions most like the one typed, when that one is not known."""
        known = [action.name for action in self.actions]
        typed = " ".join(self.action.lower().split())
        if not typed or typed in known or not known:
            return []
        return UnknownLabelError("action", typed, known).nearest

    def forecast(self) -> str:
        """One line on what Generate will bring."""
        text = f"{self.count} × {self.frames} frames at {self.fps:g} fps"
        if self.generate_rate > 0:
            seconds = self.count * self.frames / self.generate_rate
            text += f" · {_seconds(seconds)} on this machine"
        return text


def _seconds(value: float) -> str:
    if value < 0.095:
        return "under 0.1 s"
    return f"about {value:.1f} s" if value < 9.95 else f"about {value:.0f} s"
