import math

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.messages import MissionState
from ipoa_mission.mission.items import Item, change_speed, land, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.simulated_flight import SimulatedFlight

HOME = Geodetic(39.101, 121.82, 20.0)
both = pytest.mark.parametrize("autopilot", list(registered()))


def place(east: float, north: float) -> Geodetic:
    latitude, longitude, _ = LocalFrame(HOME).to_geodetic([[east, north, 0.0]])  # type: ignore[arg-type]
    return Geodetic(float(latitude[0]), float(longitude[0]))


def fly(flight: SimulatedFlight, until_s: float = 400.0) -> None:
    while flight.armed and flight.time_s < until_s:
        flight.advance(flight.time_s + 0.5)


MISSION = (
    takeoff(HOME, 20.0),
    change_speed(6.0),
    waypoint(place(30.0, 0.0), 20.0),
    waypoint(place(30.0, 40.0), 25.0),
    return_to_launch(),
)


@both
def test_a_mission_is_flown_item_by_item_and_ends_disarmed_at_home(autopilot: Autopilot) -> None:
    flight = SimulatedFlight(autopilot, HOME, {})
    flight.load(MISSION)
    assert flight.mission is MissionState.NOT_STARTED
    flight.arm()
    flight.start()
    fly(flight)
    assert [r.index for r in flight.reached] == list(range(len(MISSION)))
    assert not flight.armed
    assert flight.on_ground
    assert math.hypot(*flight.place[:2]) < 1.0
    assert flight.mission is MissionState.COMPLETE


@both
def test_a_value_of_0_that_must_be_above_0_is_ignored(autopilot: Autopilot) -> None:
    table = autopilot.parameter_table
    flight = SimulatedFlight(autopilot, HOME, {**table.moving, table.by_meaning["cruise speed"].name: 0.0})
    flight.arm()
    assert flight.armed


@both
def test_a_disarmed_vehicle_stays_on_the_ground(autopilot: Autopilot) -> None:
    flight = SimulatedFlight(autopilot, HOME, {})
    flight.load(MISSION)
    flight.start()
    flight.advance(30.0)
    assert flight.on_ground
    assert flight.place[2] == pytest.approx(0.0, abs=0.01)


@both
def test_a_hold_lasts_as_long_as_asked(autopilot: Autopilot) -> None:
    def flown(hold_s: float) -> float:
        flight = SimulatedFlight(autopilot, HOME, {})
        flight.load((takeoff(HOME, 10.0), waypoint(place(20.0, 0.0), 10.0, hold_s), land(place(20.0, 0.0))))
        flight.arm()
        flight.start()
        fly(flight)
        return next(r.time_s for r in flight.reached if r.index == 1)

    assert flown(9.0) - flown(4.0) == pytest.approx(5.0, abs=0.1)


@both
def test_a_jump_repeats_its_legs_as_often_as_it_says(autopilot: Autopilot) -> None:
    target = 1 if autopilot is Autopilot.PX4 else 2
    jump = Item(Command.DO_JUMP, Frame.MISSION, (target, 2, 0, 0))
    flight = SimulatedFlight(autopilot, HOME, {})
    flight.load((takeoff(HOME, 10.0), waypoint(place(15.0, 0.0), 10.0), waypoint(HOME, 10.0), jump, return_to_launch()))
    flight.arm()
    flight.start()
    fly(flight)
    assert [r.index for r in flight.reached].count(1) == 3


@both
def test_start_at_a_waypoint_takes_off_on_px4_only(autopilot: Autopilot) -> None:
    flight = SimulatedFlight(autopilot, HOME, {})
    flight.load(MISSION)
    flight.set_current(2)
    flight.arm()
    flight.start()
    flight.advance(40.0)
    assert flight.on_ground == (autopilot is Autopilot.ARDUPILOT)
    assert [r.index for r in flight.reached][:1] == ([] if flight.on_ground else [2])
