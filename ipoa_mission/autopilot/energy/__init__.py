"""Energy of a flight, and the battery check."""
