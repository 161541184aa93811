"""The 33 landmarks of BlazePose by name, and which joints of the house skeleton they stand for."""

from __future__ import annotations

from engines.errors import UnknownLabelError

_SIDED = ("shoulder", "elbow", "wrist", "pinky", "index", "thumb", "hip", "knee", "ankle", "heel", "toe")
NAMES: tuple[str, ...] = (
    "nose",
    *(f"{side}_eye_{part}" for side in ("left", "right") for part in ("inner", "middle", "outer")),
    *("left_ear", "right_ear", "left_mouth", "right_mouth"),
    *(f"{side}_{name}" for name in _SIDED for side in ("left", "right")),
)
"""In the network's order. Left and right are the person's own. Fingers are knuckles; toe is the big toe's tip."""

JOINTS: dict[str, str] = {
    f"{side}_{landmark}": f"{side}_{joint}"
    for side in ("left", "right")
    for landmark, joint in {
        "shoulder": "shoulder",
        "elbow": "elbow",
        "wrist": "wrist",
        "hip": "hip",
        "knee": "knee",
        "ankle": "ankle",
        "toe": "foot",
    }.items()
}
"""Landmark to the nearest joint of `smpl22`. Joints along the spine have no landmark."""

BONES: tuple[tuple[str, str], ...] = (
    ("left_shoulder", "right_shoulder"),
    ("left_hip", "right_hip"),
    *(
        (f"{side}_{a}", f"{side}_{b}")
        for side in ("left", "right")
        for a, b in (
            ("shoulder", "elbow"),
            ("elbow", "wrist"),
            ("shoulder", "hip"),
            ("hip", "knee"),
            ("knee", "ankle"),
            ("ankle", "heel"),
            ("heel", "toe"),
        )
    ),
)
"""Lines between landmarks, for drawing them over a picture."""


def index(name: str) -> int:
    """Where a landmark stands in `NAMES`.

    Raises:
        UnknownLabelError: nowhere.
    """
    try:
        return NAMES.index(name)
    except ValueError:
        raise UnknownLabelError("landmark", name, NAMES) from None
