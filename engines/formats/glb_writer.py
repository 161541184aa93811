"""Motions as binary glTF: joints as nodes with an animation, and a skin over them where one is given.

The nodes rest in the skeleton's rest pose, standing on the floor; the inverse bind matrices are those of that pose.
Every frame is a key, joined linearly as the standard means it (slerp). Lengths are metres, Y up, facing +Z: glTF's own
conventions are ours, so nothing is turned. Numbers are float32, which is what glTF has.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from PIL import Image

from engines.errors import SkeletonError
from engines.formats.gltf import INDICES, VERTICES, Builder
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton

TEXTURE_QUALITY = 94
"""Of textures, as JPEG without loss of colour resolution."""
LINEAR, LINEAR_MIPMAP_LINEAR, CLAMP_TO_EDGE = 9729, 9987, 33071
"""The standard's numbers for how a texture is looked up."""


class Skin(Protocol):
    """A mesh over a skeleton, as a file needs it. `viewers.bodies` make such; engines know no body by name."""

    @property
    def name(self) -> str:
        """What the mesh is called."""
        ...

    @property
    def skeleton(self) -> Skeleton:
        """The skeleton that `skin_indices` refer to, in whose rest pose the mesh stands."""
        ...

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) rest positions, metres."""
        ...

    @property
    def normals(self) -> np.ndarray:
        """(V, 3) unit rest normals."""
        ...

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) vertex indices, counter-clockwise from outside."""
        ...

    @property
    def skin_indices(self) -> np.ndarray:
        """(V, 4) joint indices."""
        ...

    @property
    def skin_weights(self) -> np.ndarray:
        """(V, 4) weights, summing to one."""
        ...

    @property
    def colours(self) -> np.ndarray:
        """(V, 3) sRGB colours, 0 to 255."""
        ...

    @property
    def uv(self) -> np.ndarray | None:
        """(V, 2) places in the texture, u to the right, v down from its top left corner; None without one."""
        ...

    @property
    def texture(self) -> np.ndarray | None:
        """(h, w, 3) uint8 sRGB, written in place of the colours; None: the colours are."""
        ...


def write(motion: Motion, path: str | Path, skin: Skin | None = None) -> Path:
    """Write a motion as .glb.

    Args:
        motion: any motion.
        path: the file.
        skin: a mesh fitted to the motion's own skeleton; without one the file holds joints and their animation.

    Returns:
        The path. The exact rate is kept in the animation's `extras`; labels and provenance have no place in a .glb.

    Raises:
        FormatError: the file cannot be written.
        SkeletonError: the skin is of another skeleton.
    """
    skeleton = motion.skeleton
    if skin is not None and skin.skeleton != skeleton:
        raise SkeletonError(
            f"skin {skin.name!r} is of skeleton {skin.skeleton.name!r}, the motion of {skeleton.name!r}; accepted: a "
            "skin of the motion's own skeleton (viewers.bodies.body_for gives both)."
        )
    made = Builder()
    made.document["nodes"] = _nodes(skeleton, _floor(skeleton, skin))
    made.document["scenes"] = [{"name": "motionloom", "nodes": [0]}]
    made.document["scene"] = 0
    made.document["skins"] = [_skin(made, skeleton)]
    if skin is not None:
        made.document["meshes"] = [_mesh(made, skin)]
        made.document["materials"] = [_material(made, skin)]
        made.document["nodes"].append({"name": skin.name, "mesh": 0, "skin": 0})
        made.document["scenes"][0]["nodes"].append(len(skeleton))
    made.document["animations"] = [_animation(made, motion)]
    return made.save(Path(path))


def _floor(skeleton: Skeleton, skin: Skin | None) -> float:
    """Height of the lowest point of the rest pose."""
    points = skeleton.rest_positions if skin is None or not len(skin.vertices) else skin.vertices
    return float(points[:, 1].min())


def _nodes(skeleton: Skeleton, floor: float) -> list[dict[str, Any]]:
    """A node for each joint, index for index, in the rest pose on the floor."""
    nodes = []
    for joint, name in enumerate(skeleton.joints):
        place = skeleton.offsets[joint] - (np.array([0.0, floor, 0.0]) if joint == 0 else 0.0)
        node: dict[str, Any] = {"name": name, "translation": place.tolist()}
        if skeleton.children[joint]:
            node["children"] = list(skeleton.children[joint])
        nodes.append(node)
    return nodes


def _skin(made: Builder, skeleton: Skeleton) -> dict[str, Any]:
    """All joints, with the inverses of their places in the rest pose."""
    inverse = np.tile(np.eye(4, dtype=np.float32), (len(skeleton), 1, 1))
    inverse[:, 3, :3] = -skeleton.rest_positions  # column-major: the translation is the last four of sixteen
    return {
        "name": skeleton.name,
        "skeleton": 0,
        "joints": list(range(len(skeleton))),
        "inverseBindMatrices": made.accessor(inverse.reshape(-1, 16), "MAT4"),
    }


def _mesh(made: Builder, skin: Skin) -> dict[str, Any]:
    """The mesh with its weights and colours."""
    weights = np.asarray(skin.skin_weights, np.float64)
    weights = (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)
    # the standard wants joint 0 where a joint has no weight
    joints = np.where(weights > 0, skin.skin_indices, 0).astype(np.uint8 if len(skin.skeleton) <= 256 else np.uint16)
    few = len(skin.vertices) < 2**16 - 1
    vertices = np.asarray(skin.vertices, np.float32)
    attributes = {
        "POSITION": made.accessor(vertices, "VEC3", VERTICES, bounds=True),
        "NORMAL": made.accessor(_unit(skin.normals), "VEC3", VERTICES),
        **_painted(made, skin),
        "JOINTS_0": made.accessor(joints, "VEC4", VERTICES),
        "WEIGHTS_0": made.accessor(weights, "VEC4", VERTICES),
    }
    indices = made.accessor(skin.faces.astype(np.uint16 if few else np.uint32).reshape(-1), "SCALAR", INDICES)
    return {"name": skin.name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}


def _painted(made: Builder, skin: Skin) -> dict[str, int]:
    """Colours of the vertices, or their places in the texture: readers multiply where there are both."""
    if skin.uv is None:
        return {"COLOR_0": made.accessor(_linear(skin.colours), "VEC4", VERTICES, normalised=True)}
    return {"TEXCOORD_0": made.accessor(np.asarray(skin.uv, np.float32), "VEC2", VERTICES)}


def _material(made: Builder, skin: Skin) -> dict[str, Any]:
    """A matt one, with the texture as JPEG in the buffer where there is one."""
    look: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": 0.8}
    if skin.texture is not None:
        file = io.BytesIO()
        Image.fromarray(skin.texture).save(file, "JPEG", quality=TEXTURE_QUALITY, subsampling=0)
        made.document["images"] = [
            {"name": skin.name, "mimeType": "image/jpeg", "bufferView": made.view(file.getvalue())}
        ]
        made.document["samplers"] = [
            {"magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE}
        ]
        made.document["textures"] = [{"sampler": 0, "source": 0}]
        look["baseColorTexture"] = {"index": 0}
    return {"name": skin.name, "pbrMetallicRoughness": look}


def _unit(normals: np.ndarray) -> np.ndarray:
    """(V, 3) float32 of length one, upwards where there was none."""
    normals = np.asarray(normals, np.float64)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 1e-6, normals / np.maximum(length, 1e-6), [0.0, 1.0, 0.0]).astype(np.float32)


def _linear(colours: np.ndarray) -> np.ndarray:
    """(V, 3) sRGB bytes -> (V, 4) uint16 of linear light and full opacity, as glTF has vertex colours."""
    srgb = np.asarray(colours, np.float64) / 255.0
    light = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return np.round(np.concatenate([light, np.ones((len(light), 1))], axis=1) * 65535).astype(np.uint16)


def _animation(made: Builder, motion: Motion) -> dict[str, Any]:
    """Rotations of all joints and the path of the root, a key a frame."""
    times = made.accessor((np.arange(len(motion)) / motion.fps).astype(np.float32), "SCALAR", bounds=True)
    turns = _continuous(motion.rotations)[..., [1, 2, 3, 0]].astype(np.float32)  # glTF has w last
    path = (motion.translation + motion.skeleton.offsets[0]).astype(np.float32)
    tracks = [(0, "translation", made.accessor(path, "VEC3"))]
    tracks += [(j, "rotation", made.accessor(turns[:, j], "VEC4")) for j in range(len(motion.skeleton))]
    said = dict.fromkeys(segment.value for segment in motion.labels)
    return {
        "name": ", ".join(said)[:120] or "motion",
        "samplers": [{"input": times, "output": output, "interpolation": "LINEAR"} for _, _, output in tracks],
        "channels": [
            {"sampler": i, "target": {"node": node, "path": what}} for i, (node, what, _) in enumerate(tracks)
        ],
        "extras": {"fps": motion.fps},
    }


def _continuous(turns: np.ndarray) -> np.ndarray:
    """(T, J, 4) the same rotations, each on the side of its predecessor, for programs that interpolate numbers."""
    flips = np.einsum("tjc,tjc->tj", turns[1:], turns[:-1]) < 0
    signs = np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
    return np.concatenate([turns[:1], turns[1:] * signs[..., None]])
