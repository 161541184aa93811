"""MultiAct: one action after another, with the transitions between them (Lee et al. 2023)."""
