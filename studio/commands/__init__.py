"""The commands of `motionloom`, one module each; `studio.cli` puts them together."""
