"""A rigged .glb: somebody's own character with its own skeleton, weights and textures."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Integer
from PIL import Image

from engines.character.mesh import Surface
from engines.character.meshes import MAX_BYTES, check_faces, pixels
from engines.character.pieces import Piece, joined, metres, prepared
from engines.errors import FormatError, MotionloomError
from engines.formats.files import read_bytes
from engines.formats.glb_nodes import joint_nodes, node_names, node_parents
from engines.formats.gltf import Gltf
from engines.geometry import rotations
from engines.geometry.retarget import from_points
from engines.geometry.skins import INFLUENCES
from engines.skeletons import roles
from engines.skeletons.skeleton import Skeleton

_TRIANGLES = 4
_ROOTS = ("pelvis", "neck", "left_hip", "right_hip")
"""Roles that all hang from the root of a character's skeleton."""


@dataclass(frozen=True, eq=False)
class Rigged:
    """A skin as it stands in its file, metres, Y up."""

    surface: Surface
    """In the rest pose of `skeleton`."""
    skin_indices: Integer[np.ndarray, "N 4"]
    """(N, 4) joints each vertex hangs on."""
    skin_weights: Float[np.ndarray, "N 4"]
    """(N, 4) how much, summing to one, the largest first."""
    skeleton: Skeleton
    """The file's own, from the pelvis down; its joints are told by their names (`skeletons.roles`)."""
    remarks: tuple[str, ...] = ()
    """What was guessed or left out, in sentences for the person whose file it is."""


def read_rigged(source: str | Path | bytes, name: str = "") -> Rigged:
    """Read the skin, the skeleton and the textures of a .glb.

    The rest pose is that of the nodes as they stand in the file; what is no skin but hangs on a joint goes with it.
    Animations are passed over: `engines.read` has them.

    Args:
        source: the file, or its bytes.
        name: of the file, if there are only its bytes.

    Raises:
        FormatError: no .glb, no skin in it, joints that cannot be told by their names, or damaged.
        MeshError: no faces, too many, or places that are no numbers.
    """
    path = Path(name or "character.glb") if isinstance(source, bytes) else Path(source)
    data = source if isinstance(source, bytes) else read_bytes(path, MAX_BYTES)
    check_faces(path, ".glb", data)
    gltf = Gltf(path, data)
    if not gltf.items("skins"):
        raise FormatError(path, "has no skin: its mesh hangs on no joints. Read it as a mesh, and it gets a rig.")
    try:
        with np.errstate(all="ignore"):  # what is no number is found and refused by Surface
            return _rigged(gltf, _Bones(gltf))
    except MotionloomError:
        raise
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
        raise FormatError(path, f"is damaged: {str(error)[:300]}") from error


def is_rigged(data: bytes) -> bool:
    """Are these the bytes of a .glb with a skin?"""
    try:
        return bool(Gltf(Path("character.glb"), data).items("skins"))
    except FormatError:
        return False


def _rigged(gltf: Gltf, bones: _Bones) -> Rigged:
    pieces, left_out = [], 0
    for number, node in enumerate(gltf.items("nodes")):
        if "mesh" in node:
            made = list(_pieces_of(gltf, bones, number, node))
            left_out += not made
            pieces += made
    pieces = prepared(pieces)
    surface, skeleton = joined(pieces), bones.skeleton
    factor, words = metres(float(np.ptp(surface.vertices[:, 1])))
    pelvis = bones.places[0]
    surface = surface.replaced(vertices=(surface.vertices - pelvis) * factor)
    indices = np.concatenate([piece.joints for piece in pieces if piece.joints is not None])
    weights = np.concatenate([piece.weights for piece in pieces if piece.weights is not None])
    remarks = [words] if words else []
    if left_out:
        remarks.append(f"{left_out} of its meshes hang on no joint of the body and are left out.")
    return Rigged(surface, indices, weights, skeleton.replaced(offsets=skeleton.offsets * factor), tuple(remarks))


class _Bones:
    """The joints of a file's largest skin from the root of the body down, and where all nodes are at rest."""

    def __init__(self, gltf: Gltf) -> None:
        self.parents = node_parents(gltf)
        self.world = _world(gltf, self.parents)
        nodes = joint_nodes(gltf, [], self.parents)[1]
        names = node_names(gltf, nodes)
        known = roles.recognise(names)
        root = self._common([nodes[names.index(known[role])] for role in _ROOTS if role in known] or nodes[:1])
        kept = [node for node in nodes if root in self.line(node)]
        self.index = {node: number for number, node in enumerate(kept)}
        self.places = np.array([self.world[node][:3, 3] for node in kept])
        above = tuple(self.index.get(self.parents[node], -1) if number else -1 for number, node in enumerate(kept))
        offsets = self.places - np.where(np.array(above)[:, None] >= 0, self.places[list(above)], self.places[:1])
        names = tuple(names[nodes.index(node)] for node in kept)
        self.skeleton = roles.with_roles(Skeleton(gltf.path.stem, names, above, offsets))
        _check_roles(gltf.path, self.skeleton)

    def line(self, node: int) -> list[int]:
        """The node, its parent, and so on up."""
        line = [node]
        while self.parents[line[-1]] >= 0:
            line.append(self.parents[line[-1]])
        return line

    def joint(self, node: int) -> int:
        """Index of the joint that a node is or hangs on; -1 for none. What is above the root hangs on the root."""
        found = next((self.index[one] for one in self.line(node) if one in self.index), -1)
        return 0 if found < 0 and node in self.line(next(iter(self.index))) else found

    def _common(self, nodes: list[int]) -> int:
        """The lowest node that all hang from."""
        lines = [self.line(node) for node in nodes]
        return next(node for node in lines[0] if all(node in line for line in lines))


def _check_roles(path: Path, skeleton: Skeleton) -> None:
    """Can motions be brought to this skeleton?"""
    known = roles.recognise(skeleton.joints)
    places = skeleton.rest_positions
    try:
        from_points({role: places[None, skeleton.index(joint)] for role, joint in known.items()}, 1.0, upright=True)
    except MotionloomError as problem:
        raise FormatError(
            path, f"its skeleton cannot be played: {problem} Accepted: joints with names as Mixamo, VRM, Rigify, "
            "Unreal, Biped or SMPL have them, standing upright."
        ) from problem  # fmt: skip


def _world(gltf: Gltf, parents: list[int]) -> list[np.ndarray]:
    """(4, 4) of every node, in the world."""
    local = [_local(node) for node in gltf.items("nodes")]
    world: dict[int, np.ndarray] = {}
    for number in range(len(local)):
        line = [number]
        while line[-1] not in world and parents[line[-1]] >= 0:
            line.append(parents[line[-1]])
        for node in reversed(line):
            if node not in world:
                world[node] = local[node] if parents[node] < 0 else world[parents[node]] @ local[node]
    return [world[number] for number in range(len(local))]


def _local(node: dict[str, Any]) -> np.ndarray:
    """(4, 4) of a node below its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    made = np.eye(4)
    turn = np.array(node.get("rotation", (0, 0, 0, 1)), np.float64).reshape(4)[[3, 0, 1, 2]]
    scale = np.array(node.get("scale", (1, 1, 1)), np.float64).reshape(3)
    made[:3, :3] = rotations.quaternion_to_matrix(rotations.normalise(turn)) * scale
    made[:3, 3] = np.array(node.get("translation", (0, 0, 0)), np.float64).reshape(3)
    return made


# ---- meshes -------------------------------------------------------------------------------------------------


def _pieces_of(gltf: Gltf, bones: _Bones, number: int, node: dict[str, Any]) -> Iterator[Piece]:
    """The triangles of a node's mesh as they stand at rest."""
    skin = gltf.item("skins", node["skin"]) if "skin" in node else None
    for primitive in gltf.item("meshes", node["mesh"])["primitives"]:
        attributes = primitive["attributes"]
        if primitive.get("mode", _TRIANGLES) != _TRIANGLES or "POSITION" not in attributes:
            continue
        places = gltf.array(attributes["POSITION"])
        if skin is not None and "JOINTS_0" in attributes:
            hung = _skinned(gltf, bones, skin, attributes, places)
        else:
            hung = _rigid(bones, number, places)
        if hung is None:
            continue
        vertices, joints, weights = hung
        faces = gltf.array(primitive["indices"]) if "indices" in primitive else np.arange(len(places) // 3 * 3)
        if np.linalg.det(bones.world[number][:3, :3]) < 0 and skin is None:
            faces = faces[::-1]  # mirrored
        yield Piece(
            vertices, faces.astype(np.int64).reshape(-1, 3), joints=joints, weights=weights,
            **_painting(gltf, primitive, attributes),
        )  # fmt: skip


_Hung = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Vertices (N, 3) at rest, their joints (N, 4) and weights (N, 4)."""


def _rigid(bones: _Bones, number: int, places: np.ndarray) -> _Hung | None:
    """A mesh that hangs on one joint; None where there is no joint above it."""
    joint = next((bones.index[one] for one in bones.line(number) if one in bones.index), -1)
    if joint < 0:
        return None
    matrix = bones.world[number]
    weights = np.tile(np.eye(1, INFLUENCES), (len(places), 1))
    return places @ matrix[:3, :3].T + matrix[:3, 3], np.full((len(places), INFLUENCES), joint), weights


def _skinned(gltf: Gltf, bones: _Bones, skin: dict, attributes: dict, places: np.ndarray) -> _Hung:
    """A skin under the matrices of its joints, the strongest four of each vertex kept."""
    sets = [n for n in range(len(attributes)) if f"JOINTS_{n}" in attributes and f"WEIGHTS_{n}" in attributes]
    held = np.concatenate([gltf.array(attributes[f"JOINTS_{n}"]) for n in sets], axis=1).astype(np.int64)
    share = np.concatenate([gltf.array(attributes[f"WEIGHTS_{n}"]) for n in sets], axis=1)
    order = np.argsort(-share, axis=1, kind="stable")[:, :INFLUENCES]
    held, share = np.take_along_axis(held, order, axis=1), np.take_along_axis(share, order, axis=1)
    share /= np.maximum(share.sum(axis=1, keepdims=True), 1e-9)
    nodes = skin["joints"]
    binding = np.tile(np.eye(4), (len(nodes), 1, 1))
    if "inverseBindMatrices" in skin:
        binding = gltf.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    matrices = np.stack([bones.world[node] for node in nodes]) @ binding[: len(nodes)]
    padded = np.concatenate([places, np.ones((len(places), 1))], axis=1)
    vertices = np.einsum("nk,nkab,nb->na", share, matrices[held, :3], padded)
    return vertices, np.maximum([bones.joint(node) for node in nodes], 0)[held], share


# ---- paint --------------------------------------------------------------------------------------------------


def _painting(gltf: Gltf, primitive: dict, attributes: dict) -> dict[str, Any]:
    """What a primitive is painted with, as `Piece` has it."""
    material = gltf.item("materials", primitive["material"]) if "material" in primitive else {}
    look = material.get("pbrMetallicRoughness", {})
    light = np.array(look.get("baseColorFactor", (1, 1, 1, 1)), np.float64)[:3]
    texture = look.get("baseColorTexture")
    if texture is not None:
        picture = _picture(gltf, texture)
        place = attributes.get(f"TEXCOORD_{texture.get('texCoord', 0)}")
        if picture is not None and place is not None:
            return {"picture": _lit(picture, light), "uv": gltf.array(place)}
    if "COLOR_0" in attributes:
        return {"colours": _srgb(gltf.array(attributes["COLOR_0"])[:, :3] * light)}
    return {"colour": tuple(int(value) for value in _srgb(light))} if look else {}


def _picture(gltf: Gltf, texture: dict) -> np.ndarray | None:
    """(h, w, 3) uint8 of a texture; None of one outside the file or of a kind that is no picture."""
    held = gltf.item("textures", texture["index"])
    source = held.get("source", held.get("extensions", {}).get("EXT_texture_webp", {}).get("source"))
    image = gltf.item("images", source) if source is not None else {}
    if "bufferView" not in image:
        return None
    try:
        return pixels(gltf.path, Image.open(io.BytesIO(gltf.stored(image["bufferView"]))))
    except (OSError, ValueError, Image.DecompressionBombError) as problem:
        raise FormatError(gltf.path, f"has a texture that cannot be read ({problem}).") from problem


def _lit(picture: np.ndarray, light: np.ndarray) -> np.ndarray:
    """A picture under a factor (3,) of linear light."""
    if np.allclose(light, 1.0, atol=1e-3):
        return picture
    steps = np.arange(256) / 255.0
    linear = np.where(steps <= 0.04045, steps / 12.92, ((steps + 0.055) / 1.055) ** 2.4)
    return np.stack([_srgb(linear * light[channel])[picture[..., channel]] for channel in range(3)], axis=-1)


def _srgb(light: np.ndarray) -> np.ndarray:
    """Linear light, 0 to 1, as sRGB bytes."""
    light = np.clip(light, 0, 1)
    return np.round(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)).astype(
        np.uint8
    )
