"""The released code's representations by name, beside ours and behind the same interface.

They are for the authors' checkpoints and prepared data, which speak these dialects; what each departs in from right
mathematics is listed in its module.
"""

from __future__ import annotations

from engines.features.codec import Codec
from engines.features.official_humanml3d import HUMANML3D, KIT
from engines.features.official_smplh import SMPLH_OFFICIAL
from engines.features.official_style import STYLE

CODECS: dict[str, Codec] = {"humanml3d": HUMANML3D, "kit": KIT, "style": STYLE, "smplh": SMPLH_OFFICIAL}
"""By the name of the representation of ours that they are a dialect of."""
