"""Pure maths of bodies in motion: NumPy (and torch where gradients are needed), no files, no networks."""
