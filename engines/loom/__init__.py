"""Loom, our own engine: flow matching over whole motions, told by action, style, words and by what is already known."""
