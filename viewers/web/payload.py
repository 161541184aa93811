"""The bytes that travel to the browser: the body once, then quaternions and root positions per take.

This page is the one description of the layout; `src/payload.js` reads it. Everything is little-endian.

    offset          what
    0               magic, the four bytes "MLP1"
    4               uint32 H, length of the header
    8               header: H bytes of JSON in UTF-8, padded with spaces so that 8 + H is a multiple of 4
    8 + H           the arrays, C order, each starting at a multiple of 4

    header["kind"]    "body" or "takes"
    header["arrays"]  name -> [type, shape, offset counted from the end of the header]

A *body* (sent once): `vertices` uint16 (V, 3), where position = low + (high - low) * value / 65535 with the header's
`low` and `high`; `normals` int16 (V, 3), unit vectors times 32767; `faces` uint16 or uint32 (F, 3), and
`coarse0`, `coarse1`, ..., where the body has them, fewer and fewer faces over the same vertices, for ghosts, shadows
and crowds; `skin_indices` uint8 (V, 4);
`skin_weights` uint8 (V, 4) that add up to 255 per vertex; `colours` uint8 (V, 3) sRGB; `tint` uint8 (V,), how far (of
255) the actor's own colour replaces that colour; `header["skeleton"]` the rest pose it is bound to. A textured one
also has `texture` uint8 (N,), a picture in sRGB as a file of the kind that `header["texture"]` names, and `uv` uint16
(V, 2), places in it times 65535: u to the right, v down from its top left corner.

*Takes* (sent whenever the motions change): `header["skeletons"]`, and `header["actors"]` with name, colour, offset,
fps, frames, labels and the index of a skeleton. Actor i owns `rotations{i}` int16 (T, J, 4), unit quaternions wxyz
times 32767, parent-relative, neighbours in time on one hemisphere; `path{i}` float32 (T, 3) root position, metres;
`contacts{i}` uint8 (T, ceil(N / 8)), one bit per foot joint in the order of `skeleton.feet` (ankle, toe, ankle, toe),
lowest bit first.

Ten seconds of 22 joints at 20 fps take about 40 kB. The error is under 0.01 degrees per joint; root positions are
good to 0.01 mm within 100 m of the origin.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from engines.errors import FormatError, OutOfRangeError
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton
from viewers.bodies.body import Body, eight_bit_weights
from viewers.scene import PALETTE

MAGIC = b"MLP1"
MAX_ACTORS = 16
UNIT_STEPS = 32767
POSITION_STEPS = 65535
BYTE_STEPS = 255
TEXTURE_QUALITY = 92
"""Of textures, as WebP: photographs of 1,024 pixels a side take some 200 kB."""


@dataclass(frozen=True)
class Actor:
    """One motion as the player shows it."""

    motion: Motion
    name: str = ""
    """Shown under the figure; empty: the player's choice."""
    colour: str = ""
    """CSS colour `#rrggbb`; empty: the next of `viewers.scene.PALETTE`."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the player puts it, metres, on top of the arrangement."""


def pack(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Header and arrays -> one byte string in the layout above."""
    index, chunks, offset = {}, [], 0
    for name, array in arrays.items():
        data = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).tobytes()
        index[name] = [array.dtype.name, list(array.shape), offset]
        padding = -len(data) % 4
        chunks += [data, b"\0" * padding]
        offset += len(data) + padding
    text = json.dumps({**header, "arrays": index}, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([MAGIC, len(text).to_bytes(4, "little"), text, *chunks])


def unpack(data: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The inverse of `pack`: header and arrays by name.

    Raises:
        FormatError: these bytes are not a payload.
    """
    if data[:4] != MAGIC:
        raise FormatError("payload", f"starts with {data[:4]!r}; accepted: {MAGIC!r}.")
    start = 8 + int.from_bytes(data[4:8], "little")
    header = json.loads(data[8:start])
    arrays = {}
    for name, (kind, shape, offset) in header["arrays"].items():
        dtype = np.dtype(kind).newbyteorder("<")
        arrays[name] = np.frombuffer(data, dtype, int(np.prod(shape)), start + offset).reshape(shape)
    return header, arrays


def encode_body(body: Body | None) -> bytes:
    """A body -> bytes; no body gives an empty payload, on which the player draws skeletons only.

    Raises:
        OutOfRangeError: the body is bound to more joints than a byte can name.
    """
    if body is None:
        return b""
    if len(body.skeleton) > 256:
        raise OutOfRangeError("number of joints of the body", len(body.skeleton), "at most 256")
    vertices = np.asarray(body.vertices, dtype=np.float64)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    number = np.uint16 if len(vertices) <= 65536 else np.uint32
    arrays = {
        "vertices": np.rint((vertices - low) / span * POSITION_STEPS).astype(np.uint16),
        "normals": np.rint(body.normals * UNIT_STEPS).astype(np.int16),
        "faces": body.faces.astype(number),
        "skin_indices": body.skin_indices.astype(np.uint8),
        "skin_weights": eight_bit_weights(body.skin_weights),
        "colours": body.colours,
        "tint": np.rint(body.tint * BYTE_STEPS).astype(np.uint8),
    }
    arrays |= {f"coarse{i}": faces.astype(number) for i, faces in enumerate(body.coarse)}
    header = {
        "kind": "body",
        "low": low.tolist(),
        "high": (low + span).tolist(),
        "skeleton": describe_skeleton(body.skeleton),
    }
    if body.texture is not None and body.uv is not None:
        file = io.BytesIO()
        Image.fromarray(body.texture).save(file, "WEBP", quality=TEXTURE_QUALITY)
        header["texture"] = "image/webp"
        arrays["texture"] = np.frombuffer(file.getvalue(), np.uint8)
        arrays["uv"] = np.rint(body.uv * POSITION_STEPS).astype(np.uint16)
    return pack(header, arrays)


def encode_takes(actors: Sequence[Actor]) -> bytes:
    """Motions with their names, colours and places -> bytes.

    Raises:
        OutOfRangeError: no actor at all, or more than `MAX_ACTORS`.
    """
    if not 1 <= len(actors) <= MAX_ACTORS:
        raise OutOfRangeError("number of motions", len(actors), f"1 to {MAX_ACTORS} in one player")
    skeletons: list[Skeleton] = []
    described, arrays = [], {}
    for i, actor in enumerate(actors):
        if actor.motion.skeleton not in skeletons:
            skeletons.append(actor.motion.skeleton)
        described.append(_describe_actor(actor, skeletons.index(actor.motion.skeleton)))
        arrays[f"rotations{i}"] = quantise_rotations(actor.motion.rotations)
        arrays[f"path{i}"] = actor.motion.translation.astype(np.float32)
        arrays[f"contacts{i}"] = pack_contacts(actor.motion.contacts)
    header = {"kind": "takes", "skeletons": [describe_skeleton(s) for s in skeletons], "actors": described}
    return pack(header, arrays)


def quantise_rotations(quaternions: np.ndarray) -> np.ndarray:
    """(T, J, 4) unit quaternions wxyz -> int16 (T, J, 4), neighbours in time on one hemisphere."""
    return np.rint(rotations.continuous(quaternions) * UNIT_STEPS).astype(np.int16)


def restore_rotations(steps: np.ndarray) -> np.ndarray:
    """int16 (T, J, 4) -> (T, J, 4) unit quaternions wxyz, as the browser does it."""
    return rotations.normalise(steps / UNIT_STEPS)


def pack_contacts(contacts: np.ndarray) -> np.ndarray:
    """(T, feet, 2) booleans -> uint8 (T, ceil(2 * feet / 8)), lowest bit first."""
    return np.packbits(contacts.reshape(len(contacts), -1), axis=1, bitorder="little")


def describe_skeleton(skeleton: Skeleton) -> dict[str, Any]:
    """A skeleton as JSON values: names, tree, rest offsets to a micrometre, mirror partners and feet."""
    ends = {str(skeleton.index(joint)): np.round(end, 6).tolist() for joint, end in skeleton.end_offsets.items()}
    return {
        "name": skeleton.name,
        "joints": list(skeleton.joints),
        "parents": list(skeleton.parents),
        "offsets": np.round(skeleton.offsets, 6).tolist(),
        "ends": ends,
        "mirror": skeleton.mirror_index.tolist(),
        "feet": [skeleton.index(joint) for foot in skeleton.feet for joint in foot],
    }


def _describe_actor(actor: Actor, skeleton: int) -> dict[str, Any]:
    motion = actor.motion
    return {
        "name": actor.name,
        "colour": actor.colour or PALETTE[0],
        "offset": [float(x) for x in actor.offset],
        "fps": motion.fps,
        "frames": len(motion),
        "labels": [[s.start, s.end, s.kind, s.value] for s in motion.labels],
        "prompt": motion.provenance.prompt,
        "source": motion.provenance.source,
        "skeleton": skeleton,
    }
