"""Missions and parameters that once told model and built-in autopilot apart."""

from collections.abc import Mapping

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Item, Mission, change_speed, land, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import Conditions
from tests.examples import some

HOME = Geodetic(39.101, 121.82, 20.0)


def place(east: float, north: float) -> Geodetic:
    latitude, longitude, _ = LocalFrame(HOME).to_geodetic([[east, north, 0.0]])  # type: ignore[arg-type]
    return Geodetic(float(latitude[0]), float(longitude[0]))


def to(east: float, north: float, height: float = 10.0) -> Item:
    return waypoint(place(east, north), height)


def headed(east: float, north: float, yaw_deg: float) -> Item:
    there = (place(east, north).latitude_deg, place(east, north).longitude_deg, 10.0)
    return Item(Command.NAV_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, (0.0, 0.0, 0.0, yaw_deg), *there)


OFF, HOMEWARD = (takeoff(HOME, 10.0), to(0, 0)), return_to_launch()
COPTER: Mapping[str, tuple[tuple[Item, ...], Mapping[str, float]]] = {
    "parameters by the names of 4.7": (
        (*OFF, to(0, 80), to(80, 80), HOMEWARD),
        {"WP_SPD": 5.0, "WP_ACC": 4.0, "WP_JERK": 6.0, "WP_SPD_DN": 2.5, "LAND_SPD_MS": 1.0, "RTL_ALT_M": 25.0},
    ),
    "RTL near home": ((*OFF, to(0, 40), to(0, 2), HOMEWARD), {"RTL_ALT_M": 50.0}),
    "RTL under a flatter cone": ((*OFF, to(0, 40), HOMEWARD), {"RTL_ALT_M": 50.0, "RTL_CONE_SLOPE": 0.7}),
    "a much lower speed from take-off on": ((*OFF, change_speed(2.8), to(0, 90), HOMEWARD), {"WPNAV_SPEED_UP": 200.0}),
    "a climb with a sharp end": (
        (*OFF, to(0, 40), HOMEWARD),
        {"RTL_ALT_M": 41.5, "WP_SPD_UP": 3.7, "WP_JERK": 7.5, "WP_ACC": 1.3},
    ),
}
PX4: Mapping[str, tuple[tuple[Item, ...], Mapping[str, float]]] = {
    "a descent faster than the fastest": (
        (*OFF, to(0, 40, 40.0), to(0, 60, 10.0), land(place(0, 60))),
        {"MPC_Z_V_AUTO_DN": 3.0, "MPC_LAND_SPEED": 1.4},
    ),
    "a wait over home": ((*OFF, to(0, 60), HOMEWARD), {"RTL_LAND_DELAY": 9.0, "MPC_LAND_CRWL": 0.2}),
    "a quick take-off": ((*OFF, to(0, 60), land(place(0, 60))), {"MPC_JERK_AUTO": 17.0, "MPC_TKO_SPEED": 2.5}),
    "turning over short legs": (
        (*OFF, headed(0, 20, 115.0), headed(0, 24, 300.0), headed(0, 28, 120.0), land(place(0, 28))), {},
    ),
    "the yaw first, then the way": ((*OFF, to(0, 60), to(60, 60), to(20, 0), HOMEWARD), {"MPC_YAW_MODE": 4.0}),
}  # fmt: skip
CASES = [*((Autopilot.ARDUPILOT, name) for name in COPTER), *some(3, [(Autopilot.PX4, name) for name in PX4])]


#: PX4's landings differ by a second and more.
SEEDS = {Autopilot.ARDUPILOT: range(1), Autopilot.PX4: range(4)}


def by_built_in(
    autopilot: Autopilot, items: tuple[Item, ...], parameters: Mapping[str, float], seed: int
) -> tuple[dict[int, float], float]:
    """When each item was done and when the motors stopped [s]."""
    flight = SimulatedFlight(autopilot, HOME, parameters, Conditions(seed=seed))
    flight.load(items)
    flight.arm()
    flight.start()
    while flight.armed:
        flight.advance(flight.time_s + 0.1)
        assert flight.time_s < 500.0, "the built-in autopilot does not get home"
    return {reached.index + 1: reached.time_s for reached in flight.reached}, flight.time_s


@pytest.mark.parametrize(("autopilot", "name"), CASES)
def test_other_missions_and_parameters_take_as_long_by_both_models(autopilot: Autopilot, name: str) -> None:
    items, parameters = (COPTER if autopilot is Autopilot.ARDUPILOT else PX4)[name]
    predicted = estimate(Mission(HOME, items, autopilot), parameters)
    flown, over = zip(*(by_built_in(autopilot, items, parameters, seed) for seed in SEEDS[autopilot]), strict=True)
    estimated = {item.seq: item.done_s for item in predicted.items}
    last, end = len(items) - 1, len(items)
    first, route, landing = np.mean(
        [(t[2], t[last] - t[2], ends - t[last]) for t, ends in zip(flown, over, strict=True)], axis=0
    )
    nearly = (0.005, 0.005, 0.005) if autopilot is Autopilot.ARDUPILOT else (0.08, 0.06, 0.1)
    assert estimated[2] == pytest.approx(first, rel=nearly[0])
    assert estimated[last] - estimated[2] == pytest.approx(route, rel=nearly[1])
    assert estimated[end] - estimated[last] == pytest.approx(landing, rel=nearly[2])


def test_px4_flies_at_its_own_speed_after_a_change_to_none() -> None:
    """A speed of DO_CHANGE_SPEED that is not above 0 resets it (Navigator::reset_cruising_speed)."""
    slow = (change_speed(2.0), change_speed(-1.0))
    changed, _ = by_built_in(Autopilot.PX4, (*OFF, *slow, to(0, 100), land(place(0, 100))), {}, 1)
    unchanged, _ = by_built_in(Autopilot.PX4, (*OFF, to(0, 100), land(place(0, 100))), {}, 1)
    assert changed[5] == pytest.approx(unchanged[3], abs=1.0)
