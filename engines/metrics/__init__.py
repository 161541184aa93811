"""How good motions are."""
