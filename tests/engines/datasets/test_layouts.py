"""Readers of the papers' data sets on small folders of their layouts: the walk that went in comes out."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engines import datasets
from engines.datasets import CORPORA
from engines.datasets.corpus import HOUSE_FPS, ClipInfo, Timed
from engines.datasets.humanact12 import ACTIONS
from engines.datasets.joints import from_joints, load_npy, shape_of
from engines.errors import FormatError
from engines.geometry import canonical
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.datasets import folders

MAKERS: dict[str, Callable[[Path], Path]] = {
    "humanml3d": folders.humanml3d, "kit-ml": folders.kit, "humanact12": folders.humanact12, "ntu-rgbd": folders.ntu,
    "amass": folders.amass_folder, "babel": folders.babel, "aberman-styles": folders.styles,
    "xia-styles": folders.styles,
}  # fmt: skip


def found(name: str, folder: Path) -> dict[str, ClipInfo]:
    return {clip.name: clip for clip in CORPORA[name].clips(folder)}


def height(motion: Motion, joint: str) -> float:
    return float(motion.positions[:, SMPL22.index(joint), 1].mean())


def test_every_set_of_the_papers_has_a_maker_here() -> None:
    assert set(MAKERS) | {"bandai-namco", "cmu", "utd-mhad"} == set(CORPORA)


def test_the_page_of_data_sets_names_each_with_its_download() -> None:
    page = (Path(__file__).parents[3] / "docs" / "datasets.md").read_text(encoding="utf-8")
    for name, corpus in CORPORA.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
        assert f"({corpus.download})" in row


@pytest.mark.parametrize("name", MAKERS)
def test_what_goes_in_comes_out(name: str, tmp_path: Path) -> None:
    """Upright, facing ahead, the left hand up and the right down, as far along as it walked, nearly the same joints."""
    MAKERS[name](tmp_path / "data")
    clips = list(CORPORA[name].clips(tmp_path))
    assert clips
    clip = next(c for c in clips if not c.name.startswith("M"))
    motion = CORPORA[name].read(clip)
    assert motion.skeleton == SMPL22
    assert motion.fps == HOUSE_FPS
    assert motion.heading[0] == pytest.approx(0, abs=0.02)
    assert abs(canonical.floor_height(motion.positions, SMPL22)) < 0.01
    assert height(motion, "left_wrist") > height(motion, "neck")
    assert height(motion, "right_wrist") < height(motion, "spine3") - 0.2
    expected = folders.wave(ahead=0.0 if name == "ntu-rgbd" else 0.05).on_ground()
    if name == "ntu-rgbd":
        expected = folders.wave(fps=30.0, ahead=0.0).resample(HOUSE_FPS).on_ground()
    elif name == "kit-ml":
        expected = folders.wave(fps=12.5).resample(HOUSE_FPS).on_ground()
    assert abs(len(motion) - len(expected)) <= 1
    count = min(len(motion), len(expected))
    error = np.linalg.norm(motion.positions[:count] - expected.positions[:count], axis=-1)
    assert error.mean() < 0.05, f"{error.mean():.3f} m"
    limbs = [SMPL22.index(f"{side}_{joint}") for side in ("left", "right") for joint in ("wrist", "elbow", "ankle")]
    assert error[:, limbs].max() < 0.12


@pytest.mark.parametrize("name", MAKERS)
def test_an_empty_folder_and_the_other_sets_hold_none_of_it(name: str, tmp_path: Path) -> None:
    """No set takes another's files for its own, save AMASS's, which BABEL labels, and the two style sets."""
    assert list(CORPORA[name].clips(tmp_path)) == []
    for other, make in MAKERS.items():
        make(tmp_path / other)
    own = {name, "babel"} if name == "amass" else {name}
    for clip in CORPORA[name].clips(tmp_path):
        place = clip.path.relative_to(tmp_path).parts[0]
        assert place in own | ({"amass"} if name == "babel" else set()) | (
            {"aberman-styles", "xia-styles"} if name.endswith("styles") else set()
        )


def test_humanml3d_texts_splits_and_times(tmp_path: Path) -> None:
    clips = found("humanml3d", folders.humanml3d(tmp_path / "HumanML3D").parent)
    assert {name: clip.split for name, clip in clips.items()} == {
        "000000": "train", "M000000": "train", "000002": "val", "000001": "test",
    }  # fmt: skip
    assert clips["000000"].timed == (
        Timed("text", "a person waves with the left hand."),
        Timed("text", "he raises a hand", 0.5, 1.5),
    )
    assert clips["000001"].timed == (Timed("text", "walks # on"),), "nan is no time, and a sentence may hold a #"
    assert clips["000002"].timed == ()
    motion = CORPORA["humanml3d"].read(clips["000000"])
    assert [(s.start, s.end) for s in motion.labels if s.kind == "text"] == [(0, 40), (10, 30)]


def test_humanml3d_mirrored_ids_are_the_mirror_image(tmp_path: Path) -> None:
    clips = found("humanml3d", folders.humanml3d(tmp_path / "HumanML3D").parent)
    mirrored = CORPORA["humanml3d"].read(clips["M000000"])
    assert clips["M000000"].text == "a person waves with the right hand."
    assert height(mirrored, "right_wrist") > height(mirrored, "neck") > height(mirrored, "left_wrist")


@pytest.mark.parametrize("name", ["humanml3d", "kit-ml"])
def test_features_are_read_where_there_are_no_joints(name: str, tmp_path: Path) -> None:
    corpus = CORPORA[name]
    expected = folders.wave(fps=20.0 if name == "humanml3d" else 12.5)
    root = folders.vectors(tmp_path / "data", expected, f"{name.removesuffix('-ml')}-official")
    (clip,) = corpus.clips(tmp_path)
    motion = corpus.read(clip)
    expected = expected.resample(HOUSE_FPS).on_ground()
    count = min(len(motion), len(expected))
    assert count >= len(expected) - 2, "the last frame is lost to velocities"
    error = np.linalg.norm(motion.positions[:count] - expected.positions[:count], axis=-1)
    assert error.mean() < 0.05, f"{error.mean():.3f} m"
    np.save(root / "new_joint_vecs" / "000000.npy", np.zeros((9, 260), dtype=np.float32))
    with pytest.raises(FormatError, match=r"has shape \(9, 260\); accepted: \(frames, 2"):
        corpus.read(clip)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a person walks\n", r"000000\.txt:1: accepted: sentence#tags#start#end"),
        ("fine#x/NOUN#0.0#0.0\nwalks#x/NOUN#soon#0.0\n", r"000000\.txt:2: start and end are 'soon'"),
    ],
)
def test_a_broken_text_file_is_named_with_its_line(text: str, says: str, tmp_path: Path) -> None:
    root = folders.humanml3d(tmp_path / "HumanML3D")
    (root / "texts" / "000000.txt").write_text(text)
    with pytest.raises(FormatError, match=says):
        found("humanml3d", tmp_path)


def test_without_split_files_every_text_is_a_clip(tmp_path: Path) -> None:
    root = folders.humanml3d(tmp_path / "HumanML3D")
    for name in ("train", "val", "test"):
        (root / f"{name}.txt").unlink()
    clips = found("humanml3d", tmp_path)
    assert set(clips) == {"000000", "000001", "000002", "M000000"}
    assert {clip.split for clip in clips.values()} == {None}


def test_humanact12_names_coarse_and_fine(tmp_path: Path) -> None:
    assert len(ACTIONS) == 12
    assert sum(len(fine) for _, _, fine in ACTIONS) == 34
    clips = found("humanact12", folders.humanact12(tmp_path / "HumanAct12"))
    assert {(c.label, c.fine, c.action, c.subject) for c in clips.values()} == {
        ("warm up", "warm up, wrist and ankle", None, "03"),
        ("drink", "drink, bottle in left hand", None, "03"),
        ("throw", "throw, right hand", "throw", "03"),
    }, "0607 and 1301 are no actions"


def test_ntu_takes_all_three_bodies_and_refuses_others(tmp_path: Path) -> None:
    root = folders.ntu(tmp_path / "ntu")
    clips = found("ntu-rgbd", tmp_path)
    assert set(clips) == {"S001C001P003R001A023", "S001C001P003R002A023"}, "action 1 is none of the 13"
    assert {clip.label for clip in clips.values()} == {"hand waving"}
    eighteen, all49 = (CORPORA["ntu-rgbd"].read(clip) for clip in clips.values())
    assert np.abs(eighteen.positions - all49.positions)[:, SMPL22.index("left_wrist")].max() < 0.05
    np.save(root / "S001C001P003R001A024.npy", np.zeros((9, 17, 3)))
    with pytest.raises(FormatError, match=r"has shape \(9, 17, 3\); accepted: \(frames, 18, 24 or 49, 3\)"):
        CORPORA["ntu-rgbd"].read(found("ntu-rgbd", tmp_path)["S001C001P003R001A024"])


def test_amass_names_parts_and_sentences(tmp_path: Path) -> None:
    clips = found("amass", folders.amass_folder(tmp_path / "AMASS"))
    assert {name: clip.split for name, clip in clips.items()} == {
        "CMU/01/01_01": "train", "KIT/4/Walk01": "train", "SSM_synced/20/run": "test",
    }  # fmt: skip
    assert clips["CMU/01/01_01"].text == "forward jumps"
    assert clips["KIT/4/Walk01"].timed == (
        Timed("text", "A person walks."),
        Timed("text", "A hand goes up.", 0.5, 1.0),
    )
    assert clips["SSM_synced/20/run"].text is None


@pytest.mark.parametrize("rows", ["[1]", '{"1": {"path": "KIT/4/x"}}', '{"1": 3}', "{"])
def test_a_broken_annotations_file_is_named(rows: str, tmp_path: Path) -> None:
    root = folders.amass_folder(tmp_path / "AMASS")
    (root / "annotations.json").write_text(rows)
    with pytest.raises(FormatError, match=r"annotations\.json"):
        found("amass", root)


def test_babel_frames_sequences_transitions_and_extras(tmp_path: Path) -> None:
    clips = found("babel", folders.babel(tmp_path))
    assert set(clips) == {"CMU/01/01_01", "KIT/4/Walk01", "SSM_synced/20/run"}, "one motion is not there"
    first = clips["CMU/01/01_01"]
    assert first.timed == (
        Timed("action", "walk", 0.0, 1.0),
        Timed("transition", "transition", 1.0, 1.2),
        Timed("action", "wave left hand", 1.2, 2.0),
    )
    assert (first.label, first.split) == ("walk", "train")
    motion = CORPORA["babel"].read(first)
    assert [(s.start, s.end, s.kind) for s in motion.labels] == [
        (0, 20, "action"), (20, 24, "transition"), (24, 40, "action"),
    ]  # fmt: skip
    assert {item.value for item in clips["KIT/4/Walk01"].timed} == {"walk", "wave"}, "train.json comes before the extra"
    assert (clips["SSM_synced/20/run"].split, clips["SSM_synced/20/run"].timed) == ("test", ())


def test_babel_of_another_layout_is_named(tmp_path: Path) -> None:
    folders.babel(tmp_path)
    path = tmp_path / "babel_v1.0_release" / "train.json"
    path.write_text(json.dumps({"7": {"feat_p": "CMU/CMU/01/01_01_poses.npz", "frame_ann": {"labels": [{"a": 1}]}}}))
    assert found("babel", tmp_path)["CMU/01/01_01"].timed == (), "a label without a name says nothing"
    path.write_text(json.dumps({"7": {"feat_p": "CMU/CMU/01/01_01_poses.npz", "frame_ann": {"label": []}}}))
    with pytest.raises(FormatError, match="sequence '7' lacks"):
        found("babel", tmp_path)


def test_style_sets_tell_style_and_content_by_name(tmp_path: Path) -> None:
    folders.styles(tmp_path / "styles")
    aberman, xia = found("aberman-styles", tmp_path), found("xia-styles", tmp_path)
    assert {name: clip.style for name, clip in aberman.items()} == {
        "Angry_01": "angry", "FemaleModel_02": "female model",
    }  # fmt: skip
    assert {name: (c.style, c.label, c.action) for name, c in xia.items()} == {
        "old_13_000": ("old", "13", None), "proud_walk_001": ("proud", "walk", "walk"),
    }  # fmt: skip
    assert CORPORA["xia-styles"].read(xia["proud_walk_001"]).label_at(0, "style") == "proud"


def test_prepared_clips_keep_texts_labels_and_official_parts(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    folders.humanml3d(tmp_path / "data" / "HumanML3D")
    _, failures = datasets.prepare(tmp_path / "data", ["humanml3d"], workers=1)
    assert failures == []
    clips = {clip.name: clip for clip in datasets.load()}
    assert {name: clip.split for name, clip in clips.items()}["000001"] == "test"
    first = clips["000000"]
    assert first.sentences == ("a person waves with the left hand.",)
    (piece,) = first.pieces()
    assert (piece.text, len(piece.motion), piece.name) == ("he raises a hand", 20, "000000@10-30")
    np.testing.assert_array_equal(piece.motion.rotations, first.motion.rotations[10:30])
    mirrored = first.mirror()
    assert mirrored.sentences == clips["M000000"].sentences
    assert np.abs(mirrored.motion.positions - clips["M000000"].motion.positions).max() < 0.02


@pytest.mark.parametrize(
    ("joints", "says"),
    [
        (np.zeros((4, 22, 2)), "accepted"),
        (np.zeros((0, 22, 3)), "accepted"),
        (np.zeros((4, 22, 3)), "all joints lie in one point"),
        (np.full((4, 22, 3), np.nan), "frame 0 holds values that are not finite"),
    ],
)
def test_joints_that_are_no_body_are_refused(joints: np.ndarray, says: str) -> None:
    with pytest.raises(FormatError, match=says):
        from_joints(Path("x.npy"), joints, {role: i for i, role in enumerate(SMPL22.joints)}, 20.0)


def claims_more_than_it_holds() -> bytes:
    """The file of an array of half a million frames, cut after four."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (500_000, 22, 3)})
    return stream.getvalue() + bytes(4 * 22 * 3 * 8)


def saved(values: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, values, allow_pickle=True)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "the file is empty"),
        (b"no array at all", "is no .npy array"),
        (saved(np.zeros((4, 22, 3)))[:40], "is no .npy array"),
        (claims_more_than_it_holds(), "is no .npy array"),
        (saved(np.array([{"run": "code"}], dtype=object)), "is no .npy array"),
        (saved(np.zeros((4, 22, 3), dtype=np.int64)), "holds no floating point numbers"),
    ],
)
def test_a_damaged_array_is_told_and_never_unpickled(content: bytes, says: str, tmp_path: Path) -> None:
    path = tmp_path / "x.npy"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=says):
        load_npy(path)
    assert shape_of(path) in {(), (4, 22, 3)}


@pytest.mark.parametrize("axes", ["xyz", "-y down", "z up", "mirrored"])
def test_a_body_is_turned_upright_whatever_its_axes(axes: str) -> None:
    change = {
        "xyz": np.eye(3), "-y down": np.diag([1.0, -1.0, -1.0]), "mirrored": np.diag([-1.0, 1.0, 1.0]),
        "z up": np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]),
    }[axes]  # fmt: skip
    expected = folders.wave()
    roles = {role: i for i, role in enumerate(SMPL22.joints)}
    motion = from_joints(Path("x.npy"), expected.positions @ change.T, roles, 20.0, turned=True).face_front()
    start = expected.positions[:, 0, 1].mean() - motion.positions[:, 0, 1].mean()
    moved = motion.moved((0.0, float(start), 0.0))
    assert np.abs(moved.positions - expected.positions).max() < 0.03


@pytest.mark.golden
def test_golden_a_real_pair_of_humanml3d_faces_ahead_with_left_at_the_left(shared_dir: Path) -> None:
    """The one real HumanML3D clip at hand has its axes as this reader takes them."""
    with np.load(shared_dir / "golden" / "hml3d_features" / "public_012314.npz") as stored:
        joints = stored["joints"]
    motion = from_joints(Path("012314.npy"), joints, {role: i for i, role in enumerate(SMPL22.joints)}, 20.0)
    assert motion.heading[0] == pytest.approx(0, abs=0.25)
    toes = motion.positions[:, SMPL22.index("left_foot")] - motion.positions[:, SMPL22.index("left_ankle")]
    ahead = np.stack([np.sin(motion.heading), np.zeros(len(motion)), np.cos(motion.heading)], axis=-1)
    assert np.median((toes * ahead).sum(axis=-1)) > 0.05
