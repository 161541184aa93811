"""A motion on a body with bones of its own: the same pose on other bones, feet where they were on the floor."""

from __future__ import annotations

import numpy as np

from engines.geometry import rotations
from engines.motion import Motion
from viewers.bodies.body import Body


def seated(motion: Motion, body: Body, sole: float) -> Motion:
    """The motion as a body with bones of its own plays it.

    Joint for joint the rotations stay (that is how SMPL's bodies share motions), and to a body of other joints they are
    retargeted; the root's way is scaled by the length of the legs, and its height set so that what stood on the floor
    still does.

    Args:
        motion: on a skeleton of the same joints, or one whose joints' roles are those of the body's.
        body: the body.
        sole: how far the lowest joint of the motion's own rest pose is above its sole, metres.

    Raises:
        SkeletonError: the body's joints are others, and play no known roles.
    """
    if motion.skeleton.joints != body.skeleton.joints:
        return _retargeted(motion, body, sole)
    old, new = motion.skeleton, body.skeleton
    reach = [float(-np.min(skeleton.rest_positions[:, 1] - skeleton.offsets[0, 1])) for skeleton in (old, new)]
    ratio = reach[1] / reach[0] if min(reach) > 1e-6 else 1.0
    lowest = float(new.rest_positions[:, 1].min())
    under = lowest - float(body.vertices[:, 1].min()) if len(body.vertices) else sole
    place = motion.translation + old.offsets[0]
    place = place * [ratio, 1.0, ratio]
    place[:, 1] = (place[:, 1] - sole) * ratio + under
    return motion.replaced(skeleton=new, translation=place - new.offsets[0])


def _retargeted(motion: Motion, body: Body, sole: float) -> Motion:
    rest = motion.skeleton
    still = motion[:1].replaced(
        rotations=np.tile(rotations.IDENTITY, (1, len(rest), 1)),
        translation=np.array([[0.0, sole - float(rest.rest_positions[:, 1].min()), 0.0]]),  # on the floor
    )
    under = float(body.posed(still.retarget(body.skeleton))[:, 1].min()) if len(body.vertices) else 0.0
    return motion.retarget(body.skeleton).moved((0.0, -under, 0.0))
