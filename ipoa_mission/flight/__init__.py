"""Plan and fly a scenario's mission."""
