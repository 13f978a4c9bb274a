import math

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.checks.check import check_mission
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.copter_curves import circle_entry, circle_radius, circle_turn
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Place
from ipoa_mission.mission.item_words import details_of
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.report.exports import forecast_text
from ipoa_mission.vehicles.arducopter.braking import flown_circle
from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter
from ipoa_mission.vehicles.arducopter.limits import copter_limits
from tests.examples import examples
from tests.refused import refuses

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)


def at(east: float, north: float) -> Geodetic:
    return FRAME.geodetic(np.array([east, north, 0.0]))


def circle(turns: float, radius: float, east: float = 40.0, north: float = 110.0, height: float = 20.0) -> Item:
    place, params = at(east, north), (turns, 0.0, radius, 0.0)
    where = place.latitude_deg, place.longitude_deg, height
    return Item(Command.NAV_LOITER_TURNS, Frame.GLOBAL_RELATIVE_ALT, params, *where)


def test_a_circle_without_a_turn_rate_is_refused() -> None:
    still = forecast(circle(2.0, 20.0)).mission_as_read.with_parameters({"CIRCLE_RATE": 0.0})
    for question in (lambda: check_mission(still), lambda: Forecast(still).estimate):
        with refuses("bad-input", "CIRCLE_RATE"):
            question()


def forecast(item: Item) -> Forecast:
    items = (takeoff(HOME, 20.0), waypoint(at(0, 30), 20.0), item, waypoint(at(-40, 60), 20.0), return_to_launch())
    return Forecast(Mission(HOME, items, Autopilot.ARDUPILOT))


@pytest.mark.parametrize(
    ("turns", "radius", "kept_turns", "kept_radius"),
    [
        (2.0, 60.7, 2.0, 60.0),
        (1.5, 15.0, 1.0, 15.0),  # whole turns from one on
        (0.3, -15.0, -76 / 256, 15.0),
        (1.0, 300.0, 1.0, 300.0),
        (1.0, 307.0, 1.0, 300.0),  # tens of meters above 255
        (1.0, 9000.0, 1.0, 2550.0),
        (300.0, 10.0, 255.0, 10.0),
        (0.0, 10.0, 0.0, 10.0),
    ],
)
def test_the_board_keeps_a_circle_as_its_source_has_it(
    turns: float, radius: float, kept_turns: float, kept_radius: float
) -> None:
    item = circle(turns, radius)
    assert circle_turn(item) == pytest.approx(math.tau * kept_turns)
    assert circle_radius(item) == kept_radius


def test_a_circle_is_entered_at_its_nearest_point_or_behind_the_vehicle() -> None:
    edge, apart = circle_entry((0.0, 0.0, 20.0), (30.0, 40.0, 20.0), 20.0, 0.0)
    assert np.allclose(edge, (18.0, 24.0, 20.0))
    assert apart == pytest.approx(30.0)
    edge, apart = circle_entry((0.1, 0.0, 20.0), (0.0, 0.0, 20.0), 20.0, math.radians(90.0))
    assert np.allclose(edge, (-20.0, 0.0, 20.0))


@settings(max_examples=examples(10))
@given(radius=st.floats(5.0, 300.0), accel=st.floats(100.0, 500.0), speed=st.floats(2.0, 15.0), turns=st.just(2.0))
@example(radius=20.0, accel=500.0, speed=3.4, turns=1.0)  # the speed limit cuts the pursuit
@example(radius=20.0, accel=500.0, speed=3.4, turns=8.0)
def test_the_circle_of_the_law_is_the_one_that_the_target_is_on(
    radius: float, accel: float, speed: float, turns: float
) -> None:
    limits, turn = copter_limits({"WPNAV_ACCEL": accel, "WPNAV_SPEED": 100.0 * speed}), math.tau * turns
    flown, copter = flown_circle(limits, radius, speed, turn), Copter(limits)
    copter.start_at((0.0, radius, 20.0))
    copter.orbit((0.0, 0.0, 20.0), radius, turn)
    copter.run()
    state = copter.state
    behind = (state.turned - math.atan2(state.target.real, state.target.imag)) % math.tau
    assert abs(state.target) == pytest.approx(flown.radius, abs=0.1)
    assert behind == pytest.approx(flown.behind, abs=0.02)


@pytest.mark.parametrize(("turns", "radius"), [(1.0, 60.0), (2.0, -20.0), (0.5, 15.0)])
def test_the_leg_of_a_circle_lies_where_it_is_flown(turns: float, radius: float) -> None:
    flight = forecast(circle(turns, radius))
    legs = np.vstack([leg.points for leg in flight.legs])
    track = flight.predicted(noise_free=True).track
    aside = shapely.distance(shapely.points(track.points[:, :2]), shapely.LineString(legs[:, :2]))
    assert aside.max() < 2.0  # where it begins to turn, and where it stops
    assert np.quantile(aside, 0.9) < 0.7


@pytest.mark.parametrize("suffix", [".kml", ".geojson", ".gpx"])
def test_a_circle_is_drawn_in_every_export(suffix: str) -> None:
    text = forecast_text(forecast(circle(1.0, 60.0)), suffix, "orbit")
    far = FRAME.geodetic(np.array([40.0 + 58.0, 110.0, 0.0]))  # the east of the circle
    assert f"{far.longitude_deg:.4f}"[:-1] in text


def test_the_words_name_radius_and_sense() -> None:
    assert details_of(circle(2.0, -60.0)) == "2 turns, radius 60 m, counterclockwise"
    assert details_of(circle(1.0, 60.0)) == "1 turn, radius 60 m"


def test_the_way_past_a_church_by_a_circle_is_no_longer_clear() -> None:
    """The circle leads through the church; it was checked as its center."""
    legs = [leg for leg in forecast(circle(1.0, 60.0)).legs if leg.seq == 3]
    center: Place = (40.0, 110.0, 20.0)
    distances = np.hypot(*(legs[-1].points[:-1, :2] - center[:2]).T)
    assert distances.max() <= 60.001
    assert distances.min() > 57.0
