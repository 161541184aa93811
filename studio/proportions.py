"""Lengths of bones as a person sets them: a few sliders, each of several bones."""

from __future__ import annotations

from collections.abc import Mapping

BONES = {
    "legs": ("left_knee", "right_knee", "left_ankle", "right_ankle"),
    "arms": ("left_elbow", "right_elbow", "left_wrist", "right_wrist"),
    "torso": ("spine1", "spine2", "spine3", "neck"),
    "shoulders": ("left_shoulder", "right_shoulder"),
}
"""Slider -> bones, by the joints they lead to; "height" is all of them."""
SHORTEST, LONGEST = 0.7, 1.3
"""Factors on a bone that sliders go to where there is none for the height."""


def factors(scale: Mapping[str, float]) -> dict[str, float]:
    """Slider -> factor, of what settings say of joints."""
    height = scale.get("*", 1.0)
    parts = {name: round(scale.get(joints[0], height) / height, 3) for name, joints in BONES.items()}
    return {"height": height, **parts}


def bone_scale(values: Mapping[str, float]) -> dict[str, float]:
    """Settings of joints, of slider -> factor; the reverse of `factors`."""
    height = values.get("height", 1.0)
    scale = {"*": height} if height != 1.0 else {}
    for name, joints in BONES.items():
        if values.get(name, 1.0) != 1.0:
            scale |= dict.fromkeys(joints, round(height * values[name], 4))
    return scale


def proportions(scale: Mapping[str, float]) -> str:
    """Lengths of bones in words: by sliders where these say it all, else by joints."""
    values = {name: factor for name, factor in factors(scale).items() if factor != 1.0}
    said = values if bone_scale(values) == dict(scale) else scale
    return ", ".join(f"{name} × {factor:g}" for name, factor in said.items())
