"""Videos: frames into MP4, WebM, GIF and PNG files, and whole scenes rendered into them, with progress and cancel."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Literal

import numpy as np
from PIL import Image

from engines.errors import Cancelled, FormatError, OutOfRangeError, UnknownLabelError
from engines.motion import Motion
from viewers.camera import Camera, Mode
from viewers.encoder import SEE_THROUGH, Encoder, format_of
from viewers.scene import Scene

Progress = Callable[[int, int | None], object]
"""Called with the number of frames done and in all (None if nobody knows)."""
Cancel = Callable[[], bool]
"""Asked before every frame; True stops the work."""

SIZES = {".mp4": (1280, 720, 30.0), ".webm": (1280, 720, 30.0), ".gif": (480, 270, 20.0)}
"""Width, height and frames a second, where none are asked for."""


NO_ALPHA = "MP4 videos cannot be transparent; accepted: .webm, .gif or a folder of pictures."
Views = Literal["one", "four", "around"]
VIEWS: tuple[Views, ...] = ("one", "four", "around")


@dataclass(frozen=True)
class VideoSettings:
    """How a video of a scene is made. What is left None is chosen by the kind of file (see SIZES)."""

    width: int | None = None
    """Pixels; made even."""
    height: int | None = None
    """Pixels; made even."""
    fps: float | None = None
    """Frames a second; poses between the motion's own frames are interpolated."""
    camera: Mode | Camera | None = None
    """A camera, or the name of its mode; default: the scene's own, and "follow" for a motion."""
    samples: int = 4
    """Samples a pixel."""
    views: Views = "one"
    """one: through the camera; four: from the front, the side, above and along with the body, in one picture; around:
    along with the body from the front, the back, the left and the right."""
    transparent: bool = False
    """Nothing behind the bodies: WebM, GIF and numbered pictures can, MP4 cannot. A transparent Scene is so anyhow."""

    def filled(self, suffix: str) -> VideoSettings:
        """Nothing left open, sizes even, for a file that ends in `suffix`.

        Raises:
            OutOfRangeError: a size that cannot be.
            UnknownLabelError: no such views.
        """
        if self.views not in VIEWS:
            raise UnknownLabelError("views", self.views, VIEWS)
        width, height, fps = SIZES[suffix]
        asked_width, asked_height = self.width, self.height
        if asked_width and not asked_height:
            asked_height = round(asked_width * height / width)
        if asked_height and not asked_width:
            asked_width = round(asked_height * width / height)
        return replace(
            self,
            width=_even("width", asked_width or width),
            height=_even("height", asked_height or height),
            fps=fps if self.fps is None else self.fps,
        )


def render(
    what: Motion | Scene | Sequence[Motion],
    path: str | Path,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    **settings,
) -> Path:
    """Render a motion, several, or a scene into a video file.

    Args:
        what: a Scene as it is; motions as `Scene.of` shows them.
        path: ends in .mp4, .webm or .gif.
        progress: called with (frames done, frames in all).
        cancel: asked before every frame; True stops and leaves no file.
        settings: fields of VideoSettings: width, height, fps, camera, samples, views, transparent.

    Returns:
        The path written.

    Raises:
        FormatError: the ending is none of these, it cannot be transparent and should be, or the encoder fails.
        OutOfRangeError: sizes or fps that cannot be.
        UnknownLabelError: a setting or camera of no known name.
        Cancelled: `cancel` said so.
        NoGraphicsError: no OpenGL here.
    """
    path = Path(path)
    chosen = _settings(settings).filled(format_of(path))
    scene = _scene(what, chosen)
    if scene.transparent and format_of(path) not in SEE_THROUGH:
        raise FormatError(path, NO_ALPHA)
    with _pictures(scene, chosen) as (frames, count):
        return _encode(frames, path, chosen.fps or 0.0, _Watch(count, progress, cancel), scene.transparent)


def render_pngs(
    what: Motion | Scene | Sequence[Motion],
    folder: str | Path,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    **settings,
) -> Path:
    """Render a motion, several, or a scene into numbered pictures, for compositing and editing programs.

    Args:
        what: a Scene as it is; motions as `Scene.of` shows them.
        folder: made anew, filled with frame-00001.png and so on; it appears only when it is whole.
        progress: called with (frames done, frames in all).
        cancel: asked before every frame; True stops and leaves nothing.
        settings: fields of VideoSettings, with the defaults of .mp4.

    Returns:
        The folder.

    Raises:
        FormatError: the folder is already there and not empty, or cannot be made.
        OutOfRangeError: sizes or fps that cannot be.
        UnknownLabelError: a setting or camera of no known name.
        Cancelled: `cancel` said so.
        NoGraphicsError: no OpenGL here.
    """
    folder = Path(folder)
    if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
        raise FormatError(folder, "is already there; accepted: the name of a new or an empty folder.")
    try:
        part = Path(tempfile.mkdtemp(prefix=f".{folder.name[:80]}-", dir=folder.parent))
    except OSError as problem:
        raise FormatError(folder, f"cannot be made: {problem.strerror}; choose a folder that can.") from problem
    try:
        chosen = _settings(settings).filled(".mp4")
        scene = _scene(what, chosen)
        with _pictures(scene, chosen) as (frames, count):
            watch = _Watch(count, progress, cancel)
            for number in range(1, count + 1):
                watch.before()
                Image.fromarray(next(frames)[..., : 4 if scene.transparent else 3]).save(
                    part / f"frame-{number:05d}.png", compress_level=4
                )
                watch.after(number)
        part.chmod(0o755)
        part.replace(folder)
    except OSError as problem:
        raise FormatError(folder, f"cannot be written: {problem.strerror}.") from problem
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return folder


def _scene(what: Motion | Scene | Sequence[Motion], chosen: VideoSettings) -> Scene:
    """The scene that is rendered."""
    scene = what if isinstance(what, Scene) else Scene.of(what)
    if chosen.camera is not None:
        camera = chosen.camera if isinstance(chosen.camera, Camera) else Camera(chosen.camera)
        scene = scene.replaced(camera=camera)
    return scene.replaced(transparent=True) if chosen.transparent else scene


@contextmanager
def _pictures(scene: Scene, chosen: VideoSettings) -> Iterator[tuple[Iterator[np.ndarray], int]]:
    """The pictures of a video, (H, W, 4) uint8, and how many there are."""
    assert chosen.width and chosen.height and chosen.fps is not None
    times = scene.times(chosen.fps)
    size = chosen.width, chosen.height, chosen.samples
    if chosen.views == "one":
        from viewers.moderngl_renderer import Renderer

        drawing = Renderer(*size)
    else:
        from viewers import four_views

        drawing = four_views.FourViews(*size, four_views.VIEWS if chosen.views == "four" else four_views.AROUND)
    with drawing as renderer:
        yield renderer.pictures(scene, times), len(times)


def write_video(  # noqa: PLR0913, PLR0917 (each is a thing of its own)
    frames: Iterable[np.ndarray],
    path: str | Path,
    fps: float,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    transparent: bool = False,
) -> Path:
    """Write pictures into a video file; it appears only when it is whole.

    Args:
        frames: (H, W, 3) or (H, W, 4) uint8, all of one size; odd sizes gain a row or column.
        path: ends in .mp4 (H.264, yuv420p), .webm (VP9, yuv420p) or .gif.
        fps: frames a second.
        progress: called with (frames done, frames in all, or None if `frames` has no length).
        cancel: asked before every frame; True stops and leaves no file.
        transparent: the fourth channel is alpha, and the video has it too (.webm, .gif); else it is left out.

    Returns:
        The path written.

    Raises:
        FormatError: the ending is none of these, it cannot be transparent and should be, or the encoder fails.
        OutOfRangeError: no frames, frames of several sizes, or fps not positive.
        Cancelled: `cancel` said so.
    """
    total = len(frames) if isinstance(frames, Sequence) else None
    path = Path(path)
    return _encode((_checked(frame) for frame in frames), path, fps, _Watch(total, progress, cancel), transparent)


@dataclass
class _Watch:
    """Who is told of frames done, and who may stop the work."""

    total: int | None
    progress: Progress | None
    cancel: Cancel | None

    def before(self) -> None:
        if self.cancel is not None and self.cancel():
            raise Cancelled("the video was cancelled; no file was left.")

    def after(self, done: int) -> None:
        if self.progress is not None:
            self.progress(done, self.total)


def _encode(frames: Iterator[np.ndarray], path: Path, fps: float, watch: _Watch, transparent: bool = False) -> Path:
    """Feed frames (H, W, 3 or 4) to an encoder, which works beside us; on any failure nothing is left."""
    if not np.isfinite(fps) or fps <= 0:
        raise OutOfRangeError("fps", fps, "a positive number")
    if format_of(path) not in SEE_THROUGH and transparent:
        raise FormatError(path, NO_ALPHA)
    encoder: Encoder | None = None
    shape: tuple[int, ...] = ()
    done = 0
    try:
        watch.before()
        for frame in frames:
            if encoder is None:
                shape = frame.shape
                encoder = Encoder(path, (shape[1], shape[0]), shape[2], fps, transparent)
            if frame.shape != shape:
                raise OutOfRangeError("size of a frame", frame.shape, f"that of the first, {shape}")
            encoder.put(frame)
            done += 1
            watch.after(done)
            watch.before()
        if encoder is None:
            raise OutOfRangeError("number of frames", 0, "1 or more")
        encoder.finish()
    except BaseException:
        if encoder is not None:
            encoder.abort()
        raise
    return path


def _checked(frame: np.ndarray) -> np.ndarray:
    """A picture of even size."""
    frame = np.asarray(frame)
    if frame.ndim != 3 or frame.shape[2] not in (3, 4) or frame.dtype != np.uint8:
        raise OutOfRangeError("frame", f"{frame.dtype} {frame.shape}", "uint8 pictures of shape (H, W, 3) or (H, W, 4)")
    odd = [(0, size % 2) for size in frame.shape[:2]]
    return np.pad(frame, [*odd, (0, 0)], mode="edge") if any(more for _, more in odd) else frame


def _settings(given: dict[str, object]) -> VideoSettings:
    known = [field.name for field in fields(VideoSettings)]
    for name in given:
        if name not in known:
            raise UnknownLabelError("video setting", name, known)
    return VideoSettings(**given)  # type: ignore[arg-type]


def _even(name: str, value: int) -> int:
    if value < 1:
        raise OutOfRangeError(name, value, "a positive number of pixels")
    return value + value % 2
