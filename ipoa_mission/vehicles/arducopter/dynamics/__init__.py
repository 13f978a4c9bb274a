"""ArduCopter 4.x: legs, guidance, control and body, shared by the estimate and the built-in autopilot."""
