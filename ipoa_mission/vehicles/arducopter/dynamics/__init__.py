"""ArduCopter 4.x, for estimates and the built-in autopilot."""
