"""Files in and out of a session: import of dropped files, export of takes, settings files."""

from __future__ import annotations

import os
import shutil
import tempfile
import uuid
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import engines
from engines import formats
from engines.errors import FormatError, MotionloomError, OutOfRangeError
from engines.geometry.opening import opening
from studio import downloads, tasks
from studio.jobs import Cancel, Job, Progress
from studio.library.library import UNTITLED
from studio.settings import Settings, ending
from studio.takes import Take
from studio.wording import duration

if TYPE_CHECKING:
    from studio.session import Session

UPLOAD_LIMIT = 64 * 2**20
"""Largest file that can be imported, bytes."""
IMPORTS = tuple(
    sorted({Path("motion" + end).suffix for kind in formats.formats() if kind.reads for end in kind.extensions})
)
"""Extensions the app reads."""


class Exchange:
    """The files of one session.

    Args:
        session: whose state is shown to, and whose queue does the work.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.folder: Path | None = None
        """Where exports are written; made with the first one."""
        self._arriving: dict[str, bytearray] = {}
        self._exporting: Job | None = None

    # ---- in -----------------------------------------------------------------------------------------------

    def receive(self, message: Mapping[str, Any], then: Callable[[Take], None] | None = None) -> None:
        """One piece of a motion file on its way in; with the last one it is imported.

        Args:
            message: as for `arrived`.
            then: as for `import_file`.
        """
        try:
            whole = self.arrived(message)
        except FormatError as problem:
            self.session.state.param.update(import_error=str(problem), import_status="")
            return
        if whole is not None:
            self.import_file(*whole, then)

    def arrived(self, message: Mapping[str, Any]) -> tuple[str, bytes] | None:
        """One piece of a file on its way in; its name and bytes with the last one.

        Args:
            message: id and name of the file, its size in bytes, where the piece starts, and its `data`.

        Raises:
            FormatError: pieces out of order, or more than `UPLOAD_LIMIT`.
        """
        key, name, start, size, piece = (message[part] for part in ("id", "name", "start", "size", "data"))
        held = self._arriving.setdefault(key, bytearray()) if start == 0 else self._arriving.get(key)
        if held is None or start != len(held) or size > UPLOAD_LIMIT or start + len(piece) > size:
            self._arriving.pop(key, None)
            raise FormatError(name, "the upload broke off; try again.")
        held += piece
        if len(held) < size:
            return None
        del self._arriving[key]
        return Path(name).name, bytes(held)

    def import_file(self, name: str, data: bytes, then: Callable[[Take], None] | None = None) -> None:
        """Read a motion file a person dropped; what is wrong with it is said in `state.import_error`.

        A reference pose that it opens with is no part of the motion and is left out, and said so.

        `then` hears of the take it became, which is not picked in that case.
        """
        state = self.session.state
        state.param.update(import_error="", import_status=f"Reading {name}…")

        takes = self.session.takes

        def read(_progress: Any, _cancel: Any) -> tuple[Any, dict, int]:
            motion = read_upload(name, data)
            before = opening(motion)
            motion = motion[before:]
            return takes.store.hold([motion])[0], dict(tasks.measure(motion)), before

        def show(job: Job) -> None:
            if job.status == "failed":
                state.param.update(import_error=job.error, import_status="")
            elif job.status == "done":
                held, metrics, before = job.result
                made = takes.add([held], group=uuid.uuid4().hex, source=name, metrics=[metrics])
                state.import_status = f"Imported {name}: {made[0].frames:,} frames, {duration(made[0].duration)}."
                if before:
                    state.import_status += " The reference pose it opens with is left out."
                self.session.shelve(made, takes, pick=then is None)
                if then is not None and takes is self.session.takes:
                    then(made[0])

        self.session.submit(f"import {name}", read, show, lane="file")

    # ---- out ----------------------------------------------------------------------------------------------

    def chosen(self) -> list[Take]:
        """What an export writes: the takes ticked for comparison if the selected one is among them, else that one."""
        state = self.session.state
        ticked = state.compared if state.selected in state.compared else [state.selected]
        return [take for take in map(self.session.takes.get, ticked) if take is not None]

    def export(self) -> None:
        """Write the chosen takes by the state's export settings; the finished file is offered for download.

        Several of them come in a .zip.
        """
        state, takes = self.session.state, self.chosen()
        if not takes or state.export_status in ("queued", "running"):
            return
        how = state.export_settings()
        files = [(take, self._file_name(take)) for take in takes]
        name = files[0][1] if len(files) == 1 else f"{self._prefix()}{len(files)}-takes.zip"
        self.folder = self.folder or Path(tempfile.mkdtemp(prefix=mark()))
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        state.param.update(
            export_status="queued", export_progress=0.0, export_error="", export_name=name, export_url="",
            export_bytes=0,
        )  # fmt: skip

        def write(progress: Progress, cancel: Cancel) -> Path:
            for number, (take, file) in enumerate(files):

                def share(done: int, total: int | None, number: int = number) -> None:
                    progress(number * (total or 1) + done, len(files) * (total or 1))

                tasks.export(take.motion, folder / file, replace(how, edits=take.edits), share, cancel)
            return folder / name if len(files) == 1 else _packed(folder, [file for _, file in files], name)

        self._exporting = self.session.submit(name, write, self._exported, lane="file")

    def _file_name(self, take: Take) -> str:
        subject = take.subject if take.settings else Path(take.subject).stem
        return f"{self._prefix()}{take.id}-{tasks.slug(subject)}{ending(self.session.state.export_format)}"

    def cancel_export(self) -> None:
        """Stop the export under way."""
        if self._exporting is not None:
            self._exporting.cancel()

    def settings_file(self, take_id: str = "") -> tuple[str, str]:
        """(name, text) of the settings file that makes a take again; empty for an imported one."""
        state = self.session.state
        take = state.take(take_id)
        if take is None or take.settings is None:
            return "", ""
        return f"{take.id}.json", Settings(take.settings, replace(state.export_settings(), edits=take.edits)).to_json()

    def close(self) -> None:
        """Remove the exported files."""
        if self.folder is not None:
            downloads.withdraw(self.folder)
            shutil.rmtree(self.folder, ignore_errors=True)

    def _exported(self, job: Job) -> None:
        update: dict[str, Any] = {"export_status": job.status, "export_progress": job.fraction}
        update["export_error"] = job.error
        if job.status == "done":
            update |= {"export_url": downloads.offer(job.result), "export_bytes": job.result.stat().st_size}
        self.session.state.param.update(**update)

    def _prefix(self) -> str:
        name = self.session.state.scene.strip()
        return "" if name in ("", UNTITLED) else tasks.slug(name) + "-"


def _packed(folder: Path, files: list[str], name: str) -> Path:
    """Files of a folder in a .zip beside them, in their place."""
    with zipfile.ZipFile(folder / f"{name}.part", "w") as archive:
        for file in files:
            archive.write(folder / file, file)
            (folder / file).unlink()
    return (folder / f"{name}.part").rename(folder / name)


def read_upload(name: str, data: bytes) -> engines.Motion:
    """A motion from the bytes of an uploaded file; messages name the file as the person knows it.

    Raises:
        FormatError: empty, of a kind that is not read, or malformed.
        OutOfRangeError: larger than `UPLOAD_LIMIT`.
    """
    if len(data) > UPLOAD_LIMIT:
        raise OutOfRangeError(f"size of {name}", f"{len(data) / 2**20:.0f} MB", f"up to {UPLOAD_LIMIT >> 20} MB")
    suffix = Path(name).suffix.lower()
    if suffix not in IMPORTS:
        raise FormatError(name, f"files of this kind are not read; accepted: {', '.join(IMPORTS)}")
    if not data:
        raise FormatError(name, "the file is empty")
    with tempfile.TemporaryDirectory(prefix=mark()) as folder:
        path = Path(folder) / f"upload{suffix}"
        path.write_bytes(data)
        try:
            return engines.read(path)
        except FormatError as problem:
            raise FormatError(name, problem.problem, problem.line) from None
        except MotionloomError as problem:
            raise FormatError(name, str(problem).replace(str(path), name)) from None


def sweep() -> None:
    """Remove the files of studios that were killed before they could do it themselves."""
    for folder in Path(tempfile.gettempdir()).glob("motionloom-*-*"):
        process = folder.name.split("-")[1]
        if os.name == "posix" and process.isdigit() and not _alive(int(process)):
            shutil.rmtree(folder, ignore_errors=True)


def mark() -> str:
    """Of the names of temporary folders: they say whose they are."""
    return f"motionloom-{os.getpid()}-"


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # somebody else's
        return True
    return True
