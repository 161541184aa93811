"""The bytes that travel: size, precision, and that they say what they say."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from engines.errors import FormatError, OutOfRangeError
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.viewers.textured import checkers, textured
from tests.viewers.web.synthetic import walk
from viewers import bodies
from viewers.web import payload
from viewers.web.payload import Actor


def random_motion(seed: int, frames: int, reach: float = 20.0) -> Motion:
    rng = np.random.default_rng(seed)
    return Motion(SMPL22, rng.normal(size=(frames, 22, 4)), rng.uniform(-reach, reach, (frames, 3)), 20.0)


def test_ten_seconds_fit_in_sixty_kilobytes():
    assert len(payload.encode_takes([Actor(walk(10.0, 20.0))])) < 60_000


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**31), frames=st.integers(1, 40))
def test_precision(seed: int, frames: int):
    motion = random_motion(seed, frames)
    _, arrays = payload.unpack(payload.encode_takes([Actor(motion)]))
    restored = payload.restore_rotations(arrays["rotations0"])
    error = rotations.angle(rotations.multiply(rotations.invert(motion.rotations), restored))
    assert np.degrees(error).max() < 0.01
    assert np.abs(arrays["path0"] - motion.translation).max() < 1e-5


def test_neighbouring_rotations_lie_on_one_hemisphere():
    _, arrays = payload.unpack(payload.encode_takes([Actor(random_motion(3, 50))]))
    steps = arrays["rotations0"].astype(np.int64)
    assert ((steps[1:] * steps[:-1]).sum(-1) >= 0).all()


def test_contacts_are_bits_lowest_first():
    contacts = np.zeros((3, 2, 2), dtype=bool)
    contacts[0, 0, 0] = contacts[1, 0, 1] = contacts[1, 1, 1] = contacts[2, 1, 0] = True
    assert payload.pack_contacts(contacts).tolist() == [[0b0001], [0b1010], [0b0100]]


def test_header_tells_everything_about_the_actors():
    slow = walk(2.0, 30.0)
    data = payload.encode_takes([Actor(walk(1.0), "é", "#123456", (1, 0, -2.5)), Actor(slow)])
    header, arrays = payload.unpack(data)
    first, second = header["actors"]
    assert (first["name"], first["colour"], first["offset"]) == ("é", "#123456", [1.0, 0.0, -2.5])
    assert (first["frames"], second["frames"], second["fps"]) == (20, 60, 30.0)
    assert first["skeleton"] == second["skeleton"] == 0
    assert second["labels"][0] == [0, 25, "action", "walk"]
    assert arrays["rotations1"].shape == (60, 22, 4)
    assert header["skeletons"][0]["mirror"][1] == 2
    assert header["skeletons"][0]["feet"] == [
        SMPL22.index(j) for j in ("left_ankle", "left_foot", "right_ankle", "right_foot")
    ]


def test_different_skeletons_travel_once_each():
    tall = walk(1.0, skeleton=SMPL22.scaled({"*": 1.1}))
    header, _ = payload.unpack(payload.encode_takes([Actor(walk(1.0)), Actor(tall), Actor(walk(1.0))]))
    assert [actor["skeleton"] for actor in header["actors"]] == [0, 1, 0]
    assert len(header["skeletons"]) == 2


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["uint8", "uint16", "int16", "float32"]), st.integers(0, 7)), max_size=5))
def test_pack_and_unpack_are_inverse_and_aligned(kinds: list[tuple[str, int]]):
    arrays = {f"a{i}": (np.arange(n) * 3 + i).astype(kind) for i, (kind, n) in enumerate(kinds)}
    header, found = payload.unpack(payload.pack({"kind": "test"}, arrays))
    assert all(offset % 4 == 0 for _, _, offset in header["arrays"].values())
    assert {name: array.tolist() for name, array in found.items()} == {name: a.tolist() for name, a in arrays.items()}
    assert all(found[name].dtype == array.dtype for name, array in arrays.items())


@pytest.mark.parametrize("name", bodies.available())
def test_body_survives_to_a_tenth_of_a_millimetre(name: str):
    body = bodies.get(name)
    header, arrays = payload.unpack(payload.encode_body(body))
    low, high = np.array(header["low"]), np.array(header["high"])
    places = low + (high - low) * arrays["vertices"] / payload.POSITION_STEPS
    assert np.abs(places - body.vertices).max() < 1e-4
    assert np.abs(arrays["normals"] / payload.UNIT_STEPS - body.normals).max() < 1e-4
    assert (arrays["skin_weights"].sum(axis=1, dtype=np.int64) == 255).all()
    assert np.abs(arrays["skin_weights"] / 255 - body.skin_weights).max() < 0.01
    assert np.array_equal(arrays["faces"], body.faces)
    assert all(np.array_equal(arrays[f"coarse{i}"], faces) for i, faces in enumerate(body.coarse))
    assert np.array_equal(arrays["skin_indices"], body.skin_indices)
    assert np.allclose(header["skeleton"]["offsets"], body.skeleton.offsets, atol=1e-6)


def test_a_texture_travels_once_as_a_picture():
    body = textured(checkers())
    header, arrays = payload.unpack(payload.encode_body(body))
    assert np.abs(arrays["uv"] / payload.POSITION_STEPS - body.uv).max() < 1e-5
    assert header["texture"] == "image/webp" and len(arrays["texture"]) < 100_000
    picture = np.asarray(Image.open(io.BytesIO(arrays["texture"].tobytes())).convert("RGB"))
    assert np.abs(picture.astype(int) - checkers()).mean() < 3.0
    plain, without = payload.unpack(payload.encode_body(bodies.get("anny")))
    assert "texture" not in plain and not {"uv", "texture"} & set(without)


def test_no_body_no_bytes():
    assert payload.encode_body(None) == b""


@pytest.mark.parametrize("count", [0, 17])
def test_number_of_actors_is_checked(count: int):
    with pytest.raises(OutOfRangeError, match="1 to 16"):
        payload.encode_takes([Actor(walk(0.2))] * count)


def test_other_bytes_are_refused():
    with pytest.raises(FormatError, match="MLP1"):
        payload.unpack(b"PNG\x00....")
