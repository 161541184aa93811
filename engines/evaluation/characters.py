"""Truth for characters made of pictures: bodies of known shape, pose and colours, drawn from the front and behind."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, UInt8
from scipy.spatial import KDTree

from engines.character.depth import rasterised
from engines.character.fitting import fit
from engines.character.making import facing
from engines.character.mesh import Surface
from engines.character.outline import overlap
from engines.character.picture import Picture
from engines.character.sighting import Sighting
from engines.character.surface import clothed
from engines.character.template import Template, posed_vertices, strongest_joints
from engines.character.texture import Front, interpolated, painted
from engines.character.view import View
from engines.geometry.kinematics import forward_kinematics
from engines.geometry.rotations import rotvec_to_matrix

BACKDROP = (188, 190, 186)
"""sRGB behind the person."""
LOGO = (235, 40, 60)
"""sRGB of a disc printed on the chest, and nowhere else: what must not come out on the back."""


@dataclass(frozen=True, eq=False)
class Known:
    """A body of which everything is known, before a camera."""

    template: Template
    """With its shape."""
    colours: UInt8[np.ndarray, "V 3"]
    """(V, 3) sRGB of its vertices."""
    pose: Float[np.ndarray, "J 3 3"]
    """(J, 3, 3) rotations against the parent."""
    root: Float[np.ndarray, " 3"]
    """(3,) place of the root, metres."""
    view: View
    size: tuple[int, int]
    """Width and height of the pictures, pixels."""

    @cached_property
    def surface(self) -> Surface:
        """The body in its pose, with its colours (the printed disc excepted) and parts."""
        vertices = posed_vertices(self.template, self.pose, self.root)
        return Surface(vertices, self.template.faces, self.colours, parts=strongest_joints(self.template))

    @cached_property
    def joints(self) -> Float[np.ndarray, "J 3"]:
        """(J, 3) its joints, metres."""
        skeleton = self.template.skeleton
        return forward_kinematics(self.pose, self.root, skeleton.offsets, skeleton.parents)[0]

    @cached_property
    def front(self) -> tuple[Picture, Bool[np.ndarray, "H W"]]:
        """What the camera sees, and (H, W) where the body is."""
        return self._drawn(self.surface.vertices)

    @cached_property
    def back(self) -> tuple[Picture, Bool[np.ndarray, "H W"]]:
        """What a second camera behind the body sees."""
        return self._drawn(turned(self.surface.vertices))

    def _drawn(self, vertices: np.ndarray) -> tuple[Picture, np.ndarray]:
        faces = self.surface.faces
        shown = rasterised(vertices, faces, self.view, self.size)
        body = interpolated(shown, faces, self.colours)  # (P, 3)
        rest = interpolated(shown, faces, self.template.vertices)
        body[(np.hypot(rest[:, 0], rest[:, 1] - 0.33) < 0.07) & (rest[:, 2] > 0.03)] = LOGO
        lit = 0.88 + 0.12 * interpolated(shown, faces, self.surface.normals)[:, 1:2]  # a lamp overhead
        pixels = np.tile(np.array(BACKDROP, np.uint8), (*shown.mask.shape, 1))
        pixels[shown.mask] = np.round(body * lit).clip(0, 255)
        return Picture(pixels, "known"), shown.mask


def turned(vertices: Float[np.ndarray, "N 3"]) -> Float[np.ndarray, "N 3"]:
    """(N, 3) with their back to the camera."""
    return vertices * (-1.0, 1.0, -1.0)


def standing(template: Template, arms: float = 0.9, bend: float = 0.15, turn: float = 0.0) -> np.ndarray:
    """(J, 3, 3) rotations of someone who stands with arms down.

    Args:
        template: gives the skeleton.
        arms: radians the arms are lowered from the T-pose.
        bend: radians the elbows are bent forward.
        turn: radians the body is turned to its left.
    """
    pose = np.zeros((len(template.skeleton), 3))
    pose[0, 1] = turn
    for side, sign in (("left", -1.0), ("right", 1.0)):
        pose[template.skeleton.index(f"{side}_shoulder"), 2] = sign * arms
        pose[template.skeleton.index(f"{side}_elbow"), 1] = sign * bend
    return rotvec_to_matrix(pose)


def framed(vertices: Float[np.ndarray, "N 3"], height: int) -> tuple[View, tuple[int, int]]:
    """A view and a size in pixels, `height` high, that show vertices with some room around them."""
    low, high = vertices.min(0), vertices.max(0)
    scale = height / (1.12 * (high[1] - low[1]))
    width = round(scale * (high[0] - low[0]) + 0.12 * height)
    middle = (low + high) / 2
    return View(scale, (width / 2 - scale * middle[0], height / 2 + scale * middle[1])), (width, height)


def chamfer(one: Float[np.ndarray, "N 3"], other: Float[np.ndarray, "M 3"]) -> float:
    """Mean distance to the other's nearest point, both ways averaged, metres."""
    there, back = KDTree(other).query(one)[0].mean(), KDTree(one).query(other)[0].mean()
    return float(there + back) / 2


def mirrored(surface: Surface, front: Front) -> Surface:
    """The simplest way to colour what is unseen: the picture goes right through."""
    return surface.replaced(colours=np.round(front.colours(surface.vertices)).astype(np.uint8))


def nearest_copy(surface: Surface, front: Front) -> Surface:
    """The other simple way: every vertex has the colour of the nearest that is seen."""
    seen = np.flatnonzero(front.sureness(surface.vertices, surface.normals) > 0.5)
    nearest = seen[KDTree(surface.vertices[seen]).query(surface.vertices)[1]]
    return surface.replaced(colours=np.round(front.colours(surface.vertices[nearest])).astype(np.uint8))


def back_error(known: Known, surface: Surface) -> float:
    """Mean colour difference seen from behind, 0 to 255 a channel, where both bodies are."""
    picture, mask = known.back
    surface = surface.coloured()
    assert surface.colours is not None
    shown = rasterised(turned(surface.vertices), surface.faces, known.view, known.size)
    made = interpolated(shown, surface.faces, surface.colours)
    return float(np.abs(made - picture.pixels[shown.mask])[mask[shown.mask]].mean())


def laid_over(points: Float[np.ndarray, "N 3"], view: View, known: Known) -> Float[np.ndarray, "N 3"]:
    """Points as `view` shows them, in the metres of the known body's view; a picture tells no size and no depth.

    What is left free, the depth of all of them together, is for whoever compares.
    """
    flat = known.view.unproject(view.project(points))
    flat[:, 2] = points[:, 2] * view.scale / known.view.scale
    return flat


def measured(known: Known, template: Template, sighting: Sighting) -> dict[str, float]:
    """How near the truth a character comes that is made from the known body's picture alone.

    Args:
        known: the truth.
        template: what is fitted, in its usual shape.
        sighting: what was seen in `known.front`.

    Returns:
        `mask`, `body` and `clothed`: overlaps of silhouettes with the true one; `joints`, millimetres, mean; `chamfer`,
        millimetres; `back`, `mirrored` and `nearest`: colour errors from behind of ours and of the two simple ways.
    """
    picture, mask = known.front
    found = fit(sighting, template)
    surface = clothed(found, sighting)
    front = Front.of(surface, picture, sighting.mask, found.view)

    def silhouette(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
        return rasterised(vertices, faces, found.view, known.size).mask

    joints = laid_over(found.joints, found.view, known)
    deeper = np.array([0.0, 0.0, known.joints[:, 2].mean() - joints[:, 2].mean()])
    over = laid_over(surface.vertices, found.view, known) + deeper
    used = known.surface.vertices[np.unique(known.surface.faces)]

    def error(coloured: Surface) -> float:
        return back_error(known, coloured.replaced(vertices=over))

    return {
        "mask": overlap(sighting.mask, mask),
        "body": overlap(silhouette(found.vertices, found.template.faces), mask),
        "clothed": overlap(silhouette(surface.vertices, surface.faces), mask),
        "joints": 1000 * float(np.linalg.norm(joints + deeper - known.joints, axis=1).mean()),
        "chamfer": 1000 * chamfer(over, used),
        "back": error(painted(surface, front, face=facing(found))),
        "mirrored": error(mirrored(surface, front)),
        "nearest": error(nearest_copy(surface, front)),
    }
