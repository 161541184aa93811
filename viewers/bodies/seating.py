"""A motion on another body of the same joints: the same rotations on other bones, feet where they were on the floor."""

from __future__ import annotations

import numpy as np

from engines.motion import Motion
from viewers.bodies.body import Body


def seated(motion: Motion, body: Body, sole: float) -> Motion:
    """The motion as a body with bones of its own plays it.

    Joint for joint the rotations stay (that is how SMPL's bodies share motions); the root's way is scaled by the
    length of the legs, and its height set so that what stood on the floor still does.

    Args:
        motion: on a skeleton of the same joints.
        body: the body.
        sole: how far the lowest joint of the motion's own rest pose is above its sole, metres.
    """
    old, new = motion.skeleton, body.skeleton
    reach = [float(-np.min(skeleton.rest_positions[:, 1] - skeleton.offsets[0, 1])) for skeleton in (old, new)]
    ratio = reach[1] / reach[0] if min(reach) > 1e-6 else 1.0
    lowest = float(new.rest_positions[:, 1].min())
    under = lowest - float(body.vertices[:, 1].min()) if len(body.vertices) else sole
    place = motion.translation + old.offsets[0]
    place = place * [ratio, 1.0, ratio]
    place[:, 1] = (place[:, 1] - sole) * ratio + under
    return motion.replaced(skeleton=new, translation=place - new.offsets[0])
