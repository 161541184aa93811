from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from engines import features
from engines.errors import OutOfRangeError, UnknownLabelError
from engines.features.layout import EMPHASIS, Layout, Part, Statistics

SMALL = Layout((Part("height", (1,), EMPHASIS), Part("joints", (2, 3)), Part("contacts", (4,), EMPHASIS)))


def test_sizes_are_the_papers() -> None:
    sizes = {name: features.get(name).layout.size for name in features.available()}
    assert {sizes[name] for name in ("humanml3d", "humanml3d-official")} == {263}
    assert {sizes[name] for name in ("kit", "kit-official")} == {251}
    assert {sizes[name] for name in ("style", "style-official")} == {260}
    assert {sizes[name] for name in ("smplh", "smplh-official")} == {315}
    assert sizes["lie"] == 74
    assert all(features.get(name).name == name for name in sizes)
    assert [features.get(name).fps for name in ("humanml3d", "kit", "style", "smplh")] == [20.0, 12.5, 30.0, 20.0]


def test_roots_and_contacts_count_five_times() -> None:
    for name in ("humanml3d", "kit", "style", "lie"):
        emphasis = {part.name: part.emphasis for part in features.get(name).layout}
        told = {"yaw_velocity", "root_velocity", "root_height", "contacts"}
        assert {part for part, weight in emphasis.items() if weight == 5.0} == told
        assert {weight for part, weight in emphasis.items() if part not in told} == {1.0}


def test_an_unknown_representation_is_told_the_nearest() -> None:
    with pytest.raises(UnknownLabelError, match="humanml3d"):
        features.get("humanml")


def test_slices_follow_one_another() -> None:
    assert SMALL.size == 11
    assert [SMALL[name] for name in SMALL.names] == [slice(0, 1), slice(1, 7), slice(7, 11)]
    with pytest.raises(UnknownLabelError, match="joints"):
        SMALL["joint"]


def test_parts_come_apart_as_views_and_go_together_again() -> None:
    values = np.arange(2 * 3 * 11, dtype=np.float32).reshape(2, 3, 11)
    parts = SMALL.split(values)
    assert parts["joints"].shape == (2, 3, 2, 3)
    assert all(np.shares_memory(part, values) for part in parts.values())
    np.testing.assert_array_equal(SMALL.join(**parts), values)
    assert SMALL.read(torch.from_numpy(values), "joints").shape == (2, 3, 2, 3)
    seen = SMALL.without("contacts")
    assert seen.size == 7
    assert seen["joints"] == slice(1, 7)


def test_parts_that_do_not_fit_are_refused() -> None:
    parts = SMALL.split(np.zeros((5, 11), np.float32))
    with pytest.raises(OutOfRangeError, match="missing: contacts"):
        SMALL.join(height=parts["height"], joints=parts["joints"])
    with pytest.raises(OutOfRangeError, match=r"joints.*\(5, 2, 3\)"):
        SMALL.join(**{**parts, "joints": np.zeros((5, 3, 2))})
    with pytest.raises(UnknownLabelError, match="velocity"):
        SMALL.join(**parts, velocity=np.zeros((5, 1)))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.zeros((4, 10)), r"frames, 11"),
        (np.zeros((0, 11)), "1 frame or more"),
        (np.zeros(11), r"frames, 11"),
        (np.full((2, 11), np.nan), "finite"),
    ],
)
def test_features_that_are_none_are_refused(values: np.ndarray, said: str) -> None:
    with pytest.raises(OutOfRangeError, match=said):
        SMALL.check(values)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.lists(st.integers(1, 9), min_size=1, max_size=5))
def test_statistics_of_many_clips_are_those_of_all_their_frames(seed: int, lengths: list[int]) -> None:
    rng = np.random.default_rng(seed)
    clips = [(rng.normal(size=(n, 11)) * rng.uniform(0.1, 9, 11) + 50).astype(np.float32) for n in lengths]
    found = Statistics.measure(clips, SMALL)
    rows = np.concatenate(clips).astype(np.float64)
    np.testing.assert_allclose(found.mean, rows.mean(axis=0), rtol=1e-6)
    if len(rows) > 1:
        for name in SMALL.names:
            np.testing.assert_allclose(found.std[SMALL[name]], rows.std(axis=0)[SMALL[name]].mean(), rtol=1e-5)
    np.testing.assert_allclose(found.denormalise(found.normalise(rows)), rows, rtol=1e-5)


def test_emphasised_parts_come_out_five_times_as_large() -> None:
    rng = np.random.default_rng(1)
    clip = rng.normal(size=(400, 11)).astype(np.float32)
    plain = Statistics.measure([clip], SMALL)
    ratio = plain.emphasised(SMALL).normalise(clip) / plain.normalise(clip)
    np.testing.assert_allclose(ratio[:, SMALL["height"]], 5, rtol=1e-5)
    np.testing.assert_allclose(ratio[:, SMALL["joints"]], 1, rtol=1e-5)
    fewer = SMALL.without("joints")
    np.testing.assert_array_equal(plain.chosen(SMALL, fewer).mean, np.r_[plain.mean[:1], plain.mean[7:]])


def test_a_part_that_never_changes_is_centred_and_not_blown_up() -> None:
    clip = np.random.default_rng(2).normal(size=(30, 11)).astype(np.float32)
    clip[:, SMALL["contacts"]] = 1
    found = Statistics.measure([clip], SMALL)
    assert not found.normalise(clip)[:, SMALL["contacts"]].any()
    assert (found.std[SMALL["contacts"]] == 1).all()


def test_statistics_of_nothing_or_nonsense_are_refused() -> None:
    with pytest.raises(OutOfRangeError, match="1 or more"):
        Statistics.measure([], SMALL)
    with pytest.raises(OutOfRangeError, match="positive"):
        Statistics(np.zeros(3), np.array([1.0, 0.0, 1.0]))
    with pytest.raises(OutOfRangeError, match="finite"):
        Statistics(np.array([np.nan]), np.ones(1))
