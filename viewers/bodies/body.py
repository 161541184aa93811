"""Body: a skin over a skeleton, in the form every viewer wants it: rest mesh, weights, colours or a texture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Float32, UInt8, UInt16, UInt32
from scipy import sparse

from engines.errors import SkeletonError
from engines.geometry.skins import INFLUENCES, skinning_matrices
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton

LARGEST_TEXTURE = 2048
"""Longest side of a texture, pixels."""


@dataclass(frozen=True)
class Slider:
    """One way in which a body's shape can be changed."""

    name: str
    """As in `Body.shaped(name=value)`."""
    low: float
    """The least value accepted."""
    high: float
    """The greatest value accepted."""
    usual: float
    """The value of the body as it comes."""
    words: str = ""
    """What it does, for a person."""


@dataclass(frozen=True, eq=False)
class Body:
    """A triangle mesh in its skeleton's rest pose with skin weights and colours. Arrays are read-only.

    Raises:
        SkeletonError: arrays do not fit together.
    """

    name: str
    """What `bodies.get` knows it by."""
    skeleton: Skeleton
    """The skeleton the weights refer to."""
    vertices: Float32[np.ndarray, "V 3"]
    """(V, 3) float32 rest positions, metres."""
    faces: UInt32[np.ndarray, "F 3"]
    """(F, 3) uint32 vertex indices, counter-clockwise from outside."""
    normals: Float32[np.ndarray, "V 3"]
    """(V, 3) float32 unit rest normals."""
    skin_indices: UInt16[np.ndarray, "V 4"]
    """(V, 4) uint16 joint indices."""
    skin_weights: Float32[np.ndarray, "V 4"]
    """(V, 4) float32 weights, summing to one, largest first."""
    colours: UInt8[np.ndarray, "V 3"]
    """(V, 3) uint8 sRGB base colours; of a textured body the texture's at the vertices, for what draws no textures."""
    tint: Float32[np.ndarray, " V"]
    """(V,) float32: how far an actor's own colour replaces the base colour (1 on the shirt, 0 on skin)."""
    coarse: tuple[UInt32[np.ndarray, "_F 3"], ...] = ()
    """Fewer faces (F', 3) over the same vertices, the finer first: for figures that are small, shadows and ghosts."""
    licence: str = ""
    """Where the mesh comes from and on what terms."""
    uv: Float32[np.ndarray, "V 2"] | None = None
    """(V, 2) float32 places in `texture`, 0 to 1: u to the right, v down from its top left corner, as glTF has them."""
    texture: UInt8[np.ndarray, "h w 3"] | None = None
    """(h, w, 3) uint8 sRGB base colours, drawn in place of `colours`; at most `LARGEST_TEXTURE` a side."""
    own_bones: bool = False
    """It keeps its own bone lengths, and motions are brought to it; else it is stretched to a motion's."""
    sliders: tuple[Slider, ...] = ()
    """What of its shape can be changed; see `shaped`."""
    shape: Mapping[str, float] = field(default_factory=dict)
    """Where its sliders are, those not at their usual values."""
    reshape: Callable[[Mapping[str, float]], Body] | None = None
    """Makes it anew with its sliders at other values; called by `shaped`."""

    def __post_init__(self) -> None:
        wanted = {
            "vertices": (np.float32, 3), "faces": (np.uint32, 3), "normals": (np.float32, 3),
            "skin_indices": (np.uint16, INFLUENCES), "skin_weights": (np.float32, INFLUENCES),
            "colours": (np.uint8, 3), "tint": (np.float32, None),
        }  # fmt: skip
        if self.texture is not None or self.uv is not None:
            self._check_texture()
            wanted["uv"] = (np.float32, 2)
        count = len(self.vertices)
        for name, (kind, width) in wanted.items():
            array = np.ascontiguousarray(getattr(self, name), dtype=kind)
            rows = len(self.faces) if name == "faces" else count
            shape = (rows,) if width is None else (rows, width)
            if array.shape != shape:
                raise SkeletonError(f"body {self.name!r}: {name} has shape {array.shape}; accepted: {shape}.")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "coarse", tuple(np.ascontiguousarray(level, np.uint32) for level in self.coarse))
        if count and (self.skin_indices.max() >= len(self.skeleton) or (len(self.faces) and self.faces.max() >= count)):
            raise SkeletonError(f"body {self.name!r}: faces or weights point at vertices or joints that do not exist.")

    def _check_texture(self) -> None:
        """Are texture and uv there, and of the kind they must be?"""
        texture, uv = self.texture, self.uv
        if texture is None or uv is None or not (np.all(np.asarray(uv) >= 0) and np.all(np.asarray(uv) <= 1)):
            raise SkeletonError(f"body {self.name!r}: accepted are a texture and uv, 0 to 1, together, or neither.")
        shape = texture.shape
        sides = len(shape) == 3 and shape[2] == 3 and min(shape) >= 1 and max(shape) <= LARGEST_TEXTURE
        if texture.dtype != np.uint8 or not sides:
            raise SkeletonError(
                f"body {self.name!r}: its texture is {texture.dtype} of shape {shape}; accepted: uint8, (h, w, 3), "
                f"1 to {LARGEST_TEXTURE} a side."
            )
        texture.setflags(write=False)

    def shaped(self, **values: float) -> Body:
        """This body with another shape.

        Args:
            values: slider -> value, see `sliders`; those not named stay where they are.

        Returns:
            Another Body; its skeleton differs where bones are longer or shorter.

        Raises:
            UnknownLabelError: a slider it does not have.
            OutOfRangeError: a value out of a slider's bounds.
        """
        from viewers.bodies.shaping import checked

        usual = {slider.name: slider.usual for slider in self.sliders}
        wanted = {name: v for name, v in {**self.shape, **checked(self, values)}.items() if v != usual[name]}
        if self.reshape is None or wanted == self.shape:
            return self
        return replace(self.reshape(wanted), shape=wanted, sliders=self.sliders, reshape=self.reshape)

    def painted(self, colour: tuple[float, float, float] | None) -> UInt8[np.ndarray, "V 3"]:
        """(V, 3) uint8 sRGB: the base colours, with `colour` (sRGB, 0..1) laid over them where `tint` says so.

        The base colour's own lightness differences survive, so trousers stay darker than the shirt.
        """
        if colour is None:
            return self.colours
        amount = self.tint[:, None]
        wanted = np.asarray(colour, dtype=np.float32) * 255.0
        return np.round(self.colours * (1 - amount) + wanted * amount).clip(0, 255).astype(np.uint8)

    def posed(self, motion: Motion, frame: int = 0) -> Float32[np.ndarray, "V 3"]:
        """(V, 3) float32 vertices of one frame, skinned on the CPU: for exporters and tests, not for playback.

        Raises:
            SkeletonError: the motion lives on another skeleton.
        """
        if motion.skeleton != self.skeleton:
            raise SkeletonError(
                f"body {self.name!r} is skinned to {self.skeleton.name!r}, not {motion.skeleton.name!r}."
            )
        matrices = skinning_matrices(self.skeleton, motion.positions[frame], motion.global_rotations[frame])
        return self.skinned(matrices)

    def skinned(self, matrices: Float[np.ndarray, "J 3 4"]) -> Float32[np.ndarray, "V 3"]:
        """(V, 3) float32 vertices under skinning matrices (J, 3, 4)."""
        blended = self._blended(matrices)
        return np.einsum("vij,vj->vi", blended[:, :, :3], self.vertices) + blended[:, :, 3]

    def deformed(
        self, matrices: Float[np.ndarray, "J 3 4"]
    ) -> tuple[Float32[np.ndarray, "V 3"], Float32[np.ndarray, "V 3"]]:
        """(V, 3) float32 vertices and unit normals under skinning matrices (J, 3, 4)."""
        blended = self._blended(matrices)
        turned = np.einsum("vij,vj->vi", blended[:, :, :3], self.normals)
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        vertices = np.einsum("vij,vj->vi", blended[:, :, :3], self.vertices) + blended[:, :, 3]
        return vertices, turned / np.maximum(length, np.float32(1e-12))

    def _blended(self, matrices: np.ndarray) -> np.ndarray:
        """(V, 3, 4) float32 matrix of each vertex."""
        flat = np.asarray(matrices, np.float32).reshape(len(matrices), 12)
        return (self._shares @ flat).reshape(-1, 3, 4)

    @cached_property
    def _shares(self) -> sparse.csr_matrix:
        """(V, J) the skin weights as a sparse matrix."""
        starts = np.arange(0, INFLUENCES * len(self.vertices) + 1, INFLUENCES)
        shape = (len(self.vertices), len(self.skeleton))
        return sparse.csr_matrix((self.skin_weights.ravel(), self.skin_indices.ravel().astype(np.int32), starts), shape)

    def fitted(self, skeleton: Skeleton) -> Body:
        """This body stretched to a skeleton of the same joints with other bone lengths.

        Limbs are stretched along their bones and keep their thickness; hands, feet and head keep their size.

        Raises:
            SkeletonError: other joints or another tree.
        """
        if skeleton == self.skeleton:
            return self
        if skeleton.joints != self.skeleton.joints or skeleton.parents != self.skeleton.parents:
            raise SkeletonError(f"body {self.name!r} fits skeletons of {self.skeleton.name!r}'s joints only.")
        here, there = self.skeleton.rest_positions, skeleton.rest_positions
        stretch = _bone_stretch(self.skeleton, skeleton)
        matrices = np.concatenate([stretch, (there - np.einsum("jab,jb->ja", stretch, here))[..., None]], axis=-1)
        return replace(self, skeleton=skeleton, vertices=self.skinned(matrices))

    @cached_property
    def height(self) -> float:
        """Metres from the lowest to the highest vertex of the rest pose."""
        return float(np.ptp(self.vertices[:, 1])) if len(self.vertices) else 0.0


def _bone_stretch(old: Skeleton, new: Skeleton) -> np.ndarray:
    """(J, 3, 3) stretch along each joint's main bone: the one to its farthest child that lies in the same chain."""
    stretch = np.tile(np.eye(3), (len(old), 1, 1))
    for joint, children in enumerate(old.children):
        if not children:
            continue
        child = max(children, key=lambda c: abs(old.offsets[c][1])) if joint == 0 else children[0]
        length = old.bone_lengths[child]
        if length > 1e-6:
            along = old.offsets[child] / length
            stretch[joint] += (new.bone_lengths[child] / length - 1.0) * np.outer(along, along)
    return stretch


def eight_bit_weights(weights: Float[np.ndarray, "V 4"]) -> UInt8[np.ndarray, "V 4"]:
    """(V, 4) weights in 255ths that still sum to one exactly: the largest takes what rounding left."""
    rounded = np.round(weights * 255).astype(np.int64)
    largest = rounded.argmax(1)
    rounded[np.arange(len(rounded)), largest] += 255 - rounded.sum(1)
    return rounded.astype(np.uint8)
