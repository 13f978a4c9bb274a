import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.itinerary.flown_legs import flown_legs
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Return
from tests.recorded_flights import Recorded, read_flights

RETURNING = [f for f in read_flights(Autopilot.PX4) if f.mission.items[-1].command == Command.NAV_RETURN_TO_LAUNCH]
HOME_JUMPS = 2.0  # [m] error of PX4's home height at the decision
HOME = Geodetic(47.4, 8.5, 400.0)


@pytest.mark.parametrize("flight", RETURNING, ids=lambda flight: flight.name)
def test_a_recorded_flight_came_home_as_high_as_the_law_says(flight: Recorded) -> None:
    trace = flight.trace[flight.trace[:, 0] > flight.runs[0][flight.last]]
    frame = LocalFrame(flight.mission.home)
    distance = np.hypot(*frame.to_local(trace[:, 1], trace[:, 2], flight.mission.home.altitude).T[:2])
    coming = trace[np.flatnonzero(distance < 0.5 * distance[0])[0]]
    parameters = flight.mission.with_parameters(flight.parameters).complete_parameters
    law = Px4Return.of(parameters).height(trace[0, 3], distance[0])
    assert coming[3] == pytest.approx(law, abs=HOME_JUMPS)


@pytest.mark.parametrize(
    ("parameters", "top"), [({}, 30.0), ({"RTL_RETURN_ALT": 24.0}, 24.0), ({"RTL_RETURN_ALT": 60.0}, 60.0)]
)
def test_checks_estimate_and_built_in_autopilot_return_equally_high(parameters: dict[str, float], top: float) -> None:
    frame = LocalFrame(HOME)
    items = (takeoff(HOME, 20.0), waypoint(frame.geodetic(np.array([60.0, 0.0, 0.0])), 20.0), return_to_launch())
    mission = Mission(HOME, items, Autopilot.PX4, 5.0, parameters=parameters)
    checked = [leg.points[:, 2].max() for leg in flown_legs(mission, frame)]
    usual = next(leg for leg in flown_legs(mission, frame) if leg.stage is FlightStage.RETURN)
    assert usual.points[:, 2].max() == pytest.approx(top, abs=0.01)
    assert max(checked) == pytest.approx(top, abs=0.01)
    assert estimate(mission).track.points[:, 2].max() == pytest.approx(top, abs=1.0)
    flight = SimulatedFlight(Autopilot.PX4, HOME, parameters)
    flight.load(items)
    flight.arm()
    flight.start()
    highest = 0.0
    while flight.armed:
        flight.advance(flight.time_s + 0.5)
        highest = max(highest, flight.place[2])
    assert highest == pytest.approx(top, abs=HOME_JUMPS)
