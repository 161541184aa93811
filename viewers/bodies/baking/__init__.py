"""Steps of the bake that makes the default body; nothing here is needed to show it."""
