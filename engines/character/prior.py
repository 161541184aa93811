"""How likely a pose is: a mixture of Gaussians over the joints' rotations, learned from our own clips (eq. 3.16).

To learn it again from the prepared clips: `python -m engines.character.prior`.
"""

from __future__ import annotations

import io
import logging
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from engines.datasets import Clip
from engines.errors import MissingDependencyError
from engines.geometry import rotations
from engines.motion import Motion
from engines.training.files import write_beside

log = logging.getLogger(__name__)

FILE = Path(__file__).with_name("pose_prior.npz")
COMPONENTS = 8
"""Gaussians of the shipped mixture, as many as SMPLify's."""
FRAMES = 16
"""Frames taken of a clip, evenly: a long clip is not many more poses than a short one."""
LEAST_DEVIATION = 0.06
"""Radians a joint may always deviate by: clips leave some joints still, people do not."""


@dataclass(frozen=True, eq=False)
class PosePrior:
    """A mixture of K Gaussians over the rotation vectors of all joints but the root, D = 3 (J - 1) numbers."""

    weights: Float[Tensor, " K"]
    """(K,) shares, summing to one."""
    means: Float[Tensor, "K D"]
    """(K, D) radians."""
    whitening: Float[Tensor, "K D D"]
    """(K, D, D) W with W W^T the inverse covariance: `(pose - mean) @ W` is white."""

    def energy(self, pose: Float[Tensor, "J 3"]) -> Float[Tensor, ""]:
        """How unlikely a pose is: minus log of the mixture (thesis eq. 3.16), about 0 where it is highest.

        Args:
            pose: (J, 3) rotation vectors against the parent, radians; the root's does not count.
        """
        white = torch.einsum("kd,kde->ke", pose[1:].reshape(-1) - self.means, self.whitening)
        heights = self._heights
        return -torch.logsumexp(heights - 0.5 * white.square().sum(1), dim=0) + heights.max()

    @property
    def _heights(self) -> Tensor:
        """(K,) log of each Gaussian's share times its density at its mean, the constant of all left out."""
        return self.weights.log() + torch.linalg.slogdet(self.whitening)[1]

    @property
    def usual(self) -> Float[Tensor, "J 3"]:
        """(J, 3) the mean of all poses, root at rest: where a fit begins."""
        mean = torch.einsum("k,kd->d", self.weights, self.means).unflatten(0, (-1, 3))
        return torch.cat([torch.zeros_like(mean[:1]), mean])


@lru_cache(maxsize=1)
def load() -> PosePrior:
    """The shipped prior, float64."""
    with np.load(FILE, allow_pickle=False) as stored:
        weights, means, factors = (stored[key].astype(np.float64) for key in ("weights", "means", "factors"))
    return PosePrior(*(torch.from_numpy(array) for array in (weights, means, np.linalg.inv(factors).swapaxes(1, 2))))


def learned(clips: Sequence[Clip], components: int = COMPONENTS, seed: int = 0) -> dict[str, np.ndarray]:
    """Fit the mixture to poses of clips on the house skeleton and to their mirror images.

    Args:
        clips: of the training part.
        components: Gaussians.
        seed: of the start.

    Returns:
        weights (K,), means (K, D) and factors (K, D, D), the lower Cholesky factors of the covariances; float32.

    Raises:
        MissingDependencyError: scikit-learn is not here.
    """
    try:
        from sklearn.mixture import GaussianMixture
    except ImportError as error:
        raise MissingDependencyError("scikit-learn", "reports", "learning the pose prior") from error
    poses = np.concatenate([_poses(side.motion) for clip in clips for side in (clip, clip.mirror())])
    mixture = GaussianMixture(components, reg_covar=LEAST_DEVIATION**2, random_state=seed).fit(poses)
    arrays = {
        "weights": mixture.weights_,
        "means": mixture.means_,
        "factors": np.linalg.cholesky(np.asarray(mixture.covariances_)),
    }
    log.info("%d poses, mean log likelihood %.1f", len(poses), mixture.score(poses))
    return {name: array.astype(np.float32) for name, array in arrays.items()}


def _poses(motion: Motion) -> np.ndarray:
    """(n, D) rotation vectors of some frames, evenly."""
    frames = np.unique(np.linspace(0, len(motion) - 1, FRAMES).round().astype(int))
    return rotations.quaternion_to_rotvec(motion.rotations[frames, 1:]).reshape(len(frames), -1)


def main() -> None:
    """Learn the prior from the prepared training clips and write it."""
    from engines import datasets

    clips = datasets.load("train")
    with io.BytesIO() as content:
        np.savez_compressed(content, **learned(clips))  # pyright: ignore[reportArgumentType]
        write_beside(FILE, content.getvalue())
    log.info("wrote %s", FILE)


if __name__ == "__main__":
    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format="%(message)s")
    main()
