"""The animation of a .glb: keys in time, of which frames are made."""

from __future__ import annotations

from typing import Any

import numpy as np

from engines.errors import FormatError
from engines.formats.bvh_text import FPS_RANGE
from engines.formats.gltf import Gltf
from engines.geometry import rotations

MAX_JOINT_FRAMES = 3_000_000
"""Frames times nodes of an animation that is read: a quarter of an hour of 25 joints at 120 fps."""
USUAL_FPS = 30.0
"""Rate of an animation whose keys follow none."""
_WIDTH = {"translation": 3, "rotation": 4, "scale": 3}


class Tracks:
    """The keys of one animation, by node.

    Args:
        gltf: the file.
        animation: number or name of the animation.

    Raises:
        FormatError: there is no such animation, or it is damaged; the message lists those there are.
    """

    def __init__(self, gltf: Gltf, animation: int | str) -> None:
        self.gltf = gltf
        chosen = _choose(gltf, animation)
        self.name = str(chosen.get("name", ""))
        self._times: dict[Any, np.ndarray] = {}
        self._keys: dict[tuple[int, str], tuple[np.ndarray, Any, str]] = {}
        samplers = chosen["samplers"]
        for channel in chosen["channels"]:
            target = channel["target"]
            node, what = target.get("node"), target.get("path")
            if not isinstance(node, int) or what not in _WIDTH:
                continue  # weights of morph targets, or what an extension animates
            gltf.item("nodes", node)
            number = channel["sampler"]
            if not isinstance(number, int) or not 0 <= number < len(samplers):
                raise FormatError(gltf.path, f"animation {self.name!r} lacks sampler {number!r:.40}.")
            sampler = samplers[number]
            times = self._input(sampler["input"])
            self._keys[node, what] = (times, sampler["output"], str(sampler.get("interpolation", "LINEAR")))
        self._extras = chosen.get("extras")

    @property
    def nodes(self) -> set[int]:
        """The nodes that move."""
        return {node for node, _ in self._keys}

    def frames(self, nodes: list[int]) -> tuple[np.ndarray, float]:
        """Times of the frames (T,), seconds, and their rate, from the keys of these nodes.

        Raises:
            FormatError: no keys, or more frames than are read.
        """
        path, wanted = self.gltf.path, set(nodes)
        inputs = [times for (node, _), (times, _, _) in self._keys.items() if node in wanted]
        if not inputs:
            raise FormatError(path, f"animation {self.name!r} moves none of its joints.")
        start, end = min(times[0] for times in inputs), max(times[-1] for times in inputs)
        fps = self._rate(max(inputs, key=len))
        if not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
            raise FormatError(path, f"a frame rate of {fps:g}; accepted: from {FPS_RANGE[0]} to {FPS_RANGE[1]:g}.")
        most = MAX_JOINT_FRAMES // max(len(nodes), 1)
        if (end - start) * fps > most:
            raise FormatError(path, f"lasts {end - start:,.0f} s at {fps:g} fps; accepted: at most {most:,} frames.")
        return start + np.arange(round((end - start) * fps) + 1) / fps, fps

    def sampled(self, node: int, what: str, at: np.ndarray) -> np.ndarray | None:
        """(T, 3), or (T, 4) wxyz, of a node's translation, rotation or scale at times (T,); None where it has no keys.

        Raises:
            FormatError: keys and values do not fit.
        """
        if (node, what) not in self._keys:
            return None
        times, output, mode = self._keys[node, what]
        values = self.gltf.array(output)
        per_key = 3 if mode == "CUBICSPLINE" else 1
        if values.shape != (per_key * len(times), _WIDTH[what]) or mode not in ("LINEAR", "STEP", "CUBICSPLINE"):
            raise FormatError(self.gltf.path, f"the {what} of node {node} does not fit its {len(times):,} keys.")
        if what == "rotation":
            values = values[:, [3, 0, 1, 2]]  # glTF has w last
        made = _between(times, values, mode, at, what == "rotation")
        return rotations.normalise(made) if what == "rotation" else made

    def _input(self, accessor: object) -> np.ndarray:
        """Times of keys, seconds, known to rise."""
        if not isinstance(accessor, int):
            raise FormatError(self.gltf.path, f"animation {self.name!r} has keys without times.")
        if accessor not in self._times:
            times = self.gltf.array(accessor)
            if times.ndim != 1 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
                raise FormatError(self.gltf.path, f"animation {self.name!r} has times that do not rise.")
            self._times[accessor] = times
        return self._times[accessor]

    def _rate(self, times: np.ndarray) -> float:
        """Frames a second: of the keys where they are even, the nearest whole one if that is meant; else the usual."""
        stated = self._extras.get("fps") if isinstance(self._extras, dict) else None
        stated = float(stated) if isinstance(stated, int | float) and np.isfinite(stated) and stated > 0 else None
        if len(times) < 2:
            return stated or USUAL_FPS
        steps = np.diff(times)
        if (np.abs(steps / steps.mean() - 1.0) > 0.02).any():
            return USUAL_FPS
        fps = float(1.0 / steps.mean())
        for meant in (stated, float(round(fps))):
            if meant and abs(meant / fps - 1.0) < 1e-4:
                return meant
        return fps


def _choose(gltf: Gltf, animation: int | str) -> dict[str, Any]:
    """The animation of that number or name."""
    held = gltf.items("animations")
    if not held:
        raise FormatError(gltf.path, "holds no animation; accepted: a .glb with an animated skeleton.")
    names = [str(item.get("name", "")) for item in held]
    if animation in names:
        return held[names.index(str(animation))]
    if not isinstance(animation, int) or not 0 <= animation < len(held):
        listed = ", ".join(f"{i} {name!r:.60}" for i, name in enumerate(names[:12]))
        raise FormatError(gltf.path, f"has no animation {animation!r}; it has {listed}.")
    return held[animation]


def _between(times: np.ndarray, values: np.ndarray, mode: str, at: np.ndarray, turning: bool) -> np.ndarray:
    """(T, width) values at times `at`, by glTF's three ways of joining keys (specification, appendix C)."""
    at = np.clip(at, times[0], times[-1])
    if (
        mode != "CUBICSPLINE"
        and len(times) == len(at)
        and np.abs(times - at).max() < 1e-3 * max(at[-1] / len(at), 0.01)
    ):
        return values  # frames are keys
    last = np.clip(np.searchsorted(times, at, side="right") - 1, 0, max(len(times) - 2, 0))
    if len(times) == 1:
        middle = values[1:2] if mode == "CUBICSPLINE" else values
        return np.repeat(middle, len(at), axis=0)
    if mode == "STEP":
        return values[np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 1)]
    if mode == "CUBICSPLINE":
        return _spline(times, values, at, last)
    if turning:
        return rotations.slerp(times, rotations.normalise(values)[:, None], at)[:, 0]
    return np.stack([np.interp(at, times, values[:, axis]) for axis in range(values.shape[1])], axis=-1)


def _spline(times: np.ndarray, values: np.ndarray, at: np.ndarray, last: np.ndarray) -> np.ndarray:
    """(T, width) by Hermite splines; `values` are incoming tangent, value and outgoing tangent of each key in turn."""
    arriving, points, leaving = values[0::3], values[1::3], values[2::3]
    step = (times[last + 1] - times[last])[:, None]
    t = ((at - times[last])[:, None]) / step
    return (
        (2 * t**3 - 3 * t**2 + 1) * points[last]
        + step * (t**3 - 2 * t**2 + t) * leaving[last]
        + (3 * t**2 - 2 * t**3) * points[last + 1]
        + step * (t**3 - t**2) * arriving[last + 1]
    )
