"""The built-in autopilot, which flies as PX4 or as ArduPilot."""
