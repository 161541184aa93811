"""What is seen of rendered people before real backgrounds, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from engines import SMPL22
from engines.character import landmarks, mask, models
from engines.character.models import Body, Crop
from engines.character.picture import Picture, open_picture
from engines.character.sighting import Sighting, look
from engines.errors import FormatError, OutOfRangeError, UnknownLabelError
from engines.evaluation.characters import overlap
from tests.engines.character.people import Person, arms_down, background, needs_networks, photographed

SHOULDERS, HIPS = ("left_shoulder", "right_shoulder"), ("left_hip", "right_hip")


@pytest.fixture(scope="module")
def person() -> Person:
    return photographed(arms_down())


@pytest.fixture(scope="module")
def sighting(person: Person) -> Sighting:
    return look(Picture(person.pixels))


@needs_networks
def test_landmarks_lie_on_the_joints_left_on_the_pictures_right(person: Person, sighting: Sighting) -> None:
    assert sighting.remarks == ()
    assert (sighting.seen > 0.5).all()
    scale = np.ptp(person.joints[:, 1]) / np.ptp(person.motion.positions[0, :, 1])  # pixels a metre
    off = {
        name: np.hypot(*(sighting.points[landmarks.index(name)] - person.joints[SMPL22.index(joint)])) / scale
        for name, joint in landmarks.JOINTS.items()
    }
    assert np.mean(list(off.values())) < 0.03
    assert max(off.values()) < 0.07
    assert sighting.scale == pytest.approx(scale, rel=0.1)


@needs_networks
def test_places_are_in_house_axes_about_the_hips(person: Person, sighting: Sighting) -> None:
    at = dict(zip(landmarks.NAMES, sighting.places, strict=True))
    assert np.abs(at["left_hip"] + at["right_hip"]).max() < 0.02
    joints = person.motion.positions[0]
    for name, joint in landmarks.JOINTS.items():
        truth = joints[SMPL22.index(joint)] - joints[[SMPL22.index(hip) for hip in HIPS]].mean(axis=0)
        assert np.hypot(*(at[name] - truth)[:2]) < 0.12, name
    assert at["nose"][2] > at["left_ear"][2] + 0.05  # the face is toward the camera


@needs_networks
def test_what_is_nearer_to_the_camera_has_the_greater_z() -> None:
    forward = arms_down(left_shoulder=(0, -70, 0))  # the left arm points at the camera
    at = dict(zip(landmarks.NAMES, look(Picture(photographed(forward).pixels)).places, strict=True))
    assert at["left_wrist"][2] > at["left_shoulder"][2] + 0.25
    assert at["left_wrist"][2] > at["right_wrist"][2] + 0.2


@needs_networks
@pytest.mark.parametrize("behind", ["china.jpg", "flower.jpg"])
def test_the_silhouette_overlaps_the_true_one(behind: str, person: Person, sighting: Sighting) -> None:
    if behind == "china.jpg":
        shown, seen = person, sighting
    else:
        shown = photographed(arms_down(), behind=behind)
        seen = look(Picture(shown.pixels))
    assert seen.mask.shape == shown.mask.shape and seen.mask.dtype == np.float32
    assert overlap(seen.mask > 0.5, shown.mask > 0.5) > 0.945


@needs_networks
def test_who_is_turned_on_the_side_is_found_too(person: Person, sighting: Sighting) -> None:
    lying = look(Picture(np.ascontiguousarray(np.rot90(person.pixels))))  # the head at the picture's left
    x, y = sighting.points.T
    assert np.abs(lying.points - np.stack([y, person.pixels.shape[1] - x], axis=1)).mean() < 12
    assert any("upright" in remark for remark in lying.remarks)


@needs_networks
def test_nobody_several_and_half_a_person_are_refused_in_words(person: Person) -> None:
    empty = background("china.jpg", (480, 720))
    with pytest.raises(FormatError, match=r"me\.jpg: nobody was found"):
        look(Picture(empty, "me.jpg"))
    with pytest.raises(FormatError, match="2 people were found"):
        look(Picture(np.concatenate([person.pixels, person.pixels], axis=1)))
    with pytest.raises(FormatError, match="hidden: the left foot, the right foot"):
        look(Picture(np.ascontiguousarray(person.pixels[:480])))


@needs_networks
def test_a_photograph_of_half_a_person_is_told_from_a_whole_one() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    portrait = open_picture(Path(matplotlib.get_data_path()) / "sample_data" / "grace_hopper.jpg")
    with pytest.raises(FormatError, match=r"grace_hopper\.jpg: outside it or hidden: the left foot, the right foot"):
        look(portrait)


@needs_networks
def test_who_stands_far_behind_is_left_out(person: Person) -> None:
    scene = Image.fromarray(background("china.jpg", (1000, 720)))
    figure, shape = Image.fromarray(person.pixels), Image.fromarray((person.mask * 255).astype(np.uint8))
    scene.paste(figure, (0, 0), shape)
    small = tuple(round(0.42 * side) for side in figure.size)
    scene.paste(figure.resize(small), (700, 200), shape.resize(small))
    seen = look(Picture(np.asarray(scene)))
    assert seen.remarks == ("1 more in the background is left out.",)
    assert seen.mask[:, 650:].max() < 0.5
    assert seen.points[:, 0].max() < 480


def known() -> Sighting:
    """Somebody of whom landmarks are known, 100 pixels a metre."""
    places = np.random.default_rng(1).normal(0, 0.5, (33, 3))
    points = 200 + 100 * places[:, :2] * (1, -1)
    picture = Picture(np.zeros((400, 400, 3), np.uint8))
    return Sighting(picture, points, np.full(33, 0.7), places, np.zeros((400, 400), np.float32))


def test_a_landmark_moved_by_hand_takes_its_place_along_and_is_seen() -> None:
    before = known()
    at = landmarks.index("left_knee")
    x, y = before.points[at]
    after = before.moved("left_knee", (x + 10, y + 20))
    assert np.allclose(after.points[at], (x + 10, y + 20)) and after.seen[at] == 1
    assert np.allclose(after.places[at] - before.places[at], (0.1, -0.2, 0))
    rest = np.arange(33) != at
    assert np.array_equal(after.points[rest], before.points[rest]) and np.array_equal(
        after.seen[rest], before.seen[rest]
    )
    assert before.seen[at] == 0.7
    with pytest.raises(UnknownLabelError, match="left_knee"):
        before.moved("left_kne", (1, 1))
    with pytest.raises(OutOfRangeError, match="0 to 400"):
        before.moved("left_knee", (401, 1))


def test_a_mask_painted_by_hand_takes_the_place_of_the_one_found() -> None:
    painted = known().painted(np.full((400, 400), 2.0))
    assert painted.mask.dtype == np.float32 and (painted.mask == 1).all()
    with pytest.raises(OutOfRangeError, match="400, 400"):
        painted.painted(np.zeros((4, 4)))


def test_the_scale_is_that_of_landmarks_in_plain_sight() -> None:
    before = known()
    points, seen = before.points.copy(), np.ones(33)
    points[:5], seen[:5] = 0, 0
    assert replace(before, points=points, seen=seen).scale == pytest.approx(100, rel=0.02)


@pytest.mark.parametrize(
    ("turned", "told"),
    [
        (lambda p: p[:, [2, 1, 0]] * (1, 1, -1), "from the side"),
        (lambda p: p * (-1, 1, -1), "from behind"),
        (lambda p: p[:, [1, 0, 2]] * (1, -1, 1), "upright"),
        (lambda p: p, None),
    ],
    ids=["side", "behind", "lying", "standing"],
)
def test_a_person_hard_to_see_is_remarked_upon(monkeypatch: pytest.MonkeyPatch, turned, told: str | None) -> None:
    upright = dict.fromkeys(landmarks.NAMES, (0.0, 0.6, 0.1))
    for side, x in (("left", 0.15), ("right", -0.15)):
        for name, y in {"shoulder": 0.5, "elbow": 0.2, "hip": 0.0, "knee": -0.4, "ankle": -0.8, "toe": -0.9}.items():
            upright[f"{side}_{name}"] = (x, y, 0.0)
    places = turned(np.array([upright[name] for name in landmarks.NAMES]))
    crop = Crop(np.full(2, 300.0), 500.0, 0.0)
    body = Body(1.0, 300 + 320 * places[:, :2] * (1, -1), np.ones(33), places, np.zeros((256, 256)), crop, crop)
    monkeypatch.setattr(models, "detect", lambda pixels: [crop])
    monkeypatch.setattr(models, "examine", lambda pixels, crop: body)
    shape = np.zeros((600, 600), np.float32)
    shape[200:400, 200:400] = 1
    monkeypatch.setattr(mask, "silhouette", lambda pixels, looks: shape)
    remarks = [remark for remark in look(Picture(np.zeros((600, 600, 3), np.uint8))).remarks if "tall" not in remark]
    assert (told in " ".join(remarks)) if told else not remarks
