"""Corpora into the cache and out of it, on a handful of real clips of each."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engines import datasets
from engines.datasets.corpus import HOUSE_FPS, ClipInfo
from engines.datasets.prepare import _check, _splits
from engines.errors import Cancelled, FormatError, MotionloomError, UnknownLabelError
from engines.geometry import canonical, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22


@pytest.fixture(scope="module")
def prepared(real_clips: Path, tmp_path_factory: pytest.TempPathFactory):
    """The cache's folder, what `prepare` gave back, and the progress it told. One clip of the source is broken."""
    source, cache = tmp_path_factory.mktemp("source") / "all", tmp_path_factory.mktemp("cache")
    shutil.copytree(real_clips, source)
    (source / "utd" / "a1_s1_t1_skeleton.mat").write_bytes(b"MATLAB 5.0 MAT-file, or so it says")
    told: list[tuple[int, int, str]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLOOM_CACHE", str(cache))
        result = datasets.prepare(source, progress=lambda *at: told.append(at), workers=1)
    return cache, result, told


@pytest.fixture
def cache(prepared, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(prepared[0]))
    return prepared[0]


def clip(name: str) -> datasets.Clip:
    return next(c for c in datasets.load() if c.name == name)


def height(motion: Motion, joint: str) -> np.ndarray:
    return motion.positions[:, SMPL22.index(joint), 1]


@pytest.mark.data
def test_every_clip_is_a_house_motion(cache: Path) -> None:
    clips = datasets.load()
    assert len(clips) == 10
    assert {c.corpus for c in clips} == {"bandai-namco", "cmu", "utd-mhad"}
    for c in clips:
        motion = c.motion
        assert motion.skeleton is SMPL22
        assert motion.fps == HOUSE_FPS == 20.0
        assert len(motion) >= 12
        assert motion.heading[0] == pytest.approx(0, abs=1e-5), c.name
        np.testing.assert_allclose(motion.positions[0, 0, [0, 2]], 0, atol=1e-5, err_msg=c.name)
        assert abs(canonical.floor_height(motion.positions, SMPL22)) < 0.01, c.name
        assert 0.5 < height(motion, "pelvis").mean() < 1.1, c.name
        assert motion.label_at(0) == c.action
        assert motion.label_at(0, "style") == c.style
        assert motion.provenance.source == f"{c.corpus}/{c.name}"


@pytest.mark.data
def test_load_chooses(cache: Path) -> None:
    assert {c.name for c in datasets.load(corpora=["cmu"])} == {"26_01", "09_12", "06_04"}
    assert [c.name for c in datasets.load(actions=["squat"])] == ["a27_s4_t3"]
    assert {c.split for c in datasets.load("test")} == {"test"}
    assert sum(len(datasets.load(split)) for split in ("train", "val", "test")) == 10  # type: ignore[arg-type]


@pytest.mark.data
def test_what_is_known_of_a_clip(cache: Path) -> None:
    walk = clip("26_01")
    assert (walk.action, walk.subject, walk.style) == ("walk", "26", None)
    assert clip("09_12").action is None, "a clip of several actions has no one name"
    turning = clip("dataset-2_walk-turn-left_active_041")
    assert (turning.action, turning.style) == ("turn left", "active")
    assert clip("a16_s6_t2").subject == "6"


@pytest.mark.data
def test_left_is_left_in_every_corpus(cache: Path) -> None:
    wave = clip("a3_s1_t3").motion.in_place()
    travel = {
        side: np.linalg.norm(np.diff(wave.positions[:, SMPL22.index(f"{side}_wrist")], axis=0), axis=-1).sum()
        for side in ("left", "right")
    }
    assert clip("a3_s1_t3").action == "wave right hand"
    assert travel["right"] > 5 * travel["left"]
    raised = clip("dataset-2_raise-up-left-hand_normal_002").motion
    assert np.ptp(height(raised, "left_wrist")) > 0.5
    assert np.ptp(height(raised, "right_wrist")) < 0.1
    assert clip("dataset-2_walk-turn-left_active_041").motion.heading[-1] > 0.8
    for walk in ("26_01", "dataset-1_walk_normal_001"):
        motion = clip(walk).motion
        ahead = np.stack([np.sin(motion.heading), np.cos(motion.heading)], axis=-1)[1:]
        step = np.diff(motion.positions[:, 0, [0, 2]], axis=0)
        assert (step * ahead).sum() > 0.8 * np.linalg.norm(step, axis=-1).sum() > 0.8, "people walk the way they face"


@pytest.mark.data
def test_a_squat_goes_down_and_bends_the_knees_forward(cache: Path) -> None:
    squat = clip("a27_s4_t3").motion
    low = int(height(squat, "pelvis").argmin())
    assert height(squat, "pelvis")[low] < height(squat, "pelvis").max() - 0.1
    for side in ("left", "right"):
        knee = rotations.quaternion_to_rotvec(squat.rotations[low, SMPL22.index(f"{side}_knee")])
        assert knee @ SMPL22.hinges[f"{side}_knee"] > 0.7


@pytest.mark.data
def test_a_broken_clip_is_left_out_and_reported(prepared) -> None:
    _, (path, failures), told = prepared
    assert [failure.clip for failure in failures] == ["utd-mhad/a1_s1_t1"]
    assert "a1_s1_t1_skeleton.mat" in failures[0].reason
    assert str(path.parent.parent) not in failures[0].reason
    with np.load(path, allow_pickle=False) as stored:
        index = json.loads(stored["index"].tobytes())
    assert index["left_out"] == [{"clip": "utd-mhad/a1_s1_t1", "reason": failures[0].reason}]
    assert [done for done, _, _ in told] == list(range(1, 12))
    assert {total for _, total, _ in told} == {11}


@pytest.mark.data
def test_cancel_leaves_the_old_cache(cache: Path, real_clips: Path) -> None:
    before = {path: path.read_bytes() for path in cache.rglob("*") if path.is_file()}
    with pytest.raises(Cancelled, match="old cache is untouched"):
        datasets.prepare(real_clips, ["utd-mhad"], cancel=lambda: True, workers=1)
    assert {path: path.read_bytes() for path in cache.rglob("*") if path.is_file()} == before


@pytest.mark.data
def test_a_cache_made_anew_is_read_anew(real_clips: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    source = tmp_path / "utd"
    source.mkdir()
    for name, count in (("a3_s1_t3", 1), ("a16_s6_t2", 2)):
        shutil.copy(real_clips / "utd" / f"{name}_skeleton.mat", source)
        datasets.prepare(source, ["utd-mhad"], workers=1)
        assert len(datasets.load()) == count


def test_no_cache_names_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path))
    with pytest.raises(FormatError, match="motionloom data prepare --source"):
        datasets.load()


def test_unknown_corpora_and_empty_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    with pytest.raises(UnknownLabelError, match="did you mean 'cmu'"):
        datasets.prepare(tmp_path, ["cmuu"])
    with pytest.raises(FormatError, match=r"holds none of .*cmu-mocap-subset\.tar\.xz"):
        datasets.prepare(tmp_path)
    (tmp_path / "a1_s1_t1_skeleton.mat").write_bytes(b"broken")
    with pytest.raises(FormatError, match="not one of 1 clips could be read; the first: utd-mhad/a1_s1_t1"):
        datasets.prepare(tmp_path, ["utd-mhad"], workers=1)
    assert not (tmp_path / "cache").exists(), "nothing half-written is left"


def test_a_cmu_folder_without_its_manifest(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"no manifest\.json"):
        list(datasets.CORPORA["cmu"].clips(tmp_path))
    (tmp_path / "manifest.json").write_text("[{")
    with pytest.raises(FormatError, match="not JSON"):
        list(datasets.CORPORA["cmu"].clips(tmp_path))


def infos(corpus: str, count: int, **facts) -> list[ClipInfo]:
    return [ClipInfo(corpus, f"clip_{i:03}", Path("x"), "walk", **facts) for i in range(count)]


def test_splits_are_stable_seeded_and_shared_out_by_action() -> None:
    clips = infos("cmu", 100) + [replace(c, action="run") for c in infos("bandai-namco", 40)]
    split = _splits(clips)
    assert split == _splits(clips)
    assert [split[:100].count(part) for part in ("train", "val", "test")] == [85, 5, 10]
    assert [split[100:].count(part) for part in ("train", "val", "test")] == [34, 2, 4]
    order = np.random.default_rng(0).permutation(len(clips))
    shuffled = _splits([clips[i] for i in order])
    assert shuffled == [split[i] for i in order], "a clip's part does not hang on the order of the files"


def test_utd_is_split_by_subject() -> None:
    clips = [c for subject in "12345678" for c in infos("utd-mhad", 5, subject=subject)]
    for c, part in zip(clips, _splits(clips), strict=True):
        assert part == {"7": "test", "6": "val"}.get(c.subject or "", "train")


def test_what_no_body_does_is_refused() -> None:
    turns, path = np.tile(rotations.IDENTITY, (20, 22, 1)), np.zeros((20, 3))
    _check(Motion(SMPL22, turns, path, 20.0))
    with pytest.raises(MotionloomError, match="only 5 frames"):
        _check(Motion(SMPL22, turns[:5], path[:5], 20.0))
    path[10:, 0] = 2.0
    with pytest.raises(MotionloomError, match="moves at 40 m/s"):
        _check(Motion(SMPL22, turns, path, 20.0))
