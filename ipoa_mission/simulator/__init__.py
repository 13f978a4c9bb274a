"""The built-in autopilot: answers and flies as PX4 or as ArduPilot."""
