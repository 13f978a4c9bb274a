"""Learn the differences of one vehicle to the simulated one from logs of its flights."""
