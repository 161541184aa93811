"""A short video of one person becomes a motion.

One camera shows where limbs point but not how far away the body is: directions come from the landmark network, bones
keep the house skeleton's lengths, and the path over the floor is put together from standing feet (steps) and from
where and how large the person is in the picture (drift). The camera is taken to stand level and still.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter1d, grey_opening

from engines.character import landmarks, models
from engines.character.sighting import projected_scale
from engines.errors import Cancelled, FormatError
from engines.geometry import canonical, cleanup, retarget, rotations
from engines.motion import Motion, Provenance
from engines.skeletons import SMPL22

Progress = Callable[[int, int | None], object]
"""Called with the number of frames done and in all (None if nobody knows)."""
Cancel = Callable[[], bool]
"""Asked before every frame; True stops the work."""

LONGEST = 60.0
"""Seconds, at most."""
FASTEST = 30.0
"""Frames a second that are looked at, at most."""
SIDE = 960
"""Pixels of the longer side that is looked at, at most."""
ENDINGS = (".mp4", ".mov", ".m4v", ".webm", ".mkv", ".avi")
_SEEN = 0.5
"""Share of the frames in which the person must be found."""
_FOCAL = 1.0
"""Focal length, in widths of the picture's longer side: a telephone held upright."""
_EARS = 0.4
"""Of an upright head the ears lie before the neck by this share of the way from ears to nose."""
_SMOOTH = 0.06
"""Deviation of the Gaussian over landmarks, seconds."""
_DRIFT = 0.7
"""Steps shorter than this are the feet's, slower travel is the picture's; seconds."""
_JUMP = 0.9
"""A body higher than before and after is in the air, if for less than so many seconds."""
_STANDING = 0.03
"""Metres: of two points of the feet the one higher by this counts a third as much."""
_AIR = 0.04
"""Metres above the floor from which a body flies and no foot says where to."""
_LIMBS = tuple(
    (f"{side}_{near}", f"{side}_{far}", tuple(f"{side}_{end}" for end in ends))
    for side in ("left", "right")
    for near, far, ends in (
        ("hip", "knee", ("ankle", "heel", "toe")),
        ("knee", "ankle", ("heel", "toe")),
        ("shoulder", "elbow", ("wrist", "pinky", "index", "thumb")),
        ("elbow", "wrist", ("pinky", "index", "thumb")),
    )
)
"""Near and far end of a limb, and what goes along with the far one."""
_DEPTH_ERROR = 0.05
"""Metres by which the network's depth across a limb is usually off."""
_LENGTH_ERROR = 0.1
"""Share of its length by which a limb seems longer or shorter than it is."""
_LEAN = 0.45
"""Radians that somebody who stands may seem to lean toward the camera or away."""


@dataclass(frozen=True, eq=False)
class _Track:
    """One person through a video."""

    points: Float[np.ndarray, "T 33 2"]
    """Pixels about the picture's middle, y down."""
    places: Float[np.ndarray, "T 33 3"]
    """Metres about the hips' middle, house axes."""
    seen: Float[np.ndarray, "T 33"]
    found: Bool[np.ndarray, " T"]
    """In which frames there is a person."""
    focal: float
    """Pixels."""
    fps: float


def read(path: str | Path, progress: Progress | None = None, cancel: Cancel | None = None) -> Motion:
    """The motion of the person in a video, on `smpl22`, in the axes of the picture (+Z toward the camera).

    Args:
        path: a video up to `LONGEST` seconds; of several people the largest at the start is followed.
        progress: called with (frames done, frames in all or None).
        cancel: asked before every frame; True stops.

    Returns:
        A motion at the video's rate (at most `FASTEST`), that begins above the origin with its feet on the floor.

    Raises:
        FormatError: no video, too long, damaged, or no person in half of it.
        MissingDependencyError: the networks are not installed.
        Cancelled: `cancel` said so.
    """
    path = Path(path)
    track = _levelled(_deepened(_filled(_followed(path, progress, cancel))))
    motion = retarget.from_points(_joints(track), track.fps)
    motion = _head_turned(motion, track)
    motion = motion.replaced(translation=_path(motion, track))
    start = motion.positions[0, 0] * (-1, 0, -1)
    return cleanup.plant_feet(motion.moved(tuple(start))).replaced(provenance=Provenance(source=path.name))


def _frames(path: Path) -> Iterator[tuple[np.ndarray, float, int | None]]:
    """Pictures (H, W, 3) uint8 of a video, the rate, and how many there should be.

    Raises:
        FormatError: no video, too long (told by its header, or counted), or damaged.
    """
    import imageio_ffmpeg

    if not path.is_file():
        raise FormatError(path, "is not there.")
    logging.getLogger("imageio_ffmpeg").setLevel(logging.ERROR)  # it warns of every video that is shrunk
    shrink = f"scale='if(gt(iw,ih),min({SIDE},iw),-2)':'if(gt(iw,ih),-2,min({SIDE},ih))'"
    reader = imageio_ffmpeg.read_frames(
        str(path), output_params=["-vf", f"{shrink},fps='min({FASTEST:g},source_fps)'", "-an"]
    )
    with closing(reader):
        try:
            header = next(reader)
        except (OSError, RuntimeError, StopIteration) as problem:
            raise FormatError(path, f"is no video that can be read; accepted: {', '.join(ENDINGS)}.") from problem
        seconds, fps = header["duration"], min(header["fps"], FASTEST)
        if seconds > LONGEST:
            raise FormatError(path, f"lasts {seconds:.0f} s; accepted: up to {LONGEST:.0f} s. Cut it first.")
        width, height = header["size"]
        total = round(seconds * fps) or None
        for count, frame in enumerate(reader):
            if count > LONGEST * fps + 1:
                raise FormatError(path, f"lasts longer than {LONGEST:.0f} s; cut it first.")
            yield np.frombuffer(frame, np.uint8).reshape(height, width, 3), fps, total


def _followed(path: Path, progress: Progress | None, cancel: Cancel | None) -> _Track:
    """What the networks say of every frame: the last frame's landmarks are where the next one is looked at."""
    bodies: list[models.Body | None] = []
    crop, fps, size = None, 0.0, (0, 0)
    for pixels, rate, total in _frames(path):
        if cancel is not None and cancel():
            raise Cancelled("reading the video was cancelled.")
        fps, size = rate, pixels.shape[1::-1]
        body = models.examine(pixels, crop) if crop is not None else None
        if body is None or body.score < models.SURE:
            body = models.largest(pixels)
        crop = None if body is None else body.following
        bodies.append(body)
        if progress is not None:
            progress(len(bodies), total)
    found = np.array([body is not None for body in bodies], dtype=bool)
    if not len(found):
        raise FormatError(path, "holds no pictures; it may be damaged or cut off.")
    if found.mean() < _SEEN:
        raise FormatError(
            path,
            f"shows a person in {found.sum()} of {len(found)} frames; accepted: one whole person in at least half.",
        )
    filler = next(body for body in bodies if body is not None)  # where nobody was found, `_filled` looks elsewhere
    points, places, seen = (
        np.array([getattr(body or filler, name) for body in bodies]) for name in ("points", "places", "seen")
    )
    return _Track(points - np.array(size) / 2, places, seen, found, _FOCAL * max(size), fps)


def _filled(track: _Track) -> _Track:
    """Without gaps and trembling: weighted means over time, a landmark in plain sight counting most."""
    weight = np.where(track.found[:, None], track.seen + 0.01, 0.0)
    sigma = _SMOOTH * track.fps
    times, known = np.arange(len(track.found)), np.flatnonzero(track.found)

    def smooth(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(len(values), -1)
        bridged = np.stack([np.interp(times, known, column[known]) for column in flat.T], axis=1).reshape(values.shape)
        share = np.maximum(weight, 1e-3)[..., None]
        over = gaussian_filter1d(bridged * share, sigma, axis=0, mode="nearest")
        return over / gaussian_filter1d(share, sigma, axis=0, mode="nearest")

    return _Track(smooth(track.points), smooth(track.places), weight, track.found, track.focal, track.fps)


def _deepened(track: _Track) -> _Track:
    """With limbs as deep as they are short in the picture (Taylor 2000), toward or away as the network says.

    From the front the network takes bent knees for nearly straight ones, although it sees well where they are.
    """
    scale = _scale(track)
    flat = track.points / scale[:, None, None] * (1, -1)
    places = track.places.copy()
    for near, far, ends in _LIMBS:
        one, other = landmarks.index(near), landmarks.index(far)
        across = flat[:, other] - flat[:, one]
        guess = track.places[:, other, 2] - track.places[:, one, 2]
        shown = np.linalg.norm(across, axis=1)
        length = max(np.percentile(shown, 95), np.median(np.hypot(shown, guess)))
        depth = np.linspace(-length, length, 201)  # (D,)
        misfit = ((depth - guess[:, None]) / _DEPTH_ERROR) ** 2
        misfit += ((np.hypot(shown[:, None], depth) / length - 1) / _LENGTH_ERROR) ** 2
        limb = np.concatenate([across, depth[misfit.argmin(axis=1)][:, None]], axis=1)
        shift = places[:, one] + limb - places[:, other]
        places[:, [other, *map(landmarks.index, ends)]] += shift[:, None]
    return replace(track, places=places)


def _levelled(track: _Track) -> _Track:
    """Turned about the camera's right so that on the whole the trunk is above the feet, as a body that stands has it.

    Cameras look down, and the network lets people lean toward the camera: ten degrees are usual. Who sits or lies all
    the time is left as seen.
    """
    above, below = (
        np.mean([track.places[:, landmarks.index(f"{side}_{part}")] for side in ("left", "right") for part in parts], 0)
        for parts in (("hip", "shoulder"), ("ankle", "toe"))
    )
    _, up, ahead = np.median(above - below, axis=0)
    lean = np.arctan2(ahead, up)
    if abs(lean) > _LEAN:
        return track
    upright = rotations.rotvec_to_matrix(np.array([-lean, 0.0, 0.0]))
    return replace(track, places=track.places @ upright.T)


def _joints(track: _Track) -> dict[str, Float[np.ndarray, "T 3"]]:
    """Joints of the house skeleton in the round; neck and pelvis lie where its own do above shoulders and hips."""
    at = dict(zip(landmarks.NAMES, track.places.swapaxes(0, 1), strict=True))
    joints = {joint: at[name] for name, joint in landmarks.JOINTS.items()}
    hips = (at["left_hip"] + at["right_hip"]) / 2
    shoulders = (at["left_shoulder"] + at["right_shoulder"]) / 2
    up = rotations.normalise(shoulders - hips)
    rest = dict(zip(SMPL22.joints, SMPL22.rest_positions[:, 1], strict=True))
    joints["pelvis"] = hips + up * (rest["pelvis"] - rest["left_hip"])
    joints["neck"] = shoulders + up * (rest["neck"] - rest["left_shoulder"])
    ears = (at["left_ear"] + at["right_ear"]) / 2
    joints["head"] = ears - _EARS * (at["nose"] - ears)
    return joints


def _head_turned(motion: Motion, track: _Track) -> Motion:
    """With the head looking where the nose points from between the ears; how it nods is in the neck already."""
    at = dict(zip(landmarks.NAMES, track.places.swapaxes(0, 1), strict=True))
    above = motion.global_rotations[:, SMPL22.index("neck")]
    ahead = at["nose"] - (at["left_ear"] + at["right_ear"]) / 2
    local = np.einsum("tji,tj->ti", above, ahead)
    yaw = np.clip(np.arctan2(local[:, 0], local[:, 2]), -1.2, 1.2)
    turns = motion.rotations.copy()
    turns[:, SMPL22.index("head")] = rotations.yaw_quaternion(yaw)
    return motion.replaced(rotations=turns)


def _path(motion: Motion, track: _Track) -> Float[np.ndarray, "T 3"]:
    """Root path: steps as the standing feet call for, slow travel as the picture shows, height above the floor."""
    fps = track.fps
    body = motion.positions - motion.positions[:, :1]
    feet = body[:, [SMPL22.index(name) for pair in SMPL22.feet for name in pair]]
    shown = _in_picture(track)
    low = feet[..., 1].min(axis=1) + shown[:, 1]
    floor = grey_opening(low, max(3, round(_JUMP * fps)), mode="nearest")
    flight = np.clip(low - floor - _AIR, 0, None)
    share = np.exp(-(feet[..., 1] - feet[..., 1].min(axis=1, keepdims=True)) / _STANDING)
    share /= share.sum(axis=1, keepdims=True)
    stepped = -(np.diff(feet, axis=0) * share[1:, :, None]).sum(axis=1)[:, [0, 2]]
    stepped = np.where(flight[1:, None] > 0, np.diff(shown[:, [0, 2]], axis=0), stepped)
    travelled = np.concatenate([np.zeros((1, 2)), np.cumsum(stepped, axis=0)])
    drift = gaussian_filter1d(shown[:, [0, 2]] - travelled, _DRIFT * fps, axis=0, mode="nearest")
    x, z = (travelled + drift).T
    height = flight + canonical.toe_clearance(SMPL22) - feet[..., 1].min(axis=1)
    return np.stack([x, height, z], axis=-1) - SMPL22.offsets[0]


def _in_picture(track: _Track) -> Float[np.ndarray, "T 3"]:
    """Where the hips' middle is before the camera, house metres: nearer is larger, and greater in z."""
    legs = [[landmarks.index(f"{side}_{name}") for name in ("hip", "knee", "ankle")] for side in ("left", "right")]
    theirs = np.median(np.linalg.norm(np.diff(track.places[:, legs], axis=2), axis=-1), axis=0).sum() / 2
    ours = sum(SMPL22.bone_lengths[SMPL22.index(name)] for name in ("left_knee", "left_ankle"))
    right, down = track.points[:, [leg[0] for leg in legs]].mean(axis=1).T
    return np.stack([right, -down, np.full(len(right), -track.focal)], axis=1) * (
        ours / theirs / _scale(track)[:, None]
    )


def _scale(track: _Track) -> Float[np.ndarray, " T"]:
    """Pixels a metre of the network's, steadied over time."""
    frames = zip(track.points, track.places, track.seen, strict=True)
    return gaussian_filter1d([projected_scale(*frame) for frame in frames], _DRIFT * track.fps, mode="nearest")
