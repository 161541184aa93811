"""The app's own components: a class each, its script and style in `studio/assets/`. Parameters only, no logic."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import param
from panel.custom import JSComponent

ASSETS = Path(__file__).resolve().parent.parent / "assets"


@cache
def read_asset(name: str) -> str:
    """The text of a file in `studio/assets/`."""
    return (ASSETS / name).read_text(encoding="utf-8")


def _script(name: str) -> str:
    return read_asset("dom.js") + read_asset(f"{name}.js")


def _style(name: str) -> list[str]:
    return [read_asset("base.css"), read_asset(f"{name}.css")]


class Part(JSComponent):
    """A component whose script sends `{do: ..., ...}` messages; `on(do, act)` says who listens."""

    _esm = "export function render() {}"

    def on(self, what: str, act: Any) -> Part:
        """Call `act(message)` for each message of that kind. Returns itself."""

        def heard(event: Any) -> None:
            if isinstance(event.data, dict) and event.data.get("do") == what:
                act(event.data)

        self.on_msg(heard)
        return self


class Page(Part):
    """Colours, shortcuts, help, the line in the corner, the address."""

    theme = param.String("dark")
    message = param.String("")
    title = param.String("motionloom")
    about = param.String("")
    address = param.Dict({}, doc="Parts of the page's address, by name; those that are empty are left out.")
    cookie = param.String("", doc="Cookie that holds the open project; empty: none.")
    _esm = _script("page")
    _stylesheets = _style("page")


class TopBar(Part):
    """Name of the project, whether it is saved, undo and redo, import, export, colours, help."""

    scene = param.String("")
    saved = param.String("memory")
    saved_note = param.String("")
    undo_name = param.String("")
    redo_name = param.String("")
    theme = param.String("dark")
    _esm = _script("topbar")
    _stylesheets = _style("topbar")


class ProjectList(Part):
    """The projects in a dialog: open, new, delete, bring back; and why something is not saved."""

    projects = param.List([], doc="Dicts: key, name, about, found [{id, text}], more.")
    deleted = param.List([], doc="The same of those deleted.")
    current = param.String("")
    search = param.String("")
    saved = param.String("memory")
    saved_note = param.String("")
    _esm = _script("projects")
    _stylesheets = _style("projects")


class Tags(Part):
    """Words given to the selected take."""

    words = param.List([])
    known = param.List([], doc="Tags that other takes have.")
    take = param.String("", doc="Its title; empty: there is none.")
    _esm = _script("tags")
    _stylesheets = _style("tags")


class Segments(Part):
    """One of several, side by side."""

    options = param.List([], doc="(value, text) pairs.")
    value = param.String("")
    label = param.String("", doc="What is chosen, for screen readers.")
    role = param.String("radiogroup", doc="radiogroup or tablist.")
    _esm = _script("segments")
    _stylesheets = _style("segments")


class Check(Part):
    """A box to tick."""

    value = param.Boolean(False)
    label = param.String("")
    _esm = _script("check")
    _stylesheets = _style("check")


class ActionField(Part):
    """The action asked for, with what is wrong with it."""

    value = param.String("")
    names = param.List([], doc="Every action there is to ask for.")
    description = param.String("")
    error = param.String("")
    nearest = param.List([])
    _esm = _script("action_field")
    _stylesheets = _style("action_field")


class Prompt(Part):
    """The motion in words."""

    value = param.String("")
    limit = param.Integer(1000)
    understood = param.String("", doc="What the engine makes of it.")
    _esm = _script("prompt")
    _stylesheets = _style("prompt")


class Lengths(Part):
    """How long motions of the prompt may be."""

    seconds = param.List([], doc="Lengths, ascending.")
    chances = param.List([], doc="Of each.")
    words = param.String("")
    likeliest = param.Number(0.0)
    asked = param.Number(0.0, doc="The length that is asked, seconds.")
    _esm = _script("lengths")
    _stylesheets = _style("lengths")


class Examples(Part):
    """Prompts that fill the field."""

    examples = param.List([])
    _esm = _script("examples")
    _stylesheets = _style("examples")


class Constraints(Part):
    """What is pinned of the motion to come, and what pins it."""

    items = param.List([], doc="(key, words) of everything pinned.")
    tool = param.String("none", doc="What the mouse draws on the stage: none, path, joint.")
    loop = param.Boolean(False)
    ready = param.Boolean(False, doc="There is a take to pin something of.")
    joints = param.List([], doc="Joints that can be pinned.")
    error = param.String("")
    _esm = _script("constraints")
    _stylesheets = _style("constraints")


class Vary(Part):
    """What can be made of takes: a blend of two, or other ways on from the playhead."""

    section = param.Selector(default="blend", objects=["blend", "later"], doc="Which of both.")
    sources = param.List([], doc="Dicts id, text: takes that may be blended.")
    first = param.String("")
    second = param.String("")
    share = param.Number(0.5)
    strip = param.List([], doc="Pictures from one to the other.")
    between = param.Boolean(False, doc="What lies between is there.")
    problem = param.String("")
    mixing = param.Boolean(False)
    selected = param.String("")
    actions = param.List([], doc="Names of what may follow.")
    action = param.String("")
    seconds = param.Number(2.0)
    count = param.Integer(4)
    at = param.String("", doc="Where the playhead is.")
    busy = param.Boolean(False)
    error = param.String("")
    change_problem = param.String("")
    go_problem = param.String("")
    _esm = _script("vary")
    _stylesheets = _style("vary")


class Sequence(Part):
    """Blocks for the timeline."""

    take = param.String("", doc="Title of the picked take; empty: none.")
    words = param.Boolean(False, doc="The engine reads descriptions.")
    blocks = param.Integer(0)
    about = param.String("")
    how = param.String("", doc="How blocks are made.")
    error = param.String("")
    _esm = _script("sequence")
    _stylesheets = _style("sequence")


class DrawMap(Part):
    """Many draws as points; a place among them is chosen and kept."""

    title = param.String("")
    about = param.String("", doc="What a map shows, said while there is none.")
    subject = param.String("", doc="What it is of; empty: none is drawn yet.")
    names = param.List([], doc="What each draw is called; draws of one name have one colour.")
    asked = param.String("", doc="What a new one would be of.")
    problem = param.String("", doc="Why none can be drawn.")
    points = param.List([], doc="[x, y] of each draw, 0 to 1, y upwards.")
    pictures = param.List([], doc="A picture of each; empty until it is drawn.")
    at = param.Parameter((), doc="(x, y) of the place chosen; empty: none.")
    ends = param.List([], doc="Indices of the draws it lies between.")
    line = param.List([], doc="[x, y] of what lies between them.")
    words = param.String("")
    busy = param.Boolean(False)
    progress = param.Number(0.0)
    error = param.String("")
    _esm = _script("draw_map")
    _stylesheets = _style("draw_map")


class ActionGrid(Part):
    """The actions, or the styles, to choose from."""

    noun = param.String("action")
    actions = param.List([], doc="Dicts: name, description, group, picture (address or empty).")
    value = param.String("")
    adds = param.Boolean(False, doc="A press puts a block on the timeline, and cards can be dragged there.")
    _esm = _script("action_grid")
    _stylesheets = _style("action_grid")


class Length(Part):
    """How long a motion is, and whether that is left to what is asked."""

    seconds = param.Number(3.0)
    most = param.Number(600.0, doc="Seconds the engine makes at most.")
    found = param.Boolean(True, doc="It is left to what is asked.")
    finds = param.Boolean(False, doc="The engine can find it.")
    pinned = param.Boolean(False, doc="Something is pinned, so that it has to be said.")
    _esm = _script("length")
    _stylesheets = _style("length")


class Seed(Part):
    """The seed and its lock."""

    value = param.Integer(0)
    locked = param.Boolean(False)
    _esm = _script("seed")
    _stylesheets = _style("seed")


class Manner(Part):
    """How much of a manner, and how what is made is shown."""

    strength = param.Number(1.0)
    most = param.Number(1.0)
    feet = param.Boolean(True)
    tempo = param.Boolean(False)
    timed = param.Boolean(False, doc="The engine can be told the tempo.")
    _esm = _script("manner")
    _stylesheets = _style("manner")


class Generate(Part):
    """The button, the line under it, the progress."""

    busy = param.Boolean(False)
    progress = param.Number(0.0)
    problem = param.String("", doc="Why the button is disabled.")
    named = param.Boolean(False, doc="That is already said above, where the action is typed.")
    label = param.String("Generate", doc="What the button says.")
    forecast = param.String("")
    error = param.String("")
    note = param.String("", doc="What of the last draw's pins could not be met.")
    doing = param.String("", doc="What is being done, said under the bar.")
    _esm = _script("generate")
    _stylesheets = _style("generate")


class TakeGallery(Part):
    """The takes as cards."""

    takes = param.List([], doc="Dicts as `studio.views.takes.card` makes them.")
    search = param.String("")
    found: Any = param.List(default=None, allow_None=True, doc="Ids that fit the search; None: all.")
    selected = param.String("")
    compared = param.List([])
    shown = param.List([], doc="Ids on the stage, in its order.")
    palette = param.List([], doc="Colours of the stage, in its order.")
    thumbnails = param.Dict({})
    busy = param.Boolean(False)
    _esm = _script("takes")
    _stylesheets = _style("takes")


class Upload(Part):
    """Import by choosing or dropping a file; pieces arrive as messages."""

    active = param.Boolean(True, doc="Takes what is dropped on the page.")
    text = param.String("Drop a motion file here, or anywhere on the page")
    label = param.String("Motion file", doc="What is chosen, for screen readers.")
    compact = param.Boolean(False, doc="In one line.")
    accept = param.List([])
    limit = param.Integer(0)
    error = param.String("")
    status = param.String("")
    _esm = _script("upload")
    _stylesheets = _style("upload")


class Portrait(Part):
    """A person in a picture: landmarks to drag, a silhouette to paint."""

    picture = param.String("", doc="Data URI; empty: none.")
    size = param.List([1, 1], doc="Of the picture itself, pixels: width, height.")
    names = param.List([], doc="[name, words] of each landmark.")
    bones = param.List([], doc="[name, name] of each line between two.")
    points = param.Dict({}, doc="Name -> [x, y], pixels.")
    mask = param.String("", doc="Data URI of a picture whose transparency is the silhouette.")
    changes = param.Integer(0, doc="How many corrections there are to take back.")
    _esm = _script("portrait")
    _stylesheets = _style("portrait")


class Cast(Part):
    """The characters that are kept."""

    names = param.List([])
    worn = param.String("")
    error = param.String("")
    _esm = _script("cast")
    _stylesheets = _style("cast")


class BodyPanel(Part):
    """The body that takes are shown with, and the bones of those to come."""

    bodies = param.List([], doc="Dicts name, text.")
    body = param.String("")
    sliders = param.List([], doc="Of its shape, dicts: name, text, ends, low, high, step, usual, value.")
    bones = param.List([], doc="The same of bones; empty: the engine takes no lengths.")
    error = param.String("")
    note = param.String("")
    _esm = _script("body")
    _stylesheets = _style("body")


class ExportBox(Part):
    """The export under way and its outcome."""

    status = param.String("idle")
    progress = param.Number(0.0)
    error = param.String("")
    file = param.String("")
    url = param.String("")
    bytes = param.Integer(0)
    ready = param.Boolean(False)
    label = param.String("Export")
    _esm = _script("export")
    _stylesheets = _style("export")


class StageBar(Part):
    """Which takes the stage shows."""

    mode = param.String("all")
    together = param.Integer(0, doc="Takes of the same draw.")
    ticked = param.Integer(0, doc="Takes ticked for comparison.")
    _esm = _script("stage_bar")
    _stylesheets = _style("stage_bar")
