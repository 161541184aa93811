"""A silhouette as fine as the picture's edges, from the coarse one that the landmark network gives.

Where the network is sure, it is believed. The band between is decided by what its colours are like nearby, and by
edges: random walks with priors (Grady, "Multilabel random walker image segmentation using prior models", 2005) over the
pixels of the band, one sparse linear system. Larger pictures get it through a guided filter (He and Sun, 2015).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8
from PIL import Image, ImageDraw
from scipy import ndimage, sparse
from scipy.sparse.linalg import cg
from scipy.spatial import KDTree
from scipy.special import expit, logit

from engines.character import landmarks
from engines.character.models import Body

WORKING = 768
"""Pixels of the longer side of what is looked at closely."""
_BAND = 1.75
"""Cells of the coarse silhouette: how far on each side of its edge the finer one may lie."""
_DOUBT = 0.3
"""Besides, what the coarse silhouette says is decided anew where it is further than this from 0 and from 1."""
_SAMPLES = 8_000
"""Pixels at most that stand for what is surely person, and as many for what is surely not."""
_NEIGHBOURS = 6
_NEAR = 0.08
"""Of the crop's side: a pixel so far away counts as unlike as black and white do."""
_SPREAD = 0.01
"""Squared difference of colours (0 to 1) that tells one thing from another."""
_PRIOR = 0.1
"""Weight of a pixel's colours, against an edge to a neighbour of the same colour."""
_CONTRAST = 3.0
"""Fall of an edge's weight with the squared difference of colours, in units of its mean."""
_STEEPER = 3.0
"""Shares are pulled away from a half by so much: a silhouette is mostly there or not."""
_STROKE = 0.008
"""Of the crop's side: width of the lines along limbs in plain sight, which are surely person."""
_LIMBS = tuple(bone for bone in landmarks.BONES if not bone[0].endswith(("_shoulder", "_hip")) or "elbow" in bone[1])


def silhouette(pixels: UInt8[np.ndarray, "H W 3"], looks: Sequence[Body]) -> Float32[np.ndarray, "H W"]:
    """Where a person is in a picture, 0 to 1.

    Args:
        pixels: (H, W, 3) the picture.
        looks: what the network said of one person in crops a little different, one or more; their mean counts.

    Returns:
        (H, W), or zeros where the network sees nobody in the crops.
    """
    height, width = pixels.shape[:2]
    scale = min(1.0, WORKING / max(height, width))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    image = Image.fromarray(pixels)
    small = np.asarray(image.resize(size, Image.Resampling.BOX) if scale < 1 else image, dtype=np.float32) / 255
    coarse = np.mean([_coarse(body, small.shape[:2], scale) for body in looks], axis=0)
    cell = looks[0].crop.side * scale / len(looks[0].inside)
    fine = np.zeros(small.shape[:2], np.float32)
    around = _box(coarse > 0.03, margin=round(8 * cell))
    fine[around] = _refined(small[around], coarse[around], cell)
    return fine if scale == 1 else _enlarged(fine, small, pixels)


def _box(where: Bool[np.ndarray, "h w"], margin: int) -> tuple[slice, slice]:
    """Rows and columns about all that is true."""
    found = ndimage.find_objects(where.astype(np.int8))
    if not found:
        return slice(0, 0), slice(0, 0)
    rows, columns = ((max(0, part.start - margin), part.stop + margin) for part in found[0])
    return slice(*rows), slice(*columns)


def _coarse(body: Body, shape: tuple[int, int], scale: float) -> Float32[np.ndarray, "h w"]:
    """The network's silhouette laid over a picture shrunk by `scale`, with lines along the limbs in plain sight."""
    grid = np.stack(np.meshgrid(np.arange(shape[1]) + 0.5, np.arange(shape[0]) + 0.5), axis=-1) / scale
    at = body.crop.from_picture(grid) * body.inside.shape - 0.5
    laid = ndimage.map_coordinates(body.inside, [at[..., 1], at[..., 0]], np.float32, order=1, cval=0.0)
    strokes = Image.new("L", (shape[1], shape[0]))
    pen = ImageDraw.Draw(strokes)
    for ends in _LIMBS:
        one, other = (landmarks.index(name) for name in ends)
        if min(body.seen[one], body.seen[other]) > 0.8:
            line = [*(body.points[one] * scale), *(body.points[other] * scale)]
            pen.line(line, fill=255, width=max(2, round(_STROKE * body.crop.side * scale)))
    return np.maximum(laid, np.asarray(strokes, dtype=np.float32) / 255)


def _refined(
    colours: Float32[np.ndarray, "h w 3"], coarse: Float32[np.ndarray, "h w"], cell: float
) -> Float32[np.ndarray, "h w"]:
    """The silhouette, decided anew where it is in doubt and in a band about its edge."""
    person = coarse > 0.5
    doubt = np.abs(coarse - 0.5) < 0.5 - _DOUBT
    about = np.asarray(ndimage.binary_dilation(doubt, iterations=max(1, round(cell / 2))))
    band = np.logical_or(_distance(person, ~person) <= max(2.0, _BAND * cell), about)
    sure, never = person & ~band, ~person & ~band
    if not (sure.any() and never.any() and band.any()):
        return coarse
    fine = sure.astype(np.float32)
    alike = _likeness(colours, (sure, never, band), cell * 256)
    trust = np.clip(coarse[band], 0.02, 0.98)
    fine[band] = _walked(colours, fine, band, expit(alike + logit(trust)))
    return np.clip((fine - 0.5) * _STEEPER + 0.5, 0, 1)


def _distance(*parts: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    """Pixels to the farthest of the nearest pixels of each part."""
    return np.max([np.asarray(ndimage.distance_transform_edt(~part)) for part in parts], axis=0)


def _likeness(
    colours: Float32[np.ndarray, "h w 3"], parts: tuple[Bool[np.ndarray, "h w"], ...], side: float
) -> Float[np.ndarray, " n"]:
    """How much more each pixel of the band is like the person nearby than like the rest: a log ratio, -1.5 to 1.5."""
    *known, band = parts
    places = np.moveaxis(np.indices(band.shape, dtype=np.float32), 0, -1) / (_NEAR * side)
    features = np.concatenate([colours, places], axis=-1)
    near = _distance(band) < _NEAR * side
    unlike = []
    for part in known:
        at = np.flatnonzero(part & near)
        tree = KDTree(features.reshape(-1, 5)[at[:: max(1, len(at) // _SAMPLES)]])
        found, _ = tree.query(features[band], k=min(_NEIGHBOURS, tree.n))
        unlike.append((np.reshape(found, (band.sum(), -1)) ** 2).mean(axis=1))
    return np.clip((unlike[1] - unlike[0]) / (2 * _SPREAD), -1.5, 1.5)


def _walked(
    colours: Float32[np.ndarray, "h w 3"],
    fixed: Float32[np.ndarray, "h w"],
    band: Bool[np.ndarray, "h w"],
    alike: Float[np.ndarray, " n"],
) -> Float[np.ndarray, " n"]:
    """Shares of the band: least squares of differences between neighbours, weak over edges, and of `alike`."""
    index, inside = np.arange(band.size).reshape(band.shape), band.ravel()
    pairs = [(index[:-1].ravel(), index[1:].ravel()), (index[:, :-1].ravel(), index[:, 1:].ravel())]
    first, second = np.concatenate(pairs, axis=1)
    touching = inside[first] | inside[second]
    first, second = first[touching], second[touching]
    flat = colours.reshape(-1, 3)
    step = ((flat[first] - flat[second]) ** 2).sum(axis=1)
    weight = np.exp(-_CONTRAST * step / max(step.mean(), 1e-6)) + 1e-4
    links = sparse.coo_matrix((weight, (first, second)), (band.size, band.size)).tocsr()
    links = (links + links.T)[inside]  # (n, h * w)
    diagonal = np.asarray(links.sum(axis=1))[:, 0] + _PRIOR
    system = sparse.diags(diagonal) - links[:, inside]
    right = links @ np.where(inside, 0.0, fixed.ravel()) + _PRIOR * alike
    found, _ = cg(system, right, x0=alike, rtol=1e-3, maxiter=200, M=sparse.diags(1 / diagonal))
    return found


def _enlarged(
    fine: Float32[np.ndarray, "h w"], small: Float32[np.ndarray, "h w 3"], pixels: UInt8[np.ndarray, "H W 3"]
) -> Float32[np.ndarray, "H W"]:
    """The silhouette at the picture's own size: locally a linear function of its grey values."""
    radius, ease = 4, 1e-4
    grey = small.mean(axis=-1)
    means = [ndimage.uniform_filter(x, 2 * radius + 1) for x in (grey, fine, grey * grey, grey * fine)]
    slope = (means[3] - means[0] * means[1]) / (means[2] - means[0] ** 2 + ease)
    offset = means[1] - slope * means[0]
    slope, offset = (ndimage.uniform_filter(x, 2 * radius + 1) for x in (slope, offset))
    height, width = pixels.shape[:2]
    slope, offset = (
        np.asarray(Image.fromarray(x.astype(np.float32)).resize((width, height), Image.Resampling.BILINEAR))
        for x in (slope, offset)
    )
    grey = np.asarray(Image.fromarray(pixels).convert("RGB"), dtype=np.float32).mean(axis=-1) / 255
    return np.clip(slope * grey + offset, 0, 1).astype(np.float32)
