"""The tab Body: which body the takes are shown with, its shape, and the bones of takes to come."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from studio.proportions import bone_scale, factors
from studio.session import Session
from studio.views.binding import follow
from studio.views.parts import BodyPanel

TEXTS = {
    "anny": "Adult (default)", "stick": "Stick figure", "mannequin": "Wooden mannequin", "smpl": "SMPL (your file)",
    "smplh": "SMPL-H (your file)", "smplx": "SMPL-X (your file)",
}  # fmt: skip
"""What the bodies are called."""
LEAST, MOST = 0.75, 1.3
"""Factors on bones; height times one of the others stays within what an engine takes."""


def body_panel(session: Session) -> BodyPanel:
    """The body's name and sliders, and the lengths of bones where the engine takes them."""
    state, dressing = session.state, session.dressing
    part = BodyPanel(sizing_mode="stretch_width", margin=0)

    def body() -> dict[str, Any]:
        return {
            "bodies": [
                {"name": name, "text": TEXTS.get(name, name.removeprefix("character:"))} for name in state.bodies
            ],
            "body": state.body,
            "sliders": [_slider(slider, state.shape) for slider in state.sliders],
            "error": state.body_error,
        }

    def bones() -> dict[str, Any]:
        able, own = "scale_bones" in state.capabilities, bool(state.shape) or not isinstance(state.worn, str)
        note = "This body has bones of its own: lengths set here show in BVH, NPZ and the usual body." if own else ""
        return {"bones": _bones(state.bone_scale) if able else [], "note": note if able and state.bone_scale else ""}

    follow(part, state, ["bodies", "body", "shape", "sliders", "worn", "body_error"], body)
    follow(part, state, ["capabilities", "bone_scale", "shape", "worn"], bones)
    part.on("wear", lambda message: dressing.wear(str(message.get("name", ""))))
    part.on("shape", lambda message: dressing.reshape(_numbers(message), bool(message.get("keep"))))
    part.on("reset", lambda _: dressing.reset())
    part.on("bones", lambda message: _scale(session, _numbers(message)))
    part.on("reset_bones", lambda _: setattr(state, "bone_scale", {}))
    return part


def _numbers(message: Mapping[str, Any]) -> dict[str, float]:
    """The values of a message that are numbers."""
    values = message.get("values")
    given = values.items() if isinstance(values, dict) else ()
    return {str(name): float(value) for name, value in given if isinstance(value, int | float)}


def _slider(slider: Any, shape: Mapping[str, float]) -> dict[str, Any]:
    """What the page shows of a slider: its ends in words where it has them."""
    name = re.sub(r"(\D)(\d+)$", r"\1 \2", slider.name)
    words = re.findall(r"[\d.]+ ([^,]+)", slider.words)
    return {
        "name": slider.name, "text": name.capitalize(), "low": slider.low, "high": slider.high, "step": 0.01,
        "usual": slider.usual, "value": shape.get(slider.name, slider.usual),
        "ends": [words[0], words[-1]] if len(words) > 1 else [],
    }  # fmt: skip


# ---- bones ------------------------------------------------------------------------------------------------


def _bones(scale: Mapping[str, float]) -> list[dict[str, Any]]:
    """The sliders of bones, as settings have them."""
    values = factors(scale)
    return [
        {"name": name, "text": name.capitalize(), "low": LEAST, "high": MOST, "step": 0.01, "usual": 1.0,
         "value": value, "ends": []}
        for name, value in values.items()
    ]  # fmt: skip


def _scale(session: Session, values: Mapping[str, float]) -> None:
    """Bones of the takes to come, some sliders moved."""
    state = session.state
    moved = {name: round(min(max(value, LEAST), MOST), 3) for name, value in values.items()}
    state.bone_scale = bone_scale({**factors(state.bone_scale), **moved})
