"""How long a mission takes on each autopilot, offline."""
