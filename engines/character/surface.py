"""The clothed surface: the fitted body moved until its outline is the mask's, with hair, shoes and loose clothes.

The thesis has a network reconstruct this surface (PIFuHD), whose weights cannot be handed on. Here each point of the
body's outline walks across the picture to where the mask ends, and the rest of the skin follows by two smooth fields
over it: sideways and up as its neighbours on the outline go, and in depth, which no outline shows, by as much as the
outlines on either side of it go outward. A coat that stands off at the sides so stands off in front and behind, while
an arm that only lies elsewhere is carried there.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Integer
from scipy import sparse
from scipy.ndimage import map_coordinates
from scipy.sparse.linalg import splu

from engines.character.fitting import Fit
from engines.character.mesh import Surface, cleaned
from engines.character.outline import Rim, reduced, rim
from engines.character.sighting import Sighting
from engines.character.template import strongest_joints
from engines.character.view import View

TALL = 700
"""Pixels a person's outline is looked at with."""
ROUNDS = 3
"""Walks to the mask's outline, each from where the one before ended."""
OUTWARD, INWARD = 0.22, 0.03
"""Metres a point of the outline may walk in a round; what clothes and hair do, and what a body can give way."""
THINNER = 0.02
"""Metres a body's front and back may go inward."""
STEP = 0.5
"""Pixels of a walk's step."""
SMOOTH, FLAT, STILL = 2.0, 0.3, 1e-6
"""Weights beside that of one pixel of the outline: of bending of the fields, of their slope, of moving at all."""
STIFF = {"wrist": 40.0, "ankle": 5.0, "foot": 20.0, "head": 5.0}
"""How much more these resist than the rest: hands and shoes go where they are as a whole, since a mask shows no fingers
and sees feet from above; the face is the template's."""
SOFTENED = 12
"""Passes of smoothing that take the template's own hems and collar away."""
BARE = ("head", "wrist", "ankle", "foot")
"""Parts that are not softened."""
LONGEST = 0.017
"""Metres; longer edges are halved at the end."""


def clothed(fit: Fit, sighting: Sighting) -> Surface:
    """The person's surface in the picture's pose, dressed as their outline shows.

    Args:
        fit: the body.
        sighting: whose mask is to be met.

    Returns:
        A closed surface of some 25,000 vertices as `fit.view` sees it, with `parts`. What lies before or behind the
        body's middle without showing in the outline (a bag on the back, folds) is not in it; a skirt is two halves
        that touch between the legs.
    """
    body = _softened(_welded(fit), fit)
    mask, view = reduced(sighting.mask.astype(np.float64), fit.view, TALL)
    bending = _bending(body, fit)
    yielding = _yielding(body, fit) * body.normals[:, 2]
    moved, outward = np.zeros_like(body.vertices), np.zeros(len(body.vertices))
    for _ in range(ROUNDS):
        edge = rim(body.vertices + moved, body.faces, view, mask.shape[::-1])
        steps, trusted = _walks(edge, mask, view)
        sideways, more = _spread(body, edge, steps, trusted, bending)
        moved[:, :2] += sideways
        outward = np.maximum(outward + more, -THINNER)
        moved[:, 2] = outward * yielding
    return halved(body.replaced(vertices=body.vertices + moved), LONGEST)


def halved(surface: Surface, longest: float) -> Surface:
    """The surface with every edge longer than `longest` metres cut in two, until there is none; holds no new shape."""
    while True:
        vertices, faces = surface.vertices, surface.faces
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)  # (F, 3, 2)
        every, index = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
        long = np.linalg.norm(vertices[every[:, 0]] - vertices[every[:, 1]], axis=1) > longest
        if not long.any():
            return surface
        number = np.where(long, len(vertices) + np.cumsum(long) - 1, -1)
        middle = number[index.reshape(-1, 3)]
        parents = every[long]
        parts = None if surface.parts is None else np.concatenate([surface.parts, surface.parts[parents[:, 0]]])
        points = np.concatenate([vertices, vertices[parents].mean(1)])
        surface = Surface(points, _cut(points, faces, middle), parts=parts)


def _cut(points: np.ndarray, faces: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """(F', 3) faces, cut where `middle` (F, 3) names a vertex on the edge from each corner to the next, -1 for none."""
    count = (middle >= 0).sum(1)
    # turn every face so that its cut edges come first (one cut: edge 0; two: edges 0 and 1)
    first = np.where(count == 2, ((middle < 0).argmax(1) + 1) % 3, (middle >= 0).argmax(1))
    turn = (first[:, None] + np.arange(3)) % 3
    (a, b, c), (m, n, o) = np.take_along_axis(faces, turn, 1).T, np.take_along_axis(middle, turn, 1).T
    whole, one, two, three = (count == cuts for cuts in range(4))
    slant = np.linalg.norm(points[a] - points[n], axis=1) <= np.linalg.norm(points[c] - points[m], axis=1)
    parts = [
        (whole, (a, b, c)),
        *((one, corners) for corners in ((a, m, c), (m, b, c))),
        (two, (m, b, n)),
        *((two & slant, corners) for corners in ((a, m, n), (a, n, c))),
        *((two & ~slant, corners) for corners in ((a, m, c), (m, n, c))),
        *((three, corners) for corners in ((a, m, o), (m, b, n), (n, c, o), (m, n, o))),
    ]
    return np.concatenate([np.stack(corners, axis=1)[chosen] for chosen, corners in parts])


def _welded(fit: Fit) -> Surface:
    """The posed template, its vertices at one place made one."""
    return cleaned(Surface(fit.vertices, fit.template.faces.astype(np.int64), parts=strongest_joints(fit.template)))


def _softened(body: Surface, fit: Fit) -> Surface:
    """Without the small steps of the template's clothes; smoothed without shrinking (Taubin)."""
    average = _averaging(body)
    loose = ~_of(body, fit, BARE)[:, None]
    vertices = body.vertices
    for share in (0.5, -0.53) * SOFTENED:
        vertices = vertices + loose * share * (average @ vertices - vertices)
    return body.replaced(vertices=vertices)


def _yielding(body: Surface, fit: Fit) -> np.ndarray:
    """(N,) how far a vertex goes along in depth: hands and shoes not at all, and what is next to them a little."""
    average, share = _averaging(body), (~_of(body, fit, ("wrist", "foot"))).astype(np.float64)
    for _ in range(SOFTENED):
        share = np.minimum(share, average @ share)
    return share


def _of(body: Surface, fit: Fit, names: tuple[str, ...]) -> np.ndarray:
    """(N,) whether a vertex belongs to a joint whose name ends in one of `names`."""
    assert body.parts is not None
    return np.array([joint.endswith(names) for joint in fit.template.skeleton.joints])[body.parts]


def _links(body: Surface) -> sparse.csr_matrix:
    """(N, N) ones between neighbours."""
    ends = body.faces[:, [0, 1, 2, 1, 2, 0]].T.ravel(), body.faces[:, [1, 2, 0, 0, 1, 2]].T.ravel()
    links = sparse.csr_matrix((np.ones(len(ends[0])), ends), shape=(len(body.vertices),) * 2)
    links.data[:] = 1.0
    return links


def _averaging(body: Surface) -> sparse.csr_matrix:
    """(N, N) the mean of each vertex's neighbours."""
    links = _links(body)
    return sparse.csr_matrix(sparse.diags(1 / np.asarray(links.sum(1)).ravel()) @ links)


def _bending(body: Surface, fit: Fit) -> sparse.csc_matrix:
    """(N, N) the quadratic form that is small for smooth fields over the body."""
    stiff = np.ones(len(body.vertices))
    for name, factor in STIFF.items():
        stiff[_of(body, fit, (name,))] = factor
    curved = sparse.identity(len(stiff)) - _averaging(body)
    tied = sparse.diags(np.sqrt(stiff)) @ _links(body) @ sparse.diags(np.sqrt(stiff))
    sloped = sparse.diags(np.asarray(tied.sum(1)).ravel()) - tied
    bent = curved.T @ sparse.diags(stiff) @ curved
    return sparse.csc_matrix(SMOOTH * bent + FLAT * sloped + STILL * sparse.identity(len(stiff)))


def _walks(edge: Rim, mask: np.ndarray, view: View) -> tuple[np.ndarray, np.ndarray]:
    """How far each point of the body's outline goes along its normal until the mask ends.

    Outward it stops half-way to where the body itself begins again: between legs under a skirt, between arm and trunk.

    Returns:
        (K,) metres, outward positive, and (K,) which of them are to be believed.
    """
    outward, inward = int(OUTWARD * view.scale / STEP), int(INWARD * view.scale / STEP)
    far = np.arange(-inward, outward + 1) * STEP
    places = edge.contour.points[:, None] + far[:, None] * edge.contour.normals[:, None]  # (K, S, 2), pixels
    rows_columns = np.moveaxis(places[..., ::-1] - 0.5, -1, 0)
    there = map_coordinates(mask, rows_columns, order=1, mode="nearest") >= 0.5
    ours = map_coordinates(edge.mask, rows_columns, order=1, mode="nearest") >= 0.5
    leaves = _first(~there[:, inward:])
    meets = _first(ours[:, inward + int(1.5 / STEP) :]) + int(1.5 / STEP)
    enters = _first(there[:, inward::-1])
    out = np.minimum(leaves, meets / 2)
    steps = np.where(there[:, inward], out, -enters.astype(float))
    believed = np.where(there[:, inward], (leaves <= outward) | (meets <= outward), enters <= inward)
    return steps * STEP / view.scale, believed


def _first(hits: np.ndarray) -> np.ndarray:
    """(K,) the first column of (K, S) that is true; one past any where none is."""
    return np.where(hits.any(1), hits.argmax(1), hits.shape[1] + 1)


def _spread(
    body: Surface, edge: Rim, steps: Float[np.ndarray, " K"], trusted: np.ndarray, bending: sparse.csc_matrix
) -> tuple[Float[np.ndarray, "N 2"], Float[np.ndarray, " N"]]:
    """The smooth fields that move the outline by `steps`: sideways and up (N, 2), and outward (N,), metres."""
    corners: Integer[np.ndarray, "K 3"] = edge.corners[trusted]
    rows = np.repeat(np.arange(len(corners)), 3)
    holds = sparse.csr_matrix(
        (edge.weights[trusted].ravel(), (rows, corners.ravel())), shape=(len(corners), len(body.vertices))
    )
    wanted = steps[trusted, None] * edge.contour.normals[trusted] * (1, -1)  # pixels run down
    target = np.column_stack([wanted, steps[trusted]])
    solved = splu(sparse.csc_matrix(bending + holds.T @ holds)).solve(holds.T @ target)
    return solved[:, :2], solved[:, 2]
