import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import takeoff, waypoint
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import FlightMode

HOME = Geodetic(47.4, 8.5, 400.0)
MODES = {Contingency.LAND: FlightMode.LAND, Contingency.HOLD: FlightMode.HOLD, Contingency.RTL: FlightMode.RETURN}
STOPS_WITHIN = 0.5  # sensor noise moves it [m]
AFTER_RTL = (-1.1, 4.1)  # of the distance that the forecast counts, as real flights [m]
PARAMETERS = [{}, {"MPC_XY_CRUISE": 9.0}, {"MPC_ACC_HOR": 2.0, "MPC_JERK_AUTO": 8.0}]


@pytest.mark.parametrize("parameters", PARAMETERS, ids=str)
@pytest.mark.parametrize("contingency", MODES)
def test_built_in_px4_stops_where_the_forecast_says(contingency: Contingency, parameters: dict[str, float]) -> None:
    far = LocalFrame(HOME).geodetic(np.array([300.0, 0.0, 0.0]))
    flight = SimulatedFlight(Autopilot.PX4, HOME, parameters)
    flight.load((takeoff(HOME, 20.0), waypoint(far, 20.0)))
    flight.arm()
    flight.start()
    while flight.place[0] < 100.0:
        flight.advance(flight.time_s + 0.1)
    ordered = np.array(flight.place[:2])
    velocity = np.array([*flight.motion[:2], 0.0])
    until = flight.time_s + 30.0
    displace = Autopilot.PX4.stopping_displacement
    offsets = {each: displace(parameters, velocity[None], np.zeros((1, 3)), each)[0, :2] for each in MODES}
    flight.enter(MODES[contingency])
    track = [ordered]
    while flight.armed and flight.time_s < until:
        flight.advance(flight.time_s + 0.1)
        track.append(np.array(flight.place[:2]))
    farthest = max(place[0] - ordered[0] for place in track)
    if contingency is Contingency.RTL:
        counted = float(offsets[contingency][0] + Autopilot.PX4.guidance.brakes_after * velocity[0])
        assert AFTER_RTL[0] <= counted - farthest <= AFTER_RTL[1]
    else:
        assert track[-1] - ordered == pytest.approx(offsets[Contingency.LAND], abs=STOPS_WITHIN)
        assert farthest <= offsets[Contingency.HOLD][0] + STOPS_WITHIN  # it comes back
