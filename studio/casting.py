"""What happens when a person makes a character: whom a file shows is seen, corrected, made a body and worn."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import param
from jaxtyping import Float
from PIL import Image, ImageDraw

from engines.character import landmarks, models
from engines.character.sighting import Sighting
from engines.errors import FormatError, MotionloomError
from studio import likeness
from studio.jobs import Job
from studio.likeness import Likeness
from viewers import bodies
from viewers.bodies import character as kept

if TYPE_CHECKING:
    from studio.session import Session

TAB = "character"
SHORTEST, TALLEST = 0.5, 2.6
"""Metres that a person's height may be said to be."""
SHOWN = 1024
"""Pixels of the longer side of a picture as the page shows it."""
MOST_POINTS = 4000
"""Of one stroke of the brush."""
FOLLOWERS = {
    "nose": tuple(name for name in landmarks.NAMES if re.search("eye|ear|mouth", name)),
    **{f"{side}_wrist": tuple(f"{side}_{name}" for name in ("pinky", "index", "thumb")) for side in ("left", "right")},
}
"""Landmarks that are not drawn, and go with one that is."""
DRAWN = ("nose", *dict.fromkeys(name for bone in landmarks.BONES for name in bone))
"""Landmarks that can be moved."""


@dataclass(frozen=True)
class Moved:
    """A landmark put elsewhere by hand."""

    landmark: str
    to: tuple[float, float]
    """Pixels of the picture."""

    def __call__(self, seen: Sighting) -> Sighting:
        """What is seen, so changed."""
        step = np.asarray(self.to) - seen.points[landmarks.index(self.landmark)]
        for name in (self.landmark, *FOLLOWERS.get(self.landmark, ())):
            x, y = np.clip(seen.points[landmarks.index(name)] + step, 0, seen.picture.size)
            seen = seen.moved(name, (float(x), float(y)))
        return seen


@dataclass(frozen=True)
class Stroke:
    """A stroke of the brush over the silhouette."""

    points: tuple[tuple[float, float], ...]
    """Pixels of the picture."""
    radius: float
    adds: bool
    """To the silhouette; else it takes away."""

    def __call__(self, seen: Sighting) -> Sighting:
        """What is seen, so changed."""
        drawn = Image.new("L", seen.picture.size)
        brush = ImageDraw.Draw(drawn)
        brush.line(self.points, fill=255, width=round(2 * self.radius))
        for x, y in self.points:
            brush.ellipse((x - self.radius, y - self.radius, x + self.radius, y + self.radius), fill=255)
        return seen.painted(np.where(np.asarray(drawn) > 0, np.float32(self.adds), seen.mask))


class CastingState(param.Parameterized):
    """What a view of the tab shows and changes."""

    missing = param.String("", doc="What has to be installed before pictures can be looked at.")
    looking = param.String("", doc="Name of the file that is looked at; empty: none.")
    error = param.String("", doc="Why the last file cannot be used.")
    file = param.String("", doc="Name of the file that is open; empty: none.")
    found = param.Parameter(None, doc="Whom it shows (studio.likeness.Likeness), with what was corrected.")
    picture = param.String("", doc="The picture as a data URI; empty for meshes.")
    corrections = param.Parameter((), doc="What was corrected by hand, in order.")
    called = param.String("", doc="What the character will be called.")
    height: Any = param.Number(None, allow_None=True, bounds=(SHORTEST, TALLEST), doc="Metres; None: not known.")
    making = param.Boolean(False, doc="The character is being made.")
    progress = param.Number(0.0, bounds=(0, 1), doc="How far it is.")
    words = param.String("", doc="What is being done.")
    make_error = param.String("", doc="Why it could not be made.")
    characters = param.List([], doc="Names of those that are kept.")
    list_error = param.String("", doc="Why one of them could not be renamed or deleted.")


class Casting:
    """The characters that one session makes and keeps.

    Args:
        session: whose project wears them.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.state = CastingState()
        self._data = b""
        """The bytes of a mesh, which is read again once its height is said."""
        self._seen: Sighting | None = None
        """As it was before it was corrected."""
        self._job: Job | None = None
        session.state.param.watch(self._look_around, "compose_tab")
        session.state.param.watch(lambda _: self._list(), "bodies")

    # ---- a file -------------------------------------------------------------------------------------------

    def wants_a_file(self) -> bool:
        """Whether a file that is dropped is one to make a character of."""
        return self.session.state.compose_tab == TAB

    def receive(self, message: Mapping[str, Any]) -> None:
        """One piece of a file on its way in; with the last one it is looked at."""
        try:
            whole = self.session.files.arrived(message)
        except FormatError as problem:
            self.state.error = str(problem)
            return
        if whole is not None:
            self.open(*whole)

    def open(self, name: str, data: bytes) -> None:
        """Look at a file that a person brought: who is in the picture, or what mesh it is."""
        state = self.state
        if state.looking or state.making:
            state.error = f"{name}: one at a time; wait for {state.looking or state.called}, or cancel it."
            return
        state.param.update(looking=name, error="", make_error="")

        def work(_progress: Any, _cancel: Any) -> tuple[Likeness, str]:
            found = likeness.find(data, name)
            return found, _picture_uri(found) if isinstance(found, Sighting) else ""

        def show(job: Job) -> None:
            if not job.finished:
                return
            state.param.update(looking="", error=job.error)
            if job.status == "done":
                found, picture = job.result
                self._seen = found if isinstance(found, Sighting) else None
                self._data = b"" if self._seen else data
                state.param.update(
                    file=name, found=found, picture=picture, corrections=(), height=None, called=self._free(name)
                )

        self._job = self.session.submit(f"look at {name}", work, show, lane="file")

    # ---- corrections --------------------------------------------------------------------------------------

    def move(self, landmark: str, to: Sequence[float]) -> None:
        """Put a landmark elsewhere: x and y, pixels of the picture."""
        if landmark in DRAWN:
            x, y = to
            self._correct(Moved(landmark, (float(x), float(y))))

    def paint(self, points: Sequence[Sequence[float]], radius: float, adds: bool) -> None:
        """Paint the silhouette: along points, pixels of the picture, with a round brush."""
        path = tuple((float(x), float(y)) for x, y in points[:MOST_POINTS])
        if path and np.isfinite(path).all():
            self._correct(Stroke(path, float(np.clip(radius, 1, 400)), adds))

    def undo(self) -> bool:
        """Take the last correction back. Returns whether there was one."""
        state = self.state
        if self._seen is None or not state.corrections or state.making:
            return False
        left = state.corrections[:-1]
        state.param.update(found=reduce(lambda seen, change: change(seen), left, self._seen), corrections=left)
        return True

    def _correct(self, change: Moved | Stroke) -> None:
        state = self.state
        if isinstance(state.found, Sighting) and not state.making:
            state.param.update(found=change(state.found), corrections=(*state.corrections, change))

    # ---- the character ------------------------------------------------------------------------------------

    def problem(self) -> str:
        """Why none can be made; empty where it can."""
        state = self.state
        if state.found is None:
            return "Drop a picture of one standing person first."
        try:
            kept.file_of(state.called)
        except MotionloomError as problem:
            return str(problem)
        return ""

    def forecast(self) -> str:
        """One line on what will come."""
        taken = self.state.called.strip() in self.state.characters
        return "Replaces the one of that name." if taken else "Kept on this machine, and worn by the takes at once."

    def make(self) -> None:
        """Make the character, keep it, and have the takes wear it."""
        state = self.state
        if state.making or self.problem():
            return
        name, file, found, height, data = state.called.strip(), state.file, state.found, state.height, self._data
        state.param.update(making=True, progress=0.0, words="Starting …", make_error="")
        said = [state.words]

        def work(progress: Any, cancel: Any) -> str:
            def tell(share: float, words: str) -> None:
                said[0] = f"{words} …"
                progress(round(100 * share), 100)

            source = likeness.find(data, file, height) if data and height else found
            made = likeness.make(
                source, bodies.get("anny"), file, name=name, height=height, progress=tell, cancel=cancel
            )
            return kept.save(made, name)

        def show(job: Job) -> None:
            state.param.update(progress=job.fraction, words=said[0])
            if job.finished:
                self._made(job, name)

        self._job = self.session.submit(f"character {name}", work, show)

    def cancel(self) -> None:
        """Stop looking, or making."""
        if self._job is not None:
            self._job.cancel()

    def _made(self, job: Job, name: str) -> None:
        self.state.param.update(making=False, make_error=job.error, words="")
        if job.status == "cancelled":
            self.session.state.message = f"Cancelled: {name}"
        elif job.status == "done":
            self.session.dressing.renew(job.result)
            self.session.dressing.wear(job.result)
            self.session.state.message = f"{name} is worn by the takes of this project."

    # ---- those that are kept ------------------------------------------------------------------------------

    def wear(self, name: str) -> None:
        """Have the takes of the project wear one."""
        self.session.dressing.wear(kept.PREFIX + name)

    def rename(self, name: str, to: str) -> None:
        """Give one another name, unless another has it."""
        to = to.strip()
        if name in self.state.characters and to != name:
            self._change(f"rename {name}", lambda: _renamed(name, to), name, to)

    def delete(self, name: str) -> None:
        """Delete the file of one; takes that wear it wear the usual body."""
        if name in self.state.characters:
            self._change(f"delete {name}", lambda: kept.file_of(name).unlink(missing_ok=True), name, "")

    def _change(self, title: str, act: Any, name: str, then: str) -> None:
        """Change the file of one, off the page's thread; who wears it wears the body `then` names."""
        self.state.list_error = ""

        def show(job: Job) -> None:
            if not job.finished:
                return
            self.state.list_error = job.error
            self.session.dressing.renew(kept.PREFIX + name)
            if job.status == "done" and self.session.state.body == kept.PREFIX + name:
                self.session.dressing.wear(kept.PREFIX + then if then else bodies.DEFAULT)

        self.session.submit(title, lambda _progress, _cancel: act(), show, lane="file")

    # ---- plumbing -----------------------------------------------------------------------------------------

    def _look_around(self, *_: Any) -> None:
        """What is installed and what is kept, once the tab is opened."""
        if self.wants_a_file():
            self.state.missing = "" if models.installed() else str(models.MissingNetworksError())
            self.session.dressing.renew()
            self._list()

    def _list(self) -> None:
        own = [name for name in self.session.state.bodies if name.startswith(kept.PREFIX)]
        self.state.characters = [name.removeprefix(kept.PREFIX) for name in own]

    def _free(self, file: str) -> str:
        """A name for a character of a file that none has yet."""
        stem = " ".join(re.sub(r"[^\w \-]+", " ", Path(file).stem).split())[:50] or "somebody"
        taken, number = set(self.state.characters), 2
        name = stem
        while name in taken:
            name, number = f"{stem} {number}", number + 1
        return name


def mask_uri(mask: Float[np.ndarray, "H W"]) -> str:
    """A silhouette as the transparency of a .png of the size that the page shows."""
    alpha = Image.fromarray(np.round(255 * mask).astype(np.uint8))
    alpha.thumbnail((SHOWN, SHOWN), Image.Resampling.BOX)
    return _uri(Image.merge("LA", (Image.new("L", alpha.size, 255), alpha)), "PNG", compress_level=1)


def _picture_uri(found: Sighting) -> str:
    image = Image.fromarray(found.picture.pixels)
    image.thumbnail((SHOWN, SHOWN), Image.Resampling.LANCZOS)
    return _uri(image, "JPEG", quality=88)


def _uri(image: Image.Image, kind: str, **how: Any) -> str:
    stream = io.BytesIO()
    image.save(stream, kind, **how)
    return f"data:image/{kind.lower()};base64,{base64.b64encode(stream.getvalue()).decode('ascii')}"


def _renamed(name: str, to: str) -> None:
    """Rename a character's file and the character in it.

    Raises:
        FormatError: another has that name.
    """
    from engines.character import character

    if kept.file_of(to).exists():
        raise FormatError(to, "another character has that name.")
    kept.save(character.load(kept.file_of(name)), to)
    kept.file_of(name).unlink()
