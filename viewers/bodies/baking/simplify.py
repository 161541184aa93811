"""Fewer triangles on the same vertices: edges collapsed onto one of their ends, the least visible first.

Quadric error metrics after Garland and Heckbert (1997), restricted to half-edge collapses so that a coarse level is
only another list of faces over the vertices there already are.
"""

from __future__ import annotations

import heapq

import numpy as np

from viewers.bodies.baking.weights import SkinMesh

_SEAM = 30.0
"""How much more a shift across a seam between colours counts than one of the surface."""
_BEND = 2e-3
"""Square metres of error for hanging on wholly different joints."""


class _Simplifier:
    """The mesh while it shrinks."""

    def __init__(self, mesh: SkinMesh, regions: np.ndarray, importance: np.ndarray) -> None:
        self.points, self.weights = mesh.vertices, mesh.weights
        self.faces = [tuple(face) for face in mesh.faces.tolist()]
        self.regions = regions.tolist()
        self.around: list[set[int]] = [set() for _ in self.points]
        for number, face in enumerate(self.faces):
            for vertex in face:
                self.around[vertex].add(number)
        self.seams = self._seams()
        self.quadrics = self._quadrics(importance)
        self.alive, self.changes = len(self.faces), [0] * len(self.points)
        self.heap: list[tuple[float, int, int, int]] = []
        for face in self.faces:
            for a, b in zip(face, (face[1], face[2], face[0]), strict=True):
                self._propose(a, b)

    def run(self, target: int) -> list[int]:
        """Collapse until `target` faces are left; returns the numbers of the faces still alive."""
        while self.alive > target and self.heap:
            _, a, b, change = heapq.heappop(self.heap)
            if change == self.changes[a] and self.around[a] and self._allowed(a, b):
                self._collapse(a, b)
        return [n for n in range(len(self.faces)) if n in self.around[self.faces[n][0]]]

    def _seams(self) -> list[set[int]]:
        """For each vertex, the neighbours it shares an edge between two regions with."""
        sides: dict[tuple[int, int], int] = {}
        seams: list[set[int]] = [set() for _ in self.points]
        for (x, y, z), region in zip(self.faces, self.regions, strict=True):
            for a, b in ((x, y), (y, z), (z, x)):
                sides[a, b] = region
        for (a, b), region in sides.items():
            if sides.get((b, a), region) != region:
                seams[a].add(b)
                seams[b].add(a)
        return seams

    def _quadrics(self, importance: np.ndarray) -> np.ndarray:
        quadrics = np.zeros((len(self.points), 4, 4))
        for face in self.faces:
            corners = self.points[list(face)]
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            area = float(np.linalg.norm(normal)) / 2
            if area < 1e-14:
                continue
            normal = normal / (2 * area)
            for start, end in zip(range(3), (1, 2, 0), strict=True):
                self._add_plane(quadrics, face[start], normal, corners[0], area * float(importance[face[start]]))
                if face[end] in self.seams[face[start]]:
                    edge = corners[end] - corners[start]
                    fence = np.cross(edge, normal)
                    length = float(np.linalg.norm(fence))
                    for vertex in (face[start], face[end]):
                        self._add_plane(quadrics, vertex, fence / length, corners[start], _SEAM * length**2)
        return quadrics

    @staticmethod
    def _add_plane(quadrics: np.ndarray, vertex: int, normal: np.ndarray, point: np.ndarray, weight: float) -> None:
        plane = np.append(normal, -normal @ point)
        quadrics[vertex] += weight * np.outer(plane, plane)

    def _propose(self, a: int, b: int) -> None:
        """Put the collapse of a onto b in the queue."""
        place = np.append(self.points[b], 1.0)
        total = self.quadrics[a] + self.quadrics[b]
        length = float(((self.points[a] - self.points[b]) ** 2).sum())
        bend = _BEND * float(((self.weights[a] - self.weights[b]) ** 2).sum()) * length
        cost = float(place @ total @ place) + bend + 1e-9 * length
        heapq.heappush(self.heap, (cost, a, b, self.changes[a]))

    def _near(self, vertex: int) -> set[int]:
        return {v for face in self.around[vertex] for v in self.faces[face]} - {vertex}

    def _allowed(self, a: int, b: int) -> bool:
        """A collapse must keep the surface closed, its seams in place, and turn no face over."""
        if self.seams[a] and (b not in self.seams[a] or len(self.seams[a]) != 2):
            return False
        near = self._near(a)
        if b not in near or len(near & self._near(b)) != 2:
            return False
        for number in self.around[a] - self.around[b]:
            old = self.points[list(self.faces[number])]
            new = self.points[[b if v == a else v for v in self.faces[number]]]
            before, after = (np.cross(p[1] - p[0], p[2] - p[0]) for p in (old, new))
            if before @ after < 0.25 * np.linalg.norm(before) * np.linalg.norm(after):
                return False
        return True

    def _collapse(self, a: int, b: int) -> None:
        touched = self._near(a)
        for number in list(self.around[a]):
            if b in self.faces[number]:
                for vertex in self.faces[number]:
                    self.around[vertex].discard(number)
                self.alive -= 1
            else:
                self.faces[number] = tuple(b if v == a else v for v in self.faces[number])
                self.around[b].add(number)
        for other in self.seams[a]:
            self.seams[other].discard(a)
            if other != b:
                self.seams[other].add(b)
                self.seams[b].add(other)
        self.quadrics[b] += self.quadrics[a]
        self.around[a], self.seams[a] = set(), set()
        for vertex in touched | {b}:
            self.changes[vertex] += 1
        for vertex in touched | {b}:
            for other in self._near(vertex):
                self._propose(vertex, other)


def simplify(
    mesh: SkinMesh, regions: np.ndarray, importance: np.ndarray, targets: tuple[int, ...]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Coarser face lists of a closed mesh.

    Args:
        mesh: the mesh.
        regions: (F,) region of each face; seams between regions stay where they are.
        importance: (V,) how much errors at a vertex count.
        targets: numbers of faces, falling.

    Returns:
        For each target: faces (F', 3) over the same vertices, and their regions (F',).
    """
    work = _Simplifier(mesh, regions, importance)
    levels = []
    for target in targets:
        kept = work.run(target)
        levels.append((np.array([work.faces[n] for n in kept]), regions[kept]))
    return levels
