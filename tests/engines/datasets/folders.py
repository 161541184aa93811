"""Small folders in the papers' own layouts, made from one known walk."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from engines import features
from engines.datasets.kit_ml import KIT21
from engines.datasets.ntu_rgbd import VIBE18, VIBE49
from engines.formats import amass, bvh
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22


def wave(frames: int = 40, fps: float = 20.0, ahead: float = 0.05) -> Motion:
    """A person who walks along +Z with the left arm raised and bent, waving, the right hanging."""
    turns = np.tile(rotations.IDENTITY, (frames, len(SMPL22), 1))
    phase = np.arange(frames) / fps * 2 * np.pi

    def turn(joint: str, rotvec: np.ndarray) -> None:
        turns[:, SMPL22.index(joint)] = rotations.rotvec_to_quaternion(np.zeros((frames, 3)) + rotvec)

    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    turn("left_shoulder", z * (0.9 + 0.4 * np.sin(2 * phase))[:, None])
    turn("left_elbow", z * 0.6)
    turn("right_shoulder", z * 1.4)
    turn("left_hip", x * (0.4 * np.sin(phase))[:, None])
    turn("right_hip", x * (-0.4 * np.sin(phase))[:, None])
    path = np.zeros((frames, 3))
    path[:, 1] = 0.94
    path[:, 2] = ahead * np.arange(frames)
    return Motion(SMPL22, turns, path, fps)


def joints24(motion: Motion) -> np.ndarray:
    """(T, 24, 3): the house's joints and then the hands, as SMPL has them."""
    hands = [motion.positions[:, [SMPL22.index(f"{side}_wrist")]] for side in ("left", "right")]
    return np.concatenate([motion.positions, *hands], axis=1)


def placed(motion: Motion, joints: int, roles: dict[str, int], scale: float = 1.0) -> np.ndarray:
    """(T, joints, 3) with the motion's joints where another body has them; the others at the pelvis."""
    points = np.repeat(motion.positions[:, :1], joints, axis=1)
    for role, index in roles.items():
        points[:, index] = motion.positions[:, SMPL22.index(role)]
    return points * scale


def camera(points: np.ndarray) -> np.ndarray:
    """Points as a camera sees them: x right, y down, z away."""
    return points * np.array([1.0, -1.0, -1.0])


def humanml3d(root: Path) -> Path:
    for name in ("new_joints", "texts"):
        (root / name).mkdir(parents=True)
    for name, motion in {"000000": wave(), "M000000": wave().mirror(), "000001": wave(60), "000002": wave(24)}.items():
        np.save(root / "new_joints" / f"{name}.npy", motion.positions.astype(np.float32))
    say = "a person waves with the {side} hand.#a/DET person/NOUN wave/VERB#0.0#0.0\n"
    (root / "texts" / "000000.txt").write_text(
        say.format(side="left") + "he raises a hand#he/PRON raise/VERB a/DET hand/NOUN#0.5#1.5\n"
    )
    (root / "texts" / "M000000.txt").write_text(say.format(side="right"))
    (root / "texts" / "000001.txt").write_text("walks # on#walk/VERB#nan#nan\n\n")
    (root / "texts" / "000002.txt").write_text("")
    (root / "train.txt").write_text("000000\nM000000\n000009\n")
    (root / "val.txt").write_text("000002\n")
    (root / "test.txt").write_text("000001\n")
    return root


def vectors(root: Path, motion: Motion, codec: str) -> Path:
    """A folder that has features but no joints."""
    (root / "new_joint_vecs").mkdir(parents=True)
    (root / "texts").mkdir()
    np.save(root / "new_joint_vecs" / "000000.npy", features.get(codec).encode(motion))
    (root / "texts" / "000000.txt").write_text("a person waves.#a/DET person/NOUN wave/VERB#0.0#0.0\n")
    return root


def kit(root: Path) -> Path:
    (root / "new_joints").mkdir(parents=True)
    (root / "texts").mkdir()
    np.save(root / "new_joints" / "00001.npy", placed(wave(fps=12.5), 21, KIT21, scale=55.0))
    (root / "texts" / "00001.txt").write_text("A person walks.#a/DET person/NOUN walk/VERB#0.0#0.0\n")
    (root / "train.txt").write_text("00001\n")
    return root


def humanact12(root: Path) -> Path:
    root.mkdir(parents=True)
    for code in ("0101", "0502", "1201", "0607", "1301"):
        np.save(root / f"P03G01R02F0001T0040A{code}.npy", camera(joints24(wave())))
    return root


def ntu(root: Path) -> Path:
    root.mkdir(parents=True)
    motion = wave(fps=30.0, ahead=0.0)
    np.save(root / "S001C001P003R001A023.npy", camera(placed(motion, 18, VIBE18)))
    np.savez(root / "S001C001P003R002A023.npz", joints3d=camera(placed(motion, 49, VIBE49)))
    np.save(root / "S001C001P003R001A001.npy", np.zeros((5, 18, 3)))
    return root


def amass_folder(root: Path) -> Path:
    for name in ("CMU/01/01_01_poses", "KIT/4/Walk01_poses", "SSM_synced/20/run_stageii"):
        path = root / f"{name}.npz"
        path.parent.mkdir(parents=True)
        amass.write(wave(fps=20.0), path)
    np.savez(root / "CMU" / "01" / "shape.npz", betas=np.zeros(16))
    said = {"text": "A person  walks.", "start": 0.0, "end": 2.0, "seg_id": "00001_0"}
    part = {"text": "A hand goes up.", "start": 0.5, "end": 1.0, "seg_id": "00001_1"}
    rows = {"00001": {"path": "KIT/4/Walk01_poses", "duration": 2.0, "annotations": [said, part]}}
    (root / "annotations.json").write_text(json.dumps(rows))
    (root / "cmu-mocap-index.csv").write_text('"Title",,\n"01_01",forward jumps,"Subject #1"\n01_02,Unknown,\n')
    return root


def babel(root: Path) -> Path:
    amass_folder(root / "AMASS")

    def item(label: str, *times: float) -> dict:
        timed = dict(zip(("start_t", "end_t"), times, strict=True)) if times else {}
        return {
            "raw_label": label.upper(),
            "proc_label": label,
            "seg_id": "x",
            "act_cat": [label.split(maxsplit=1)[0]],
            **timed,
        }

    frames = {"labels": [item("wave left hand", 1.2, 2.0), item("walk", 0.0, 1.0), item("transition", 1.0, 1.2)]}
    train = {
        "1": {"babel_sid": 1, "feat_p": "CMU/CMU/01/01_01_poses.npz", "dur": 2.0,
              "seq_ann": {"labels": [item("walk")]}, "frame_ann": frames},
        "2": {"babel_sid": 2, "feat_p": "KIT/KIT/4/Walk01_poses.npz", "dur": 2.0,
              "seq_ann": {"labels": [item("walk"), item("wave")]}, "frame_ann": None},
        "3": {"babel_sid": 3, "feat_p": "KIT/KIT/4/NotHere_poses.npz", "dur": 2.0, "seq_ann": None},
    }  # fmt: skip
    test = {"4": {"babel_sid": 4, "feat_p": "SSM_synced/SSM_synced/20/run_poses.npz", "dur": 2.0}}
    extra = {"5": {**train["2"], "seq_ann": None, "frame_ann": None, "seq_anns": [{"labels": [item("hop")]}]}}
    (root / "babel_v1.0_release").mkdir()
    for name, rows in {"train": train, "test": test, "extra_train": extra}.items():
        (root / "babel_v1.0_release" / f"{name}.json").write_text(json.dumps(rows))
    return root


def styles(root: Path) -> Path:
    root.mkdir(parents=True)
    for name in ("Angry_01", "FemaleModel_02", "old_13_000", "proud_walk_001", "walk_01", "old_13_a"):
        bvh.write(wave(), root / f"{name}.bvh")
    return root
