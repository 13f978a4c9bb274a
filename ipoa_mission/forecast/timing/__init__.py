"""Predict the time of a mission on each autopilot, offline."""
