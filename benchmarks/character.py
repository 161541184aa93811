"""Posing a character by skinning and as rigid as possible, for meshes of several sizes.

Run: python benchmarks/character.py
"""

from __future__ import annotations

import numpy as np
from clock import best

from engines.character.arap import AsRigidAsPossible
from engines.character.mesh import Surface, cleaned
from engines.character.rig import FREE
from engines.character.surface import halved
from engines.character.template import Template
from engines.geometry.skins import blended
from viewers import bodies

LONGEST = (None, 0.02, 0.014)
"""Edges that the body's mesh is cut down to, metres; None leaves it."""
REPEATS = 5


def row(body: Template, longest: float | None) -> None:
    first = cleaned(Surface(body.vertices, body.faces))
    surface = first if longest is None else halved(first, longest)
    count = len(surface.vertices)
    rng = np.random.default_rng(0)
    skin = rng.integers(0, 22, (count, 4)), rng.dirichlet(np.ones(4), count)
    matrices = np.tile(np.eye(3, 4), (22, 1, 1))
    skinning = best(lambda: np.einsum("nab,nb->na", blended(matrices, *skin)[:, :, :3], surface.vertices), REPEATS)
    bent = surface.vertices + 0.05 * np.sin(8 * surface.vertices[:, ::-1])
    hold = np.full(count, FREE)
    solver = AsRigidAsPossible(surface.vertices, surface.faces, hold)
    factoring = best(lambda: AsRigidAsPossible(surface.vertices, surface.faces, hold), REPEATS)
    posing = best(lambda: solver.deformed(bent), REPEATS)
    print(f"{count:>10,}{skinning:>16.1f}{factoring:>14.0f}{posing:>20.0f}{posing / skinning:>9.0f}")


def main() -> None:
    print(f"{'vertices':>10}{'skinning, ms':>16}{'factor, ms':>14}{'a rigid pose, ms':>20}{'ratio':>9}")
    for longest in LONGEST:
        row(bodies.get("anny"), longest)


if __name__ == "__main__":
    main()
