"""The world: where things are, and how far away they are."""
