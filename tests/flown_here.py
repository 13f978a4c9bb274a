"""Fly recorded missions on the built-in autopilot."""

from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import Conditions
from tests.recorded_flights import Recorded


def fly_here(flight: Recorded, seed: int) -> tuple[dict[int, float], float]:
    """Return the time at which each item was first done, by number, and motors stopped [s]."""
    mission = flight.mission
    conditions = Conditions(version=mission.firmware_version, seed=seed)
    here = SimulatedFlight(mission.autopilot, mission.home, flight.parameters, conditions)
    here.load(mission.items)
    here.arm()
    here.start()
    while here.armed:
        here.advance(here.time_s + 1.0)
        assert here.time_s < 2.0 * flight.end_s, flight.name
    return {reached.index + 1: reached.time_s for reached in reversed(here.reached)}, here.time_s
