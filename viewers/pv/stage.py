"""A scene standing in a PyVista plotter: meshes are made once, and moved by the skin for every moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from viewers.bodies.body import Body
from viewers.marks import CONTACT_COLOUR, CONTACT_OPACITY, TRAIL_COLOUR, TRAIL_OPACITY, contact_prints, trail
from viewers.played import Played, Worn, at_home, ghost_frames, play, visible_ghosts, worn
from viewers.pv.plotter import Plotter, pyvista_module
from viewers.scene import Actor, Scene, hex_to_rgb, sample

REACH = 7.0
"""Metres from the middle of what happens at which the floor has faded away, at least."""
SHADOW, FLOOR, GRID, MARK = 0.0015, 0.0, 0.001, 0.003
"""Heights of flat things above the floor, metres: each lies on the one before."""
CORNERS = 20
"""Of an ellipse on the floor."""
DARKER = 0.62
"""Of a shadow, as a share of the floor's light."""


class Stage:
    """Everything of a scene in a plotter. `show(t)` moves it; the camera is the caller's."""

    def __init__(self, plotter: Plotter, scene: Scene) -> None:
        """Put a scene into an empty plotter."""
        scene = at_home(scene)
        self.plotter, self.scene = plotter, scene
        colours = scene.colours
        plotter.set_background(colours.edge, top=colours.centre)
        self._light()
        bodies = [(actor, one) for actor in scene.actors for one in worn(actor)]
        self._see_through = any(one.alpha < 1 or actor.ghosts for actor, one in bodies)
        if self._see_through:
            plotter.enable_depth_peeling(8)
        else:
            plotter.disable_depth_peeling()
        self._fine: bool | None = None
        if scene.floor:
            self._floor()
        self.figures = []
        for actor in scene.actors:
            for number, one in enumerate(worn(actor)):
                self.figures.append(Figure(plotter, actor, one, scene, shadow=scene.floor and number == 0))
        self.marks = [mark for actor in scene.actors for mark in _marks(plotter, actor)]
        self.labels = [Label(plotter, actor, scene) for actor in scene.actors if actor.label]

    def show(self, t: float, fine: bool = True) -> None:
        """Everything as it is at `t` seconds.

        Args:
            t: seconds.
            fine: with smooth edges, which without a graphics card take longer than all the rest.
        """
        if fine != self._fine:
            self._fine = fine
            self.plotter.disable_anti_aliasing()
            if fine:  # peeling and multisampling exclude each other
                self.plotter.enable_anti_aliasing("ssaa" if self._see_through else "msaa")
        for part in (*self.figures, *self.marks, *self.labels):
            part.show(t)

    def _light(self) -> None:
        """The scene's key light, and a weak one from the eye in place of the sky."""
        pv, light = pyvista_module(), self.scene.light
        key = pv.Light(position=tuple(10 * light.direction), focal_point=(0, 0, 0), light_type="scene light")
        key.intensity = 0.72 * light.key
        sky = pv.Light(light_type="headlight")
        sky.intensity = 0.34 * light.sky
        self.plotter.add_light(key)
        self.plotter.add_light(sky)

    def _floor(self) -> None:
        """A disc and its lines, one a metre, that fade into the backdrop."""
        pv, colours = pyvista_module(), self.scene.colours
        places = np.concatenate([actor.motion.positions[:, 0] + actor.offset for actor in self.scene.actors])
        low, high = places[:, [0, 2]].min(0), places[:, [0, 2]].max(0)
        middle, reach = (low + high) / 2, REACH + float((high - low).max()) / 2
        disc = _disc(middle, reach)
        mesh = pv.PolyData.from_regular_faces(disc.points, disc.faces)
        mesh.point_data["colour"] = _rgba(colours.floor, 0.9 * np.clip(1 - disc.away**2, 0, 1) ** 2)
        self.plotter.add_mesh(mesh, scalars="colour", rgb=True, lighting=False, pickable=False)
        lines = _grid(middle, reach)
        mesh = pv.line_segments_from_points(lines.reshape(-1, 3))
        away = np.linalg.norm(lines.reshape(-1, 3)[:, [0, 2]] - middle, axis=-1) / reach
        mesh.point_data["colour"] = _rgba(colours.grid, 0.55 * np.clip(1 - away**2, 0, 1) ** 2)
        self.plotter.add_mesh(mesh, scalars="colour", rgb=True, lighting=False, line_width=1.2, pickable=False)


class Figure:
    """One body of an actor, its shadow and its ghosts."""

    def __init__(self, plotter: Plotter, actor: Actor, one: Worn, scene: Scene, shadow: bool) -> None:
        self._actor, self._one, self._light = actor, one, scene.light.direction
        colour = hex_to_rgb(actor.colour) if actor.colour else None
        paint = one.body.painted(colour)
        self.mesh = _body_mesh(one.body, one.body.faces, paint)
        _add_body(plotter, self.mesh, one.alpha, _texture(one.body, colour))
        self.shadow: Any = None
        if shadow:
            coarse = one.body.coarse[-1] if one.body.coarse else one.body.faces
            dark = tuple(DARKER * np.array(hex_to_rgb(scene.colours.floor)))
            self.shadow = pyvista_module().PolyData.from_regular_faces(one.body.vertices.copy(), coarse)
            plotter.add_mesh(self.shadow, color=dark, lighting=False, pickable=False)
        self._ghost_times = np.zeros(0)
        if actor.ghosts:
            self._add_ghosts(plotter, paint, hex_to_rgb(scene.colours.centre))

    def show(self, t: float) -> None:
        """The pose at `t` seconds."""
        now = play(self._one.body, self._one.motion, np.array([t]), self._actor.offset)
        self.mesh.points[:], self.mesh.point_data["Normals"][:] = self._one.body.deformed(now.matrices[0])
        self.mesh.Modified()
        if self.shadow is not None:
            self.shadow.points[:] = _fallen(np.asarray(self.mesh.points), self._light)
            self.shadow.Modified()
        if len(self._ghost_times):
            seen = {ghost.pose for ghost in visible_ghosts(self._ghost_times, t, self._actor.ghost_count)}
            for number, ghost in enumerate(self._ghosts):
                ghost.SetVisibility(number in seen)

    def _add_ghosts(self, plotter: Plotter, paint: np.ndarray, faded: tuple[float, float, float]) -> None:
        body, motion = self._one.body, self._one.motion
        self._ghost_times = ghost_frames(motion, self._actor.ghosts) / motion.fps
        still: Played = play(body, motion, self._ghost_times, self._actor.offset)
        faces = body.coarse[0] if body.coarse else body.faces
        paint = (0.5 * paint + 0.5 * 255 * np.array(faded)).astype(np.uint8)
        self._ghosts = []
        for matrices in still.matrices:
            mesh = _body_mesh(body, faces, paint)
            mesh.points[:], mesh.point_data["Normals"][:] = body.deformed(matrices)
            self._ghosts.append(_add_body(plotter, mesh, 0.35))


class Mark:
    """Ellipses on the floor, each more or less seen by the time."""

    def __init__(
        self, plotter: Plotter, instances: np.ndarray, colour: str, opacity: tuple[float, float, float]
    ) -> None:
        """Put ellipses (M, 8), as `viewers.marks` makes them, into a plotter."""
        pv = pyvista_module()
        self._span, self._opacity = instances[:, 6:8], opacity
        self.mesh: Any
        points, faces = _ellipses(instances)
        self.mesh = pv.PolyData.from_regular_faces(points, faces)
        self.mesh.cell_data["colour"] = _rgba(colour, np.zeros(len(faces)))
        self._triangles = len(faces) // len(instances)
        plotter.add_mesh(self.mesh, scalars="colour", rgb=True, lighting=False, pickable=False)

    def show(self, t: float) -> None:
        """How strongly each is seen at `t` seconds."""
        before, during, after = self._opacity
        start, end = self._span.T
        strength = np.where(t < start, before, np.where(t <= end, during, after))
        self.mesh.cell_data["colour"][:, 3] = np.repeat(np.round(255 * strength), self._triangles)
        self.mesh.Modified()


class Label:
    """Text under an actor, always upright and of one size."""

    def __init__(self, plotter: Plotter, actor: Actor, scene: Scene) -> None:
        from vtkmodules.vtkRenderingCore import vtkBillboardTextActor3D  # PyVista's own labels take ASCII only

        self._actor = actor
        self._text = vtkBillboardTextActor3D()
        self._text.SetInput(actor.label or "")
        style = self._text.GetTextProperty()
        style.SetColor(*hex_to_rgb(scene.colours.ink))
        style.SetFontSize(max(10, plotter.window_size[1] // 36))
        self._below = plotter.window_size[1] // 22
        style.SetJustificationToCentered()
        style.SetVerticalJustificationToTop()
        plotter.add_actor(self._text, reset_camera=False, pickable=False)

    def show(self, t: float) -> None:
        """Where the actor is at `t` seconds."""
        _, path = sample(self._actor.motion, np.array([t]))
        place = path[0] + self._actor.motion.skeleton.offsets[0] + self._actor.offset
        self._text.SetPosition(place[0], 0.0, place[2])
        self._text.SetDisplayOffset(0, -self._below)


def _marks(plotter: Plotter, actor: Actor) -> list[Mark]:
    made = []
    if actor.trail:
        made.append(Mark(plotter, trail(actor.motion, actor.offset), actor.colour or TRAIL_COLOUR, TRAIL_OPACITY))
    prints = contact_prints(actor.motion, actor.offset) if actor.contacts else np.zeros((0, 8))
    if len(prints):
        made.append(Mark(plotter, prints, CONTACT_COLOUR, CONTACT_OPACITY))
    return made


def _body_mesh(body: Body, faces: np.ndarray, paint: np.ndarray) -> Any:
    """A mesh of a body at rest, in its colours, with normals of its own."""
    mesh = pyvista_module().PolyData.from_regular_faces(body.vertices.copy(), faces)
    mesh.point_data["colour"] = paint
    mesh.point_data["Normals"] = body.normals.copy()
    mesh.point_data.active_normals_name = "Normals"
    if body.uv is not None:
        mesh.active_texture_coordinates = body.uv * [1, -1] + [0, 1]  # VTK counts v from below
    return mesh


def _texture(body: Body, colour: tuple[float, float, float] | None) -> Any:
    """The body's texture, or None; one colour laid over some of it is only in the colours of the vertices."""
    if body.texture is None or (colour is not None and body.tint.any()):
        return None
    made = pyvista_module().Texture(body.texture)
    made.mipmap = made.interpolate = True
    return made


def _add_body(plotter: Plotter, mesh: Any, alpha: float, texture: Any = None) -> Any:
    """A body in its texture, or where there is none in the colours of its vertices."""
    painted = {"texture": texture} if texture is not None else {"scalars": "colour", "rgb": True}
    return plotter.add_mesh(
        mesh, **painted, smooth_shading=True, opacity=alpha, ambient=0.22, diffuse=0.9, specular=0.06,
        specular_power=20, culling="back" if alpha < 1 else None,
    )  # fmt: skip


def _fallen(points: np.ndarray, light: np.ndarray) -> np.ndarray:
    """(V, 3) points laid on the floor along the light."""
    height = np.maximum(points[:, 1:2], 0.0)
    fallen = points - height * (light / light[1])
    fallen[:, 1] = SHADOW
    return fallen


@dataclass
class _Disc:
    points: np.ndarray
    faces: np.ndarray
    away: np.ndarray
    """(P,) distance from the middle, 1 at the rim."""


def _disc(middle: np.ndarray, reach: float, rings: int = 24, spokes: int = 64) -> _Disc:
    """A fine disc on the floor."""
    away = np.repeat(np.arange(1, rings + 1) / rings, spokes)
    angle = np.tile(np.arange(spokes) * 2 * np.pi / spokes, rings)
    flat = middle + (reach * away)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    points = np.zeros((len(flat) + 1, 3))
    points[:, 1] = FLOOR
    points[0, [0, 2]], points[1:, [0, 2]] = middle, flat
    here = np.arange(spokes)
    after = (here + 1) % spokes
    faces = [np.stack([0 * here, 1 + after, 1 + here], axis=-1)]
    for ring in range(rings - 1):
        a, b = 1 + ring * spokes + here, 1 + ring * spokes + after
        faces += [np.stack([a, b, a + spokes], axis=-1), np.stack([b, b + spokes, a + spokes], axis=-1)]
    return _Disc(points, np.concatenate(faces), np.concatenate([[0.0], away]))


def _grid(middle: np.ndarray, reach: float) -> np.ndarray:
    """(S, 2, 3) pieces of the lines on the floor, one a metre."""
    count = int(np.floor(reach))
    steps = np.arange(-count, count + 1)
    pieces = []
    for axis in (0, 1):
        for beside in steps:
            ends = np.zeros((2 * count, 2, 3))
            ends[:, :, 1] = GRID
            ends[:, :, 0 if axis == 0 else 2] = beside
            ends[:, 0, 2 if axis == 0 else 0], ends[:, 1, 2 if axis == 0 else 0] = steps[:-1], steps[1:]
            pieces.append(ends)
    made = np.concatenate(pieces)
    made[..., [0, 2]] += np.round(middle)
    return made


def _ellipses(instances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (M * (CORNERS + 1), 3) and faces (M * CORNERS, 3) of ellipses (M, 8)."""
    angle = np.arange(CORNERS) * 2 * np.pi / CORNERS
    along, radii = instances[:, 2:4], instances[:, 4:6]
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    rim = (
        radii[:, 0, None, None] * np.cos(angle)[None, :, None] * along[:, None]
        + radii[:, 1, None, None] * np.sin(angle)[None, :, None] * across[:, None]
    )
    flat = np.concatenate([np.zeros((len(rim), 1, 2)), rim], axis=1) + instances[:, None, :2]
    points = np.full((*flat.shape[:2], 3), MARK)
    points[..., [0, 2]] = flat
    here = np.arange(CORNERS)
    one = np.stack([0 * here, 1 + (here + 1) % CORNERS, 1 + here], axis=-1)
    faces = one + (CORNERS + 1) * np.arange(len(instances))[:, None, None]
    return points.reshape(-1, 3), faces.reshape(-1, 3)


def _rgba(colour: str, alpha: np.ndarray) -> np.ndarray:
    """(N, 4) bytes of one colour, more or less opaque."""
    made = np.zeros((len(alpha), 4), np.uint8)
    made[:, :3] = np.round(255 * np.array(hex_to_rgb(colour)))
    made[:, 3] = np.round(255 * alpha)
    return made
