"""Clothes, shoes, hair and face of the default body, all made by cutting and lifting its own skin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull

from engines.skeletons import SMPL22
from viewers.bodies.baking.simplify import simplify
from viewers.bodies.baking.surface import Garments, Lining, averaging, cut, fair, smooth, thicken
from viewers.bodies.baking.weights import SkinMesh, components

SKIN, BROWS, HAIR, EYES, IRIS, SOCKS, SHOES, SOLES, TROUSERS, SHIRT, LEFT_CUFF, RIGHT_CUFF = range(12)
"""Regions; where two meet, the later one lies over the earlier."""

COLOURS = {
    SKIN: "#d6a384", BROWS: "#6e4e3c", HAIR: "#4d382d", EYES: "#f2efec", IRIS: "#4b3527", SOCKS: "#c9ced6",
    SHOES: "#8f99a8", SOLES: "#eceff3", TROUSERS: "#505f7a", SHIRT: "#86aee0", LEFT_CUFF: "#56b4e9",
    RIGHT_CUFF: "#e69f00",
}  # fmt: skip
TINT = {SHIRT: 1.0, TROUSERS: 0.28}
THICKNESS = {
    SHIRT: 0.009, LEFT_CUFF: 0.011, RIGHT_CUFF: 0.011, TROUSERS: 0.005, SOCKS: 0.0015, BROWS: 0.0006,
}  # fmt: skip

LEVELS = (6600, 2400)
"""Faces of the coarser levels, before rims."""
SOLE = float(SMPL22.rest_positions[SMPL22.index("left_ankle"), 1]) - 0.0772
"""Height of the ground under the rest pose."""
_HEM_SHIRT, _HEM_TROUSERS, _TOP_SHOE, _TOP_SOCK = -0.020, -0.835, -0.872, -0.80
_CUFF, _SLEEVE = 0.325, 0.350
_HAIRLINE = (
    (-0.08, -0.035, 0.0, 0.022, 0.045, 0.062, 0.085, 0.110, 0.145),
    (0.585, 0.590, 0.612, 0.640, 0.648, 0.690, 0.722, 0.735, 0.737),
)
"""Depth and height of the line where hair begins."""


@dataclass(frozen=True)
class Dressed:
    """The finished body, at full precision."""

    garments: Garments
    colours: np.ndarray
    """(V, 3) uint8 sRGB."""
    tint: np.ndarray
    """(V,) share of an actor's own colour."""


def dress(mesh: SkinMesh) -> Dressed:
    """Clothe and colour the bare mesh in its rest pose."""
    mesh = sculpt_shoes(soften(friendly(mesh)))
    parts = components(mesh.faces, len(mesh.vertices))
    eyeball = parts != np.bincount(parts).argmax()
    regions = np.where(eyeball[mesh.faces[:, 0]], EYES, SKIN)
    for region, field, over in _outlines():
        mesh, regions = _both(cut(mesh, regions, field(mesh.vertices), region, over))
    importance = 1.0 + 6.0 * (mesh.vertices[:, 1] > 0.55) + 1.5 * (np.abs(mesh.vertices[:, 0]) > 0.7)
    coarse = simplify(mesh, regions, importance, LEVELS)
    lining = Lining(TROUSERS, SHIRT, mesh.vertices[:, 1] < _HEM_SHIRT + 0.08)
    garments = loosen(thicken(mesh, (mesh.faces, regions), _thickness(mesh.vertices), coarse, lining))
    return Dressed(garments, _colours(garments), np.array([TINT.get(int(r), 0.0) for r in garments.region]))


def loosen(garments: Garments) -> Garments:
    """The shirt hangs from the trunk: its lower edge follows the thighs only a little."""
    weights = np.array(garments.weights)
    free = 0.85 * (garments.region == SHIRT) * _ramp(-garments.vertices[:, 1], -0.06, 0.0)
    pelvis = SMPL22.index("pelvis")
    for hip in (SMPL22.index("left_hip"), SMPL22.index("right_hip")):
        weights[:, pelvis] += free * weights[:, hip]
        weights[:, hip] *= 1.0 - free
    return replace(garments, weights=weights)


def _both(divided) -> tuple[SkinMesh, np.ndarray]:
    return divided.mesh, divided.regions


def _outlines() -> list:
    """(region, field positive inside it, regions it is cut from), in the order of dressing."""
    return [
        (HAIR, hair_field, (SKIN,)),
        (SKIN, lambda v: np.where((v[:, 2] > 0.08) & (np.abs(v[:, 0]) < 0.06), v[:, 1] - _brow_arc(v), -1.0), (SKIN,)),
        (BROWS, brow_field, (SKIN,)),
        (IRIS, iris_field, (EYES,)),
        (SOCKS, lambda v: _TOP_SOCK - v[:, 1], (SKIN,)),
        (TROUSERS, lambda v: np.minimum(0.12 - v[:, 1], v[:, 1] - _HEM_TROUSERS), (SKIN, SOCKS)),
        (SHOES, lambda v: _shoe_top(v) - v[:, 1], (SOCKS, SKIN)),
        (SOLES, lambda v: SOLE + 0.016 - v[:, 1], (SHOES,)),
        (SHIRT, shirt_field, (SKIN, TROUSERS)),
        (LEFT_CUFF, lambda v: v[:, 0] - _CUFF, (SHIRT,)),
        (RIGHT_CUFF, lambda v: -v[:, 0] - _CUFF, (SHIRT,)),
    ]


def _shoe_top(v: np.ndarray) -> np.ndarray:
    """The opening of a shoe is higher at the heel and over the instep than at the sides."""
    return _TOP_SHOE - 0.008 + 0.022 * np.clip((v[:, 2] + 0.012) / 0.055, -1, 1) ** 2


def shirt_field(v: np.ndarray) -> np.ndarray:
    """Trunk and upper arms; the neck is a plane that falls to the front."""
    neck = 0.536 - 0.60 * (v[:, 2] + 0.04)
    return np.minimum.reduce([v[:, 1] - _HEM_SHIRT, _SLEEVE - np.abs(v[:, 0]), neck - v[:, 1]])


def hair_field(v: np.ndarray) -> np.ndarray:
    """Short hair: above a line that runs from the nape around the ears to the forehead."""
    line = np.interp(v[:, 2], *_HAIRLINE)
    ear = np.sqrt(
        ((np.abs(v[:, 0]) - 0.086) / 0.019) ** 2 + ((v[:, 1] - 0.651) / 0.034) ** 2 + ((v[:, 2] - 0.033) / 0.024) ** 2
    )
    parting = 0.004 * np.cos(v[:, 0] / 0.05 * np.pi) * (v[:, 2] > 0.09)
    return np.minimum.reduce([v[:, 1] - line - parting, (ear - 1.0) * 0.02, v[:, 1] - 0.56])


def brow_field(v: np.ndarray) -> np.ndarray:
    """Two tapering arcs above the eyes."""
    across = np.abs(v[:, 0])
    half = 0.0034 * np.clip((0.053 - across) / 0.016, 0.0, 1.0) ** 0.7 * np.clip((across - 0.010) / 0.006, 0.0, 1.0)
    return np.where(v[:, 2] > 0.08, half - np.abs(v[:, 1] - _brow_arc(v)) - 1e-5, -1.0)


def _brow_arc(v: np.ndarray) -> np.ndarray:
    return 0.6950 + 0.0040 * np.sin((np.abs(v[:, 0]) - 0.008) / 0.046 * np.pi)


def iris_field(v: np.ndarray) -> np.ndarray:
    """A disc on the front of each eyeball."""
    away = np.sqrt((np.abs(v[:, 0]) - 0.0305) ** 2 + (v[:, 1] - 0.6685) ** 2)
    return np.where(v[:, 2] > 0.115, 0.0062 - away, -1.0)


def soften(mesh: SkinMesh) -> SkinMesh:
    """Cloth does not follow every fold: trunk and seat are evened out under the shirt and trousers."""
    v = mesh.vertices
    chest = _bump(v[:, 1], -0.05, 0.02, 0.40, 0.47) * (np.abs(v[:, 0]) < 0.21)
    seat = _bump(v[:, 1], -0.30, -0.15, -0.02, 0.05) * (np.abs(v[:, 0]) < 0.19)
    softened = smooth(v, mesh.faces, 0.5 * np.clip(chest, 0, 1), 9)
    front = (
        _ramp(v[:, 2], 0.02, 0.06) * _bump(v[:, 1], 0.14, 0.21, 0.36, 0.43) * (1 - _ramp(np.abs(v[:, 0]), 0.12, 0.18))
    )
    softened += front[:, None] * (_evened(softened, mesh, front > 0, 0.040) - softened)
    softened = smooth(softened, mesh.faces, 0.5 * np.clip(seat, 0, 1), 7)
    return replace(mesh, vertices=softened)


def _evened(v: np.ndarray, mesh: SkinMesh, chosen: np.ndarray, width: float) -> np.ndarray:
    """(V, 3) with the chosen vertices at the mean depth of the surface around them, `width` metres wide."""
    corners = v[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    middles, front = corners.mean(1), _outward(mesh)[mesh.faces].mean(1)[:, 2] > 0.1
    middles, areas = middles[front], areas[front]
    result = np.array(v)
    for vertex in np.flatnonzero(chosen):
        near = areas * np.exp(-((middles - v[vertex]) ** 2).sum(1) / (2 * width**2))
        result[vertex, 2] = near @ middles[:, 2] / near.sum() + 0.004
    return result


def friendly(mesh: SkinMesh) -> SkinMesh:
    """The corners of the mouth go up a little."""
    v = np.array(mesh.vertices)
    near = ((np.abs(v[:, 0]) - 0.027) / 0.012) ** 2 + ((v[:, 1] - 0.600) / 0.014) ** 2
    v[:, 1] += 0.0035 * np.exp(-near) * (v[:, 2] > 0.09)
    return replace(mesh, vertices=v)


def sculpt_shoes(mesh: SkinMesh) -> SkinMesh:
    """Toes become the closed front of a shoe, and the sole becomes flat and level."""
    v = np.array(mesh.vertices)
    mean = averaging(mesh.faces, len(v))
    normals = _outward(mesh)
    foot = v[:, 1] < _TOP_SHOE + 0.03
    lift = 0.0045 * _ramp(_TOP_SHOE + 0.004 - v[:, 1], 0.0, 0.004)
    for side in (1.0, -1.0):
        mine = foot & (v[:, 0] * side > 0)
        front = mine * _ramp(v[:, 2], 0.055, 0.105)
        hull = ConvexHull(v[mine & (v[:, 1] < -0.885)])
        own = np.flatnonzero(front > 0)
        for _ in range(60):
            v[own] += 0.7 * front[own, None] * ((mean @ v)[own] - v[own])
            v[own] += front[own, None] * (_onto(v[own], hull, 0.006) - v[own])
    rest = lift * (1.0 - _ramp(v[:, 2], 0.055, 0.105))
    v += normals * rest[:, None]
    v = fair(v, mesh.faces, foot * 0.6, 20)
    down = -_outward(replace(mesh, vertices=v))[:, 1]
    under = foot * _ramp(down, 0.0, 0.5) * _ramp(SOLE + 0.042 - v[:, 1], 0.0, 0.016)
    under = smooth(under[:, None], mesh.faces, 0.5 * foot, 6)[:, 0]
    v[:, 1] += np.clip(1.6 * under, 0, 1) * (SOLE - v[:, 1])
    v[:, [0, 2]] = fair(v[:, [0, 2]], mesh.faces, foot * _ramp(SOLE + 0.03 - v[:, 1], 0.0, 0.01), 12)
    v[foot, 1] = np.maximum(v[foot, 1], SOLE)
    return replace(mesh, vertices=v)


def _onto(points: np.ndarray, hull: ConvexHull, beyond: float) -> np.ndarray:
    """Points moved, away from the middle of the foot, onto the hull's surface lifted by `beyond`."""
    across, ahead = (hull.points[:, axis] for axis in (0, 2))
    middle = np.stack(
        [
            np.full(len(points), across[ahead > 0.05].mean()),
            np.full(len(points), -0.935),
            np.minimum(points[:, 2], ahead.max() - 0.045),
        ],
        axis=-1,
    )
    outward = points - middle
    length = np.linalg.norm(outward, axis=1, keepdims=True)
    outward = outward / np.maximum(length, 1e-6)
    normal = hull.equations[:, :3]
    offset = hull.equations[:, 3] - beyond * (1.0 + np.clip(normal[:, 1], 0.0, 1.0))  # room above the toes
    speed = outward @ normal.T
    room = -(middle @ normal.T + offset)
    reach = np.where(speed > 1e-6, room / np.where(speed > 1e-6, speed, 1.0), np.inf).min(1)
    return middle + outward * reach[:, None]


def _outward(mesh: SkinMesh) -> np.ndarray:
    from engines.geometry.skins import vertex_normals

    return vertex_normals(mesh.vertices, mesh.faces).astype(np.float64)


def _thickness(v: np.ndarray) -> np.ndarray:
    """(regions, V) metres each region is lifted at each vertex."""
    lifted = np.zeros((len(COLOURS), len(v)))
    for region, amount in THICKNESS.items():
        lifted[region] = amount
    inside = hair_field(v)
    lifted[HAIR] = 0.003 + 0.007 * _ramp(inside, 0.0, 0.06) + 0.007 * _ramp(v[:, 1], 0.70, 0.78)
    lifted[TROUSERS] += 0.006 * _ramp(-v[:, 1], 0.55, 0.83)  # loose at the ankles
    lifted[SHIRT] += 0.004 * _ramp(-v[:, 1], -0.12, 0.03)
    return lifted


def _colours(garments: Garments) -> np.ndarray:
    """(V, 3) uint8: the regions' colours, lips and cheeks a little redder."""
    table = np.array([[int(COLOURS[r][i : i + 2], 16) for i in (1, 3, 5)] for r in range(len(COLOURS))], float)
    colours, v = table[garments.region], garments.vertices
    skin = garments.region == SKIN
    lips = np.sqrt((v[:, 0] / 0.026) ** 2 + ((v[:, 1] - 0.6005) / 0.0105) ** 2)
    red = skin * (v[:, 2] > 0.118) * (1.0 - _ramp(lips, 0.75, 1.05))
    colours += red[:, None] * (np.array([186, 118, 104]) - colours) * 0.75
    return np.round(colours.clip(0, 255)).astype(np.uint8)


def _ramp(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 below `low`, 1 above `high`, smooth between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _bump(x: np.ndarray, low: float, full: float, less: float, high: float) -> np.ndarray:
    """1 between `full` and `less`, 0 outside `low` to `high`."""
    return _ramp(x, low, full) * (1.0 - _ramp(x, less, high))
