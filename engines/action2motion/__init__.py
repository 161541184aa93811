"""Action2Motion: motions from an action label (Guo et al. 2020; thesis chapter 3)."""
