"""Bones whose length a person sets together."""

from __future__ import annotations

BONES = {
    "Legs": ("left_knee", "right_knee", "left_ankle", "right_ankle"),
    "Arms": ("left_elbow", "right_elbow", "left_wrist", "right_wrist"),
    "Torso": ("spine1", "spine2", "spine3", "neck"),
    "Shoulders": ("left_shoulder", "right_shoulder"),
}
"""Name -> joints; the bone that leads to each is made longer or shorter."""
SHORTEST, LONGEST = 0.7, 1.3
"""Factors on a bone that the sliders go to."""
