"""An ffmpeg process at work beside us: raw pictures go in through a pipe, a finished file comes out."""

from __future__ import annotations

import contextlib
import os
import queue
import subprocess
import tempfile
import threading
from pathlib import Path

import numpy as np

from engines.errors import FormatError

AHEAD = 3
"""Pictures that may wait for the encoder."""
_PIPE = 1 << 20
_TO_BT709 = "scale=out_color_matrix=bt709:out_range=tv:flags=neighbor"
_ARGUMENTS = {
    ".mp4": [
        "-vf", _TO_BT709, "-c:v", "libx264", "-preset", "ultrafast", "-crf", "22",
        "-x264-params", "no-deblock=0:cabac=1:aq-mode=1", "-pix_fmt", "yuv420p",
        "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv",
        "-movflags", "+faststart", "-f", "mp4",
    ],
    ".webm": [
        "-vf", _TO_BT709, "-c:v", "libvpx-vp9", "-deadline", "realtime", "-cpu-used", "8", "-row-mt", "1",
        "-crf", "34", "-b:v", "0", "-pix_fmt", "yuv420p",
        "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv",
        "-f", "webm",
    ],
    ".gif": [
        "-filter_complex",
        "[0:v]split[a][b];[a]palettegen=max_colors=160:stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=5:diff_mode=rectangle",
        "-loop", "0", "-f", "gif",
    ],
}  # fmt: skip
FORMATS = tuple(_ARGUMENTS)
SEE_THROUGH = (".webm", ".gif")
"""Kinds of video that can be transparent; in GIFs a pixel is so wholly or not at all."""
_ALPHA = {".webm": {"yuv420p": "yuva420p"}}
"""What differs in the arguments where pictures are transparent."""


def format_of(path: Path) -> str:
    """The ending of a video file, in lower case.

    Raises:
        FormatError: none we write.
    """
    suffix = path.suffix.lower()
    if suffix not in _ARGUMENTS:
        raise FormatError(path, f"videos end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}, not in {path.suffix!r}")
    return suffix


class Encoder:
    """Writes pictures of one size into a video file. Nothing is at `path` before `finish`, nor after `abort`.

    Raises:
        FormatError: the folder is missing or not writable, or ffmpeg does not start.
    """

    def __init__(self, path: Path, size: tuple[int, int], channels: int, fps: float, transparent: bool = False) -> None:
        """Start ffmpeg for pictures of `size` (width, height), 3 or 4 channels.

        The fourth channel counts if they are `transparent`, which only SEE_THROUGH videos can be.
        """
        self.path, self._failed = path, threading.Event()
        try:
            handle, part = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        except OSError as problem:
            raise FormatError(path, f"cannot be written: {problem.strerror}; choose a folder that can") from problem
        os.close(handle)
        self._part = Path(part)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 -- closed by finish or abort
        given = ["-f", "rawvideo", "-pix_fmt", _layout(channels, transparent), "-s", f"{size[0]}x{size[1]}"]
        command = [_ffmpeg(), "-hide_banner", "-loglevel", "error", "-y", *given, "-r", f"{fps:.6g}", "-i", "pipe:0"]
        kind = format_of(path)
        other = _ALPHA.get(kind, {}) if transparent else {}
        command += [*(other.get(word, word) for word in _ARGUMENTS[kind]), str(self._part)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._errors)
        self._widen_pipe()
        self._waiting: queue.Queue[np.ndarray | None] = queue.Queue(AHEAD)
        self._feeder = threading.Thread(target=self._feed, name="video encoder", daemon=True)
        self._feeder.start()

    def put(self, frame: np.ndarray) -> None:
        """Hand a contiguous uint8 picture over; it must stay as it is until AHEAD + 1 more were put.

        Raises:
            FormatError: ffmpeg gave up.
        """
        if self._failed.is_set():
            raise FormatError(self.path, self._complaint())
        self._waiting.put(frame)

    def finish(self) -> None:
        """Let ffmpeg end, and put the file in its place.

        Raises:
            FormatError: ffmpeg gave up.
        """
        self._waiting.put(None)
        self._feeder.join()
        if self._process.wait() != 0 or self._failed.is_set():
            raise FormatError(self.path, self._complaint())
        self._part.chmod(0o666 & ~_umask())
        self._part.replace(self.path)
        self._errors.close()

    def abort(self) -> None:
        """Stop at once and leave nothing."""
        self._process.kill()
        self._failed.set()
        with contextlib.suppress(queue.Empty):
            while True:
                self._waiting.get_nowait()
        self._waiting.put(None)
        self._feeder.join()
        self._process.wait()
        self._part.unlink(missing_ok=True)
        self._errors.close()

    def _feed(self) -> None:
        """Write pictures to ffmpeg, in a thread of its own: most of the time is spent waiting for it."""
        pipe = self._process.stdin
        assert pipe is not None
        while (frame := self._waiting.get()) is not None:
            if self._failed.is_set():
                continue
            try:
                pipe.write(np.ascontiguousarray(frame).data)
            except OSError:
                self._failed.set()
        with contextlib.suppress(OSError):
            pipe.close()

    def _widen_pipe(self) -> None:
        """A larger pipe means fewer turns between the two processes; only Linux can."""
        try:
            import fcntl

            assert self._process.stdin is not None
            fcntl.fcntl(self._process.stdin.fileno(), fcntl.F_SETPIPE_SZ, _PIPE)
        except (ImportError, AttributeError, OSError):
            return

    def _complaint(self) -> str:
        self._process.wait()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        return f"the encoder stopped: {said[-1] if said else 'it gave no reason'}"


def _layout(channels: int, transparent: bool) -> str:
    """ffmpeg's name for the pixels that go in."""
    return ("rgba" if transparent else "rgb0") if channels == 4 else "rgb24"


def _ffmpeg() -> str:
    import imageio_ffmpeg

    return imageio_ffmpeg.get_ffmpeg_exe()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
