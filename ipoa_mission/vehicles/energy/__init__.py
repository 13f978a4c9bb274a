"""Energy consumption of a flight, and the battery check."""
