"""AMASS .npz in and out: SMPL poses as axis-angle vectors (Mahmood et al. 2019).

What is and is not carried over:

- `poses` of SMPL (72), SMPL-H (156), SMPL-X (165) or bodies alone (66): the first 22 joints are those of `smpl22`, in
  the same order; fingers, jaw and eyes are dropped, and written as zeros.
- **Axes.** AMASS is Z up. Reading turns the world by -90 degrees about X, writing turns it back; the rest pose of
  SMPL is Y up and faces +Z, as ours, so all other rotations stay as they are.
- **Body shape.** `betas` mean something only to the SMPL model files, which are not free: they are kept in
  `provenance.parameters` and written again, but bones have the lengths of `smpl22`. So the feet of a tall subject are
  not exactly on the floor; `motion.on_ground()` puts them there.
- **Root.** `trans` moves SMPL's own origin, which lies above the pelvis joint's rest place; where exactly depends on
  the model and the shape. Pass that rest place as `pelvis` if you have the model; by default `trans` itself is taken
  as the pelvis, an error of constant size (some centimetres in height, some 20 cm in the horizontal).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from engines.errors import FormatError, OutOfRangeError, SkeletonError
from engines.formats import arrays
from engines.formats.bvh_text import FPS_RANGE
from engines.formats.files import check_size
from engines.formats.registry import Format
from engines.geometry import rotations
from engines.motion import Motion, Provenance
from engines.skeletons import SMPL22

JOINTS = {66: "bodies alone", 72: "SMPL", 156: "SMPL-H", 165: "SMPL-X"}
"""Accepted widths of `poses`, three numbers a joint."""
_WRITTEN = 156
_RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "framerate")
_KEYS = ("trans", "poses", "root_orient", "pose_body", "betas", "gender", *_RATES)
_LARGEST = 1e6
"""Metres and radians from here on are taken for damage."""
_Y_UP = np.array([np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0])
"""Turns Z up to Y up."""


def read(
    path: str | Path,
    fps: float | None = None,
    frame_rate: float | None = None,
    pelvis: Sequence[float] = (0.0, 0.0, 0.0),
) -> Motion:
    """Read an AMASS file as a motion of `smpl22`.

    Args:
        path: the file.
        fps: rate to resample to; None keeps the file's.
        frame_rate: the file's rate, where it does not say one.
        pelvis: rest place (3,) of the pelvis in the SMPL model the file was made with, metres; see the module.

    Raises:
        FormatError: damaged, not finite, or without `trans`, `poses` (or `root_orient` and `pose_body`) and a rate.
        OutOfRangeError: `fps` is not positive, or `pelvis` not three numbers.
    """
    path, shift = Path(path), _point(pelvis)
    held = arrays.load(path, _KEYS)
    rate = _rate(path, held, frame_rate)
    poses, trans = _poses(path, held)
    check_size(path, len(poses), len(SMPL22))
    turns = rotations.rotvec_to_quaternion(poses[:, : 3 * len(SMPL22)].reshape(len(poses), len(SMPL22), 3))
    turns[:, 0] = rotations.multiply(_Y_UP, turns[:, 0])
    place = rotations.rotate(_Y_UP, trans + shift) - SMPL22.offsets[0]
    parameters: dict = {"format": "amass", "pelvis": shift.tolist()}
    if "betas" in held and held["betas"].dtype.kind == "f" and np.isfinite(held["betas"]).all():
        parameters["betas"] = held["betas"].ravel()[:300].tolist()
    if "gender" in held and held["gender"].dtype.kind in "SU" and held["gender"].size == 1:
        gender = held["gender"].ravel()[0]
        parameters["gender"] = gender.decode("utf-8", "replace") if isinstance(gender, bytes) else str(gender)
    motion = Motion(SMPL22, turns, place, rate, provenance=Provenance(source=path.name, parameters=parameters))
    return motion if fps is None else motion.resample(fps)


def write(motion: Motion, path: str | Path, pelvis: Sequence[float] = (0.0, 0.0, 0.0)) -> Path:
    """Write a motion as AMASS does, in the layout of SMPL-H (T, 156) with open hands.

    Args:
        motion: of any skeleton; others than `smpl22` are retargeted to it first, by their rest pose if that stands
            upright and else by their first frame.
        path: the file.
        pelvis: as for `read`.

    Raises:
        FormatError: the file cannot be written.
        SkeletonError: the skeleton's joints are not recognised, or neither pose stands upright.
        OutOfRangeError: `pelvis` is not three numbers.
    """
    path, shift = Path(path), _point(pelvis)
    motion = _on_smpl22(motion)
    back = rotations.invert(_Y_UP)
    turns = np.array(motion.rotations)
    turns[:, 0] = rotations.multiply(back, turns[:, 0])
    poses = np.zeros((len(motion), _WRITTEN))
    poses[:, : 3 * len(SMPL22)] = rotations.quaternion_to_rotvec(turns).reshape(len(motion), -1)
    place = motion.translation + motion.skeleton.offsets[0]
    made = motion.provenance.parameters if motion.provenance.parameters.get("format") == "amass" else {}
    content = {
        "trans": rotations.rotate(back, place) - shift,
        "poses": poses,
        "betas": np.asarray(made.get("betas", np.zeros(16)), dtype=np.float64),
        "gender": np.array(str(made.get("gender", "neutral"))),
        "mocap_framerate": np.array(motion.fps),
    }
    return arrays.save(path, content)


def _on_smpl22(motion: Motion) -> Motion:
    """The motion with the joints of `smpl22`; bone lengths stay where it has them."""
    if motion.skeleton.joints == SMPL22.joints:
        return motion
    try:
        return motion.retarget(SMPL22)
    except SkeletonError:
        return motion.retarget(SMPL22, reference="first")


def sniff(path: Path, head: bytes) -> bool:
    """Is it a zip archive with `trans` and poses in it?"""
    if not arrays.is_zip(head):
        return False
    held = arrays.names(path)
    return "trans" in held and ("poses" in held or {"root_orient", "pose_body"} <= held)


def _point(pelvis: Sequence[float]) -> np.ndarray:
    """The option `pelvis` as (3,)."""
    point = np.asarray(pelvis, dtype=np.float64)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise OutOfRangeError("pelvis", pelvis, "three numbers, metres")
    return point


def _rate(path: Path, held: dict[str, np.ndarray], given: float | None) -> float:
    """Frames a second, from the file or the caller."""
    if given is not None:
        held = {"frame_rate": np.array(given)}
    key = next((key for key in ("frame_rate", *_RATES) if key in held), None)
    if key is None:
        raise FormatError(
            path, f"no frame rate; accepted: one of {', '.join(_RATES)} (or pass frame_rate=, often 120 or 60)."
        )
    stated = held[key]
    if stated.size != 1 or stated.dtype.kind not in "fiu":
        raise FormatError(path, f"{key} has shape {stated.shape} of {stated.dtype}; accepted: one number.")
    rate = float(stated.ravel()[0])
    if not FPS_RANGE[0] <= rate <= FPS_RANGE[1]:
        raise FormatError(path, f"a frame rate of {rate:g}; accepted: from {FPS_RANGE[0]} to {FPS_RANGE[1]:g}.")
    return rate


def _poses(path: Path, held: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """`poses` (T, 66 or more) and `trans` (T, 3), checked."""
    if "poses" not in held and "root_orient" in held and "pose_body" in held:
        parts = (held["root_orient"], held["pose_body"])
        if any(part.ndim != 2 or len(part) != len(parts[0]) for part in parts):
            raise FormatError(
                path, "root_orient and pose_body are not of as many frames; accepted: (T, 3) and (T, 63)."
            )
        held = {**held, "poses": np.concatenate(parts, axis=1)}
    for key in ("poses", "trans"):
        if key not in held:
            raise FormatError(path, f"array {key!r} is missing; accepted: trans, poses and mocap_framerate.")
        if held[key].dtype.kind != "f":
            raise FormatError(path, f"array {key!r} is of {held[key].dtype}; accepted: floating point numbers.")
    poses, trans = held["poses"], held["trans"]
    if poses.ndim != 2 or poses.shape[1] not in JOINTS or len(poses) == 0:
        widths = ", ".join(f"{width} ({body})" for width, body in JOINTS.items())
        raise FormatError(path, f"poses has shape {poses.shape}; accepted: at least one frame, width {widths}.")
    if trans.shape != (len(poses), 3):
        raise FormatError(path, f"trans has shape {trans.shape}; accepted: ({len(poses)}, 3), as many as poses.")
    sane = (np.abs(poses) < _LARGEST).all(axis=1) & (np.abs(trans) < _LARGEST).all(axis=1)  # False for NaN
    if not sane.all():
        raise FormatError(path, f"frame {np.flatnonzero(~sane)[0]} holds values that are not finite, or beyond reason.")
    return poses.astype(np.float64), trans.astype(np.float64)


FORMAT = Format("amass", (".amass.npz", ".npz"), "AMASS, SMPL poses", sniff, read, write)
