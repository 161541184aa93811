"""A surface that fits a posed body, made a character: skin weights from the body, and the surface in the rest pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from scipy import sparse
from scipy.sparse.linalg import splu

from engines.character.arap import AsRigidAsPossible
from engines.character.character import Character
from engines.character.correspondence import Correspondence, matched
from engines.character.fitting import Fit
from engines.character.mesh import Surface
from engines.character.template import Template
from engines.geometry.skins import blended, skinning_matrices, strongest

SOFTNESS = 3.0
"""How many times its own weights a vertex listens to its neighbours'."""
NEAREST = 4
"""Vertices of the body whose weights are mixed, by nearness."""
FREE = 0.02
"""How much a vertex without a pair is held to where skinning takes it, against one with."""


def rigged(surface: Surface, fit: Fit, name: str, provenance: Mapping[str, Any] | None = None) -> Character:
    """A character of a surface and the body fitted to it.

    Args:
        surface: in the pose of the fit, with whatever colours or texture it has.
        fit: the body.
        name: of the character.
        provenance: what it was made of and how, for the record.
    """
    whole = _welded(surface)
    pairs = matched(whole, fit)
    indices, weights = strongest(transferred(whole, pairs, fit.template))
    hold = np.where(pairs.paired, np.maximum(weights.max(axis=1) ** 4, FREE), FREE)  # several joints: not to be trusted
    vertices = undone(whole, indices, weights, pairs.paired, fit)
    group = surface.groups
    return Character(
        name=name,
        surface=surface.replaced(vertices=vertices[group]),
        skin_indices=indices[group].astype(np.uint16),
        skin_weights=weights[group].astype(np.float32),
        hold=hold[group].astype(np.float32),
        skeleton=fit.template.skeleton,
        shape=dict(fit.shape),
        provenance=dict(provenance or {}),
    )


def transferred(surface: Surface, pairs: Correspondence, template: Template) -> Float[np.ndarray, "N J"]:
    """Skin weights of every joint: those of the paired vertices, by nearness, made smooth over the surface.

    Smoothing goes along the surface, never through the air, so an arm beside the trunk does not take part of its
    weights; what has no pair gets its surroundings'.

    Args:
        surface: without seams.
        pairs: its vertices and the template's.
        template: whose weights they are.
    """
    near = 1.0 / (pairs.distances[:, :NEAREST] + 1e-3)  # nothing where there is no pair
    share = near / np.maximum(near.sum(1, keepdims=True), 1e-12)
    weights = np.zeros((len(surface.vertices), len(template.skeleton)))
    rows = np.arange(len(weights))
    for place in range(NEAREST):
        vertex = pairs.vertices[:, place]
        for influence in range(template.skin_indices.shape[1]):
            joint, weight = template.skin_indices[vertex, influence], template.skin_weights[vertex, influence]
            weights[rows, joint] += share[:, place] * weight
    own = pairs.paired.astype(np.float64)
    alone = 1e-6 * (1 - own)
    if not own.any():
        own[:] = 1.0
    links = _links(surface)
    degree = np.maximum(links.sum(axis=1), 1e-12)
    matrix = sparse.diags_array(own + alone + SOFTNESS) - SOFTNESS * sparse.diags_array(1 / degree) @ links
    smooth = splu(sparse.csc_matrix(matrix)).solve(own[:, None] * weights)
    smooth = np.maximum(smooth, 0.0)
    total = smooth.sum(1, keepdims=True)
    root = np.eye(len(template.skeleton))[0]  # of a piece that hangs on nothing
    return np.where(total > 1e-9, smooth / np.maximum(total, 1e-12), root)


def undone(
    surface: Surface,
    indices: np.ndarray,
    weights: Float[np.ndarray, "N 4"],
    paired: Bool[np.ndarray, " N"],
    fit: Fit,
) -> Float[np.ndarray, "N 3"]:
    """The surface in the rest pose (N, 3), metres: every vertex carried back by its own matrix.

    Where joints that share a vertex turn far apart, that matrix flattens and folds; there the shape is the picture's,
    as rigid as possible (eq. 3.18), between what is carried well.

    Args:
        surface: in the pose of the fit, without seams.
        indices: (N, 4) joints of its vertices.
        weights: (N, 4) and how much.
        paired: (N,) which of them are known to hang on those joints.
        fit: whose pose is undone.
    """
    matrices = skinning_matrices(fit.template.skeleton, fit.joints, fit.turns)
    own = blended(matrices, indices, weights)
    back = np.linalg.solve(own[:, :, :3], (surface.vertices - own[:, :, 3])[..., None])[..., 0]
    flattened = np.linalg.svd(own[:, :, :3], compute_uv=False)[:, -1]  # 1 for a rotation, 0 for a plane
    hold = np.where(paired, np.maximum(flattened**8, FREE), FREE)
    return AsRigidAsPossible(surface.vertices, surface.faces, hold).deformed(back)


def _welded(surface: Surface) -> Surface:
    """The surface with one vertex at each place."""
    first = np.unique(surface.groups, return_index=True)[1]
    parts = None if surface.parts is None else surface.parts[first]
    bare = replace(surface, colours=None, uv=None, texture=None, parts=None)
    return bare.replaced(vertices=surface.vertices[first], faces=surface.groups[surface.faces], parts=parts)


def _links(surface: Surface) -> sparse.csr_array:
    """(N, N) 1 between vertices that share an edge."""
    ends = surface.faces[:, [0, 1, 2, 1, 2, 0]].T.ravel(), surface.faces[:, [1, 2, 0, 0, 1, 2]].T.ravel()
    links = sparse.csr_array((np.ones(len(ends[0])), ends), shape=(len(surface.vertices),) * 2)
    links.data[:] = 1.0
    links.setdiag(0)
    return links
