"""The forecast of a mission's flight."""
