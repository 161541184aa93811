"""Motions and files that the format tests share."""

from __future__ import annotations

import tarfile
from pathlib import Path

import numpy as np
import pytest

from engines.motion import Motion
from engines.skeletons import SMPL22

SMALL_BVH = """HIERARCHY
ROOT Hips
{
	OFFSET 0 0 0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
	JOINT Spine
	{
		OFFSET 0 10 0
		CHANNELS 3 Zrotation Xrotation Yrotation
		JOINT Head
		{
			OFFSET 0 20 1
			CHANNELS 3 Yrotation Xrotation Zrotation
			End Site
			{
				OFFSET 0 5 0
			}
		}
	}
	JOINT LeftArm
	{
		OFFSET 15 8 0
		CHANNELS 3 Zrotation Xrotation Yrotation
		End Site
		{
			OFFSET 20 0 0
		}
	}
}
MOTION
Frames: 3
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0 0 0 0 0 0 0
1 91 2 10 20 30 5 0 0 40 50 60 0 0 90
2 92 4 20 40 60 5 10 0 80 10 12 0 90 0
"""


def random_motion(frames: int = 7, seed: int = 0, skeleton=SMPL22, fps: float = 30.0) -> Motion:
    """A motion of random rotations and a random path."""
    rng = np.random.default_rng(seed)
    return Motion(skeleton, rng.normal(size=(frames, len(skeleton), 4)), rng.normal(size=(frames, 3)), fps)


@pytest.fixture
def motion() -> Motion:
    return random_motion()


@pytest.fixture
def small_bvh(tmp_path: Path) -> Path:
    path = tmp_path / "small.bvh"
    path.write_text(SMALL_BVH)
    return path


_WANTED = {
    "cmu-mocap-subset.tar.xz": {"cmu": ("cmu/bvh/", ".bvh"), "cgspeed": ("cmu/bvh43/", ".bvh")},
    "bandai-namco-motiondataset.tar.xz": {"bandai": ("dataset/", ".bvh")},
    "utd-mhad-skeletons.tar.xz": {"utd": ("utd/a1_", ".mat")},
}


@pytest.fixture(scope="session")
def real_files(shared_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One real file of each kind, unpacked: "cmu", "cgspeed" and "bandai" BVH, "utd" MATLAB (action 1)."""
    folder = tmp_path_factory.mktemp("real")
    found: dict[str, Path] = {}
    for archive, wanted in _WANTED.items():
        with tarfile.open(shared_dir / "data" / archive) as tar:
            for member in tar:
                for name, (start, end) in wanted.items():
                    if name not in found and member.name.startswith(start) and member.name.endswith(end):
                        tar.extract(member, folder, filter="data")
                        found[name] = folder / member.name
                if all(name in found for name in wanted):
                    break
    assert set(found) == {name for wanted in _WANTED.values() for name in wanted}
    return found
