"""Training: one loop for all engines."""
