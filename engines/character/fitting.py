"""The parametric body fitted to a person seen in a picture, or to a mesh of another tool (thesis eq. 3.13 to 3.16).

L = L_surface + 2.0 L_joints + 0.2 L_reg, with the thesis's factors; the terms are scaled as `evidence` says. As there,
landmarks and prior come first, then the surface with them.

A picture shows no size. Sliders that it says nothing of stay where they usually are, so a person is of the template's
usual height, unless proportions (a child's) or `height=` say otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
from jaxtyping import Float
from scipy.spatial.transform import Rotation
from torch import Tensor

from engines.character import landmarks
from engines.character import prior as priors
from engines.character.depth import rasterised
from engines.character.evidence import ROBUST, Evidence, Scanned, Seen, bone_length, geman_mcclure
from engines.character.marks import Marks, marks
from engines.character.mesh import Surface
from engines.character.outline import overlap
from engines.character.prior import PosePrior
from engines.character.sighting import Sighting
from engines.character.template import Puppet, Template, posed_vertices
from engines.character.view import View
from engines.errors import OutOfRangeError
from engines.geometry import so3
from engines.geometry.kinematics import forward_kinematics
from engines.skeletons.skeleton import Skeleton

JOINTS_WEIGHT, REG_WEIGHT = 2.0, 0.2
"""lambda_j and lambda_r of the thesis."""
ROUNDS = ((40, 5 * ROBUST), (30, ROBUST), *[(10, ROBUST)] * 5)
"""Steps of L-BFGS and how far landmarks pull, in usual errors; from the third on the surface is matched and counts."""
HEIGHT_ERROR = 0.005
"""Metres a height that was told may be off."""
POSE_ENERGY = 8.0
"""What the prior says of a pose counts as one when it is so much: a quarter of what usual poses have."""
SLIDER_SPREAD = 0.25
"""How far sliders lie from their usual values, usually, in half their range."""
FOOT_ERROR = 0.02
"""Metres that heels stand higher or lower than toes, usually."""
BALANCE_ERROR = 0.05
"""Metres that the trunk's middle is before or behind the feet's, usually: who stands does not fall."""
HEIGHTS = (0.5, 2.6)
"""Metres of people accepted."""
MESH_VIEW = View(400.0, (400.0, 900.0))
"""The front view that a fit to a mesh is given."""
ARMS = (0.0, 45.0, 75.0)
"""Degrees below the horizontal that arms of a mesh are looked for at: T-pose, A-pose, hanging."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A template in shape, pose and place. Its lowest vertex stands on the floor, y = 0."""

    template: Template
    """In the fitted shape, at rest."""
    shape: Mapping[str, float]
    """Its sliders."""
    pose: Float[np.ndarray, "J 3 3"]
    """(J, 3, 3) rotations against the parent."""
    root: Float[np.ndarray, " 3"]
    """(3,) place of the root, metres."""
    view: View
    """How the picture sees it; of a mesh, a front view."""
    report: Mapping[str, float]
    """What is left of each term of the loss, and `overlap`, intersection over union of the outlines (of a picture)."""

    @cached_property
    def vertices(self) -> Float[np.ndarray, "V 3"]:
        """(V, 3) the posed template, metres."""
        return posed_vertices(self.template, self.pose, self.root)

    @cached_property
    def joints(self) -> Float[np.ndarray, "J 3"]:
        """(J, 3) its joints, metres."""
        return self._kinematics[0]

    @cached_property
    def turns(self) -> Float[np.ndarray, "J 3 3"]:
        """(J, 3, 3) its joints' rotations against the world."""
        return self._kinematics[1]

    @cached_property
    def _kinematics(self) -> tuple[np.ndarray, np.ndarray]:
        skeleton: Skeleton = self.template.skeleton
        return forward_kinematics(self.pose, self.root, skeleton.offsets, skeleton.parents)


def fit(sighting: Sighting, template: Template, prior: PosePrior | None = None, *, height: float | None = None) -> Fit:
    """Shape, pose and view of the person in a picture.

    Args:
        sighting: landmarks and mask.
        template: the body, in any shape.
        prior: of poses; the shipped one if left out.
        height: of the person, metres, where it is known; between it and the camera's distance no picture decides.

    Returns:
        The fit.

    Raises:
        OutOfRangeError: a height no person has, or an empty mask.
    """
    if height is not None and not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise OutOfRangeError("height", height, f"{HEIGHTS[0]:g} to {HEIGHTS[1]:g} metres")
    if not (sighting.mask >= 0.5).any():
        raise OutOfRangeError("the mask", "empty", "one that covers the person")
    search = _Search(template, prior or priors.load(), height)
    evidence = Seen(sighting, search.faces, bone_length(search.rest_marks))
    turned = _torso(sighting.places).T @ _torso(search.rest_marks)
    start = search.start(Rotation.from_matrix(_nearest_rotation(turned)).as_rotvec())
    state, report = search.run(evidence, start, ROUNDS)
    result = _placed(search, state, evidence.view, report)
    tall, wide = sighting.mask.shape
    shown = rasterised(result.vertices, template.faces, result.view, (wide, tall)).mask
    return replace(result, report={**report, "overlap": overlap(shown, sighting.mask)})


def fit_to_surface(
    surface: Surface,
    template: Template,
    prior: PosePrior | None = None,
    *,
    places: Float[np.ndarray, "33 3"] | None = None,
) -> Fit:
    """Shape and pose of a mesh of another tool, upright in an A- or T-pose and facing +Z.

    Args:
        surface: the mesh, in metres on the floor: see `meshes.read_mesh`.
        template: the body, in any shape.
        prior: of poses; the shipped one if left out.
        places: (33, 3) landmarks, metres, where they are known; without, three ways to hold the arms are tried.

    Returns:
        The fit, in the mesh's place; its `view` is a front view of 400 pixels a metre.
    """
    search = _Search(template, prior or priors.load(), float(np.ptp(surface.vertices[:, 1])))
    evidence = Scanned(surface, places)
    middle = (surface.vertices.min(0) + surface.vertices.max(0)) / 2
    tries = []
    for degrees in ARMS:
        start = search.start(np.zeros(3), degrees)
        start.shift.data[:] = torch.from_numpy(middle - search.middle(start))
        tries.append(search.run(evidence, start, [(10, ROBUST)], matched_from=0))
    state, _ = min(tries, key=lambda found: found[1]["loss"])
    state, report = search.run(evidence, state, [(10, ROBUST)] * 6, matched_from=0)
    return _placed(search, state, MESH_VIEW, report, moved=True)


@dataclass
class _State:
    """What is searched."""

    pose: Tensor
    """(J, 3) rotation vectors."""
    shape: Tensor
    """(S,) sliders from their usual values, in half their range."""
    scale: Tensor
    """() log of the evidence's metres in one of the body's."""
    shift: Tensor
    """(3,) where the root is seen, the evidence's metres."""

    def copy(self) -> _State:
        """Another, to be searched from here."""
        leaves = (self.pose, self.shape, self.scale, self.shift)
        return _State(*(leaf.detach().clone().requires_grad_(True) for leaf in leaves))


class _Search:
    """A template's coarse skin and landmarks, and the minimisation of eq. 3.13 over its shape and pose."""

    def __init__(self, template: Template, prior: PosePrior, height: float | None) -> None:
        self.prior, self.height = prior, height
        self.marks: Marks = marks(template)
        coarse = np.asarray(template.coarse[-1] if template.coarse else template.faces, np.int64)
        chosen = np.unique(np.concatenate([self.marks.vertices, coarse.ravel()]))
        self.puppet = Puppet(template, chosen)
        self.faces = np.searchsorted(chosen, coarse)
        self._soles = [_pair(end) for end in ("heel", "toe")]
        self._trunk = [*_pair("shoulder"), *_pair("hip")]
        rest = self.puppet.vertices[:, 1]
        ends = [int(rest.argmax()), int(rest.argmin())]
        self._fixed = np.concatenate([np.searchsorted(chosen, self.marks.vertices), ends])
        self._span = (self.puppet.high - self.puppet.low) / 2
        still = _State(torch.zeros(len(template.skeleton), 3, dtype=torch.float64), *self._still())
        with torch.no_grad():
            self.rest_marks = self._seen(self._wanted([]), still)[1].numpy()
            """(33, 3) landmarks of the usual body at rest."""
        heel, toe = (self.rest_marks[rows] for rows in self._soles)
        self._heel_height = float((heel - toe)[:, 1].mean())

    def start(self, turn: Float[np.ndarray, " 3"], arms: float | None = None) -> _State:
        """The usual shape and pose, turned by a rotation vector; or standing, `arms` degrees below the horizontal."""
        pose = self.prior.usual.clone()
        if arms is not None:
            pose.zero_()
            skeleton = self.puppet.template.skeleton
            for joint, sign in (("left_shoulder", -1), ("right_shoulder", 1)):
                pose[skeleton.index(joint), 2] = sign * np.deg2rad(arms)
        pose[0] = torch.from_numpy(np.asarray(turn))
        return _State(pose, *self._still())

    def middle(self, state: _State) -> Float[np.ndarray, " 3"]:
        """(3,) of the box around the body."""
        vertices = self._all(state)
        return (vertices.min(0) + vertices.max(0)) / 2

    def run(
        self, evidence: Evidence, state: _State, rounds: Sequence[tuple[int, float]], matched_from: int = 2
    ) -> tuple[_State, dict[str, float]]:
        """Minimise in rounds, with the surface matched anew before each from `matched_from` on.

        Args:
            evidence: what to listen to.
            state: where to begin; left as it is.
            rounds: steps of each, and how far landmarks pull.
            matched_from: rounds before it do without the surface.

        Returns:
            Where it ended, and what is left of each term.
        """
        state = state.copy()
        terms: dict[str, Tensor] = {}
        puppet = self._wanted([])
        for number, (steps, wide) in enumerate(rounds):
            if number >= matched_from:
                puppet = self._wanted(evidence.match(self._all(state)))
            leaves = [
                state.pose,
                state.shape,
                state.shift,
                *evidence.leaves,
                *([] if evidence.metric else [state.scale]),
            ]
            optimiser = torch.optim.LBFGS(leaves, max_iter=steps, history_size=20, line_search_fn="strong_wolfe")

            def closure(
                puppet: Puppet = puppet, wide: float = wide, optimiser: torch.optim.LBFGS = optimiser
            ) -> Tensor:
                optimiser.zero_grad()
                terms.update(self._terms(evidence, puppet, state, wide))
                loss = terms["surface"] + JOINTS_WEIGHT * terms["joints"] + REG_WEIGHT * terms["reg"]
                terms["loss"] = loss
                loss.backward()
                return loss

            optimiser.step(closure)  # pyright: ignore[reportArgumentType]
        return state, {name: float(term.detach()) for name, term in terms.items()}

    def _terms(self, evidence: Evidence, puppet: Puppet, state: _State, wide: float) -> dict[str, Tensor]:
        seen, placed, height = self._seen(puppet, state)
        heel, toe = (placed[rows] for rows in self._soles)
        raised = (heel[:, 1] - toe[:, 1] - self._heel_height) / FOOT_ERROR
        stance = (0.7 * heel + 0.3 * toe).mean(0)
        falling = (placed[self._trunk].mean(0) - stance)[2] / BALANCE_ERROR
        beyond = (state.shape.abs() - 1).clamp(min=0)
        reg = self.prior.energy(state.pose) / POSE_ENERGY + (state.shape / SLIDER_SPREAD).square().mean()
        reg = reg + 100 * beyond.square().sum() + geman_mcclure(raised.square(), ROBUST / 2).mean()
        reg = reg + geman_mcclure(falling.square(), ROBUST / 2)
        if self.height is not None:
            reg = reg + ((height - self.height) / HEIGHT_ERROR).square()
        return {"surface": evidence.surface(seen), "joints": evidence.joints(placed, wide), "reg": reg}

    def _wanted(self, rows: Sequence[int] | np.ndarray) -> Puppet:
        """The puppet of what is always looked at, the landmarks and the body's ends, and of some more vertices."""
        return self.puppet.only(torch.from_numpy(np.concatenate([self._fixed, rows]).astype(np.int64)))

    def _all(self, state: _State) -> Float[np.ndarray, "N 3"]:
        """(N, 3) all vertices in the evidence's metres."""
        with torch.no_grad():
            return self._seen(self._wanted(np.arange(len(self.puppet.vertices))), state)[0].numpy()

    def _seen(self, puppet: Puppet, state: _State) -> tuple[Tensor, Tensor, Tensor]:
        """Vertices wanted (M, 3) and landmarks (33, 3) in the evidence's metres, and the body's height, metres."""
        values = puppet.usual + state.shape * self._span
        turns = so3.rotvec_to_matrix(state.pose)
        vertices, joints, turns = puppet.posed(values, turns, torch.zeros_like(state.shift))
        known = len(self.marks.vertices)
        placed = self.marks.placed(vertices[:known], joints, turns)
        top, sole = puppet.rest(values)[0][known : known + 2, 1]
        scale = state.scale.exp()
        return vertices[known + 2 :] * scale + state.shift, placed * scale + state.shift, top - sole

    def _still(self) -> tuple[Tensor, Tensor, Tensor]:
        """Usual shape, scale 1, no shift."""
        return torch.zeros_like(self.puppet.usual), torch.zeros((), dtype=torch.float64), torch.zeros(3).double()

    def shape(self, state: _State) -> dict[str, float]:
        """The sliders, within their bounds."""
        return self.puppet.shape(self.puppet.usual + state.shape * self._span)


def _placed(search: _Search, state: _State, view: View, report: dict[str, float], moved: bool = False) -> Fit:
    """The search's end as a fit that stands on the floor; of a picture over the origin, of a mesh where that is."""
    shape = search.shape(state)
    shaped = search.puppet.template.shaped(**shape)
    pose = so3.rotvec_to_matrix(state.pose.detach()).numpy()
    shift, scale = state.shift.detach().numpy(), float(state.scale.detach().exp())
    root = shift * (1, 0, 1) if moved else np.zeros(3)
    root = root - (0, posed_vertices(shaped, pose, root)[:, 1].min(), 0)
    if not moved:  # evidence's metres = scale * (world - root) + shift
        origin = view.project(shift - scale * root)
        view = View(view.scale * scale, (float(origin[0]), float(origin[1])))
    return Fit(shaped, shape, pose, root, view, report)


def _pair(name: str) -> list[int]:
    """Left and right landmark of a name."""
    return [landmarks.index(f"{side}_{name}") for side in ("left", "right")]


def _torso(places: np.ndarray) -> np.ndarray:
    """(4, 3) shoulders and hips about their middle."""
    points = places[[*_pair("shoulder"), *_pair("hip")]]
    return points - points.mean(0)


def _nearest_rotation(matrix: np.ndarray) -> np.ndarray:
    """(3, 3) the rotation nearest to a matrix (Kabsch)."""
    left, _, right = np.linalg.svd(matrix)
    return left @ np.diag([1, 1, np.sign(np.linalg.det(left @ right))]) @ right
