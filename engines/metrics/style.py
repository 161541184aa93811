"""Stylised motions: is the style there, is the content still there, how far did the pose move.

Source: generative stylization, section 5.3 of the thesis. Style and content are judged by two classifiers, the
`Recognised` of each; FID over their features, `recognition.accuracy` over their answers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engines.errors import OutOfRangeError, SkeletonError
from engines.geometry import rotations
from engines.metrics import checks, distribution, recognition
from engines.metrics.recognition import Recognised
from engines.motion import Motion


def style_scores(stylised: Recognised, styles: Any, style_features: Any) -> dict[str, float]:
    """Share of stylised motions taken for the wished style, and FID to real motions of those styles.

    Args:
        stylised: the style classifier's view of the N stylised motions.
        styles: (N,) wished styles, as the classifier's labels.
        style_features: (M, D) the same classifier's features of the motions that gave the styles.

    Raises:
        OutOfRangeError: shapes or labels that do not fit.
    """
    return {
        "style_accuracy": recognition.accuracy(stylised.logits, styles),
        "style_fid": distribution.fid(style_features, stylised.features),
    }


def content_scores(stylised: Recognised, contents: Any, content_features: Any) -> dict[str, float]:
    """Share of stylised motions still taken for their content, and FID to the motions they were made from.

    Args:
        stylised: the content (action) classifier's view of the N stylised motions.
        contents: (N,) contents of the motions they were made from, as the classifier's labels.
        content_features: (M, D) the same classifier's features of those motions.

    Raises:
        OutOfRangeError: shapes or labels that do not fit.
    """
    return {
        "content_accuracy": recognition.accuracy(stylised.logits, contents),
        "content_fid": distribution.fid(content_features, stylised.features),
    }


def geodesic_distance(first: Any, second: Any) -> np.ndarray:
    """(...) angle in radians, 0 to pi, between rotation matrices (..., 3, 3).

    From the chord |A - B| and not from the arc cosine of a trace, which near 0 loses half the digits.

    Raises:
        OutOfRangeError: no 3 x 3 matrices, shapes that differ, or values that are not finite.
    """
    one, other = (checks.as_array(values).astype(np.float64) for values in (first, second))
    if one.shape != other.shape or one.shape[-2:] != (3, 3):
        raise OutOfRangeError("shape of the rotations", (one.shape, other.shape), "(..., 3, 3), twice the same")
    if not (np.isfinite(one).all() and np.isfinite(other).all()):
        raise OutOfRangeError("rotations", "NaN or infinite in places", "rotation matrices")
    sine = np.linalg.norm(one - other, axis=(-2, -1)) / np.sqrt(8.0)
    trace = (one * other).sum(axis=(-2, -1))
    return 2.0 * np.arctan2(sine, np.sqrt(np.maximum(1.0 + trace, 0.0)) / 2.0)


def pose_distance(content: Motion, stylised: Motion) -> float:
    """Mean geodesic distance, radians, of the local joint rotations of two motions, over frames and joints.

    The way the body faces is taken out of the root's rotation in each frame: turning on the spot is not a change of
    pose.

    Raises:
        SkeletonError: the skeletons differ; retarget one.
        OutOfRangeError: different numbers of frames or rates.
    """
    if content.skeleton != stylised.skeleton:
        raise SkeletonError(
            f"cannot compare rotations of skeletons {content.skeleton.name!r} and {stylised.skeleton.name!r}; "
            "retarget one of them first."
        )
    if len(content) != len(stylised) or content.fps != stylised.fps:
        raise OutOfRangeError(
            "frames of the stylised motion", f"{len(stylised)} at {stylised.fps:g} fps",
            f"{len(content)} at {content.fps:g} fps, as of its content",
        )  # fmt: skip
    return float(geodesic_distance(_local(content), _local(stylised)).mean())


def _local(motion: Motion) -> np.ndarray:
    """(T, J, 3, 3) parent-relative rotations, the root's without the heading."""
    turns = np.array(motion.rotations)
    turns[:, 0] = rotations.multiply(rotations.yaw_quaternion(-motion.heading), turns[:, 0])
    return rotations.quaternion_to_matrix(turns)
