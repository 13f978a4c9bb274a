"""The main job as one call: a scenario becomes a mission that was planned, proved, checked and timed."""

from ipoa_mission.flight.flight import Flight, plan_flight

__all__ = ["Flight", "plan_flight"]
