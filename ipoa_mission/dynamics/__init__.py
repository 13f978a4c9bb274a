"""How vehicles move under their autopilots: one model of each, for the estimate and for the built-in autopilot."""
