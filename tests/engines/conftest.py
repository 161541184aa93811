"""Real clips that the engine tests share: a few members of each archive, laid out as in the archives."""

from __future__ import annotations

import json
import tarfile
from pathlib import Path

import pytest

_BANDAI = "dataset/Bandai-Namco-Research-Motiondataset-{}/data/dataset-{}_{}.bvh"
_WANTED = {
    "cmu-mocap-subset.tar.xz": ("cmu/bvh/26_01.bvh", "cmu/bvh/09_12.bvh", "cmu/bvh/06_04.bvh"),
    "bandai-namco-motiondataset.tar.xz": (
        _BANDAI.format(1, 1, "walk_normal_001"),
        _BANDAI.format(2, 2, "raise-up-left-hand_normal_002"),
        _BANDAI.format(2, 2, "walk-turn-left_active_041"),
    ),
    "utd-mhad-skeletons.tar.xz": tuple(
        f"utd/{name}_skeleton.mat" for name in ("a3_s1_t3", "a27_s4_t3", "a16_s6_t2", "a3_s7_t3")
    ),
}
CMU_ROWS = (
    # as in the subset's own manifest.json, the keys that are read
    {"clip": "26_01", "file": "bvh/26_01.bvh", "description": "walk"},
    {"clip": "09_12", "file": "bvh/09_12.bvh", "description": "navigate - walk forward, backward, sideways"},
    {"clip": "06_04", "file": "bvh/06_04.bvh", "description": "basketball - forward dribble"},
)


@pytest.fixture(scope="session")
def real_clips(shared_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `cmu/` (3 BVH and a manifest), `dataset/` (3 Bandai-Namco BVH) and `utd/` (4 MATLAB files)."""
    folder = tmp_path_factory.mktemp("clips")
    for archive, names in _WANTED.items():
        left = set(names)
        with tarfile.open(shared_dir / "data" / archive) as tar:
            for member in tar:
                if member.name in left:
                    tar.extract(member, folder, filter="data")
                    left.remove(member.name)
                    if not left:
                        break
        assert not left
    rows = [{**row, "cmu_fps": 120.0, "first_frame_is_tpose": True} for row in CMU_ROWS]
    (folder / "cmu" / "manifest.json").write_text(json.dumps(rows), encoding="utf-8")
    return folder


@pytest.fixture(scope="session")
def bandai_folder(real_clips: Path) -> Path:
    return real_clips / "dataset"
