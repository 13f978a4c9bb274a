"""Fly on simulators of real autopilots, and trim their logs."""
