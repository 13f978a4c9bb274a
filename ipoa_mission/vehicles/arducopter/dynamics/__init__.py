"""ArduCopter 4.x: legs, guidance, control and body, the same lines for the estimate and for the built-in autopilot."""
