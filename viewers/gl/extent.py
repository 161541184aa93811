"""Where figures may be seen: from a few points on each skeleton to rectangles of the picture and of the floor."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import KDTree

from engines.skeletons.skeleton import Skeleton
from viewers.bodies.body import Body

SLACK, SKIN = 1.2, 0.02
"""In a large pose skin may be farther from the bones than at rest, by this factor and so many metres at most."""
BANDS = 12
"""Strips that the part of the picture with figures in it is cut into, each as narrow as it can be."""


def outline(skeleton: Skeleton, positions: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Points (N, P, 3) along all bones and to their tips, from joints (N, J, 3) and global rotations (N, J, 3, 3)."""
    child = [joint for joint, parent in enumerate(skeleton.parents) if parent >= 0]
    parent = [skeleton.parents[joint] for joint in child]
    points = [positions]
    points += [positions[:, parent] + share * (positions[:, child] - positions[:, parent]) for share in (1 / 3, 2 / 3)]
    ends = [skeleton.index(name) for name in skeleton.end_offsets]
    if ends:
        offsets = np.array(list(skeleton.end_offsets.values()))
        beyond = np.einsum("njab,jb->nja", turns[:, ends], offsets)
        points += [positions[:, ends] + share * beyond for share in (0.5, 1.0)]
    return np.concatenate(points, axis=1)


@lru_cache(maxsize=64)
def reach(body: Body) -> np.ndarray:
    """(P,) metres the skin may reach beyond each point of `outline`, in any pose."""
    rest = body.skeleton.rest_positions[None]
    points = outline(body.skeleton, rest, np.tile(np.eye(3), (1, len(body.skeleton), 1, 1)))[0]
    distance, nearest = KDTree(points).query(body.vertices)
    radii = np.zeros(len(points))
    np.maximum.at(radii, nearest, distance)
    radii = SLACK * radii + SKIN
    radii.setflags(write=False)
    return radii


def project(
    points: np.ndarray, radii: np.ndarray, matrices: np.ndarray, fov: float, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Pixel places (N, P, 2) of points (N, P, 3), and the radii in pixels (N, P) of spheres (P,) around them.

    Points behind the camera come out far larger than the picture, so that nothing is missed.
    """
    padded = np.concatenate([points, np.ones((*points.shape[:2], 1))], axis=-1)
    clip = np.einsum("nab,npb->npa", matrices.astype(np.float64), padded)
    depth = np.maximum(clip[..., 3] - radii, 0.05)
    places = (clip[..., :2] / depth[..., None] + 1.0) / 2 * np.array(size)
    return places, radii / np.tan(fov / 2) / depth * size[1] / 2


def bands(places: np.ndarray, radii: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Rectangles that hold discs in a picture of `size` (width, height).

    Args:
        places: (N, P, 2) centres, pixels.
        radii: (N, P) pixels.
        size: width and height of the picture.

    Returns:
        boxes (N, 4): left, top, width, height of all; strips (N, BANDS, 4) of them: left, top, right, bottom.
    """
    limit = np.array(size)
    low = np.clip(np.floor((places - radii[..., None]).min(1)), 0, limit - 1)
    high = np.clip(np.ceil((places + radii[..., None]).max(1)), low + 1, limit)
    strips = np.zeros((len(places), BANDS, 4))
    edges = np.round(low[:, 1:] + (high - low)[:, 1:] * np.arange(BANDS + 1) / BANDS)
    for band in range(BANDS):
        top, bottom = edges[:, band], edges[:, band + 1]
        within = (places[..., 1] + radii > top[:, None]) & (places[..., 1] - radii < bottom[:, None])
        left = np.where(within, places[..., 0] - radii, np.inf).min(1)
        right = np.where(within, places[..., 0] + radii, -np.inf).max(1)
        strips[:, band] = np.stack(
            [np.clip(np.floor(left), 0, size[0]), top, np.clip(np.ceil(right), 0, size[0]), bottom], axis=-1
        )
    boxes = np.concatenate([low, high - low], axis=1).astype(int)
    return boxes, strips


def shadow_areas(points: np.ndarray, radii: np.ndarray, light: np.ndarray) -> np.ndarray:
    """(N, 4) floor squares of one size (centre x, z, 1 / half side) that hold the shadow of points (N, P, 3)."""
    slant = light[[0, 2]] / light[1]
    places = points[..., [0, 2]] - np.maximum(points[..., 1:2], 0.0) * slant
    low, high = places.min(1), places.max(1)
    half = float((high - low).max()) / 2 + 1.6 * float(radii.max())
    area = np.zeros((len(points), 4))
    area[:, :2] = (low + high) / 2
    area[:, 2] = 1.0 / half
    return area
