"""The flight of a mission as it is expected, worked out once and handed on."""
