"""The prior of poses."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal

from engines.character import prior as priors
from engines.character.prior import PosePrior
from engines.datasets import Clip
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22


def test_the_energy_is_that_of_the_mixture() -> None:
    random = np.random.default_rng(0)
    means, roots = random.normal(size=(3, 6)), random.normal(size=(3, 6, 6))
    covariances = roots @ roots.swapaxes(1, 2) + np.eye(6)
    weights = np.array([0.2, 0.5, 0.3])
    whitening = np.linalg.inv(np.linalg.cholesky(covariances)).swapaxes(1, 2)
    prior = PosePrior(*(torch.from_numpy(array) for array in (weights, means, whitening)))
    poses = random.normal(size=(20, 3, 3))
    ours = [float(prior.energy(torch.from_numpy(pose))) for pose in poses]
    terms = zip(weights, means, covariances, strict=True)
    density = sum(w * multivariate_normal(m, c).pdf(poses[:, 1:].reshape(20, 6)) for w, m, c in terms)
    assert np.ptp(np.array(ours) + np.log(density)) < 1e-9  # the same but for a constant
    assert prior.usual[1:].flatten().numpy() == pytest.approx(weights @ means)


def test_knees_and_elbows_bend_one_way() -> None:
    prior = priors.load()
    for joint, axis in SMPL22.hinges.items():
        bent = {}
        for degrees in (-60.0, 40.0):
            pose = prior.usual.clone()
            pose[SMPL22.index(joint)] = torch.from_numpy(np.deg2rad(degrees) * axis)
            bent[degrees] = float(prior.energy(pose))
        assert bent[-60.0] > bent[40.0] + 5, joint


def test_a_mixture_is_learned_of_clips_and_their_mirror_images() -> None:
    random = np.random.default_rng(1)
    turns = 0.3 * random.normal(size=(16, 22, 3)) + (0.2, 0.0, 0.1)
    motion = Motion(SMPL22, rotations.rotvec_to_quaternion(turns), np.zeros((16, 3)), 20.0)
    clip = Clip("made up", "one", None, None, None, None, "train", motion)
    arrays = priors.learned([clip], components=1)
    both = np.concatenate([rotations.quaternion_to_rotvec(m.rotations[:, 1:]) for m in (motion, motion.mirror())])
    assert arrays["means"][0] == pytest.approx(both.reshape(32, -1).mean(0), abs=1e-5)
    assert arrays["factors"].shape == (1, 63, 63) and arrays["weights"] == pytest.approx([1.0])
