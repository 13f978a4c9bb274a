from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.commands import Frame, plain_frame
from ipoa_mission.centimeters import ceil_cm, falls_short, floor_cm
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.geometry import Points
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.landing_ground import landing_height, landing_on
from ipoa_mission.planning.proof import Check
from ipoa_mission.scenario import Scenario


def landed_elsewhere(forecast: Forecast, record: FlightRecord) -> tuple[str, ...]:
    """Report a landing on other ground than expected, and its estimated time [s]."""
    mission = forecast.mission
    expected = landing_height(mission)
    if expected is None or not record.completed or not record.path:
        return ()
    landed = round(record.heights[-1], 1) + 0.0
    if abs(landed - expected) < 1.0:  # [m]
        return ()
    other = Forecast(landing_on(mission, landed), wind=forecast.wind).estimate.total_s
    return (
        f"it landed {landed:.1f} m above home, but the ground there is {abs(expected - landed):.1f} m "
        f"{'higher' if expected > landed else 'lower'}; a simulator may have level ground, `mock --scenario` has the "
        f"scenario's. The estimate to that landing is {other:.1f} s",
    )


class FlownClearance(NamedTuple):
    """The smallest clearance of a flight, and the planned one [m]; `least` is of the smallest slack, from home."""

    least: Check
    place: Geodetic
    time_s: float
    planned: float | None = None
    guaranteed: float | None = None

    @property
    def kept(self) -> bool:
        return not falls_short(self.least.nearest.distance, self.least.required)

    def words(self) -> str:
        near = self.least.nearest
        required = self.least.required
        where = f"{self.place.latitude_deg:.6f}, {self.place.longitude_deg:.6f}, up {near.place[2]:.1f} m"
        guaranteed = "" if self.guaranteed is None else f", {floor_cm(self.guaranteed):.2f} m guaranteed"
        verdict = "" if self.kept else ", which was NOT kept"
        return (
            f"least clearance flown {floor_cm(near.distance):.2f} m, to {near.what} at {where}, "
            f"{self.time_s:.1f} s after arming{guaranteed}; {ceil_cm(required):.2f} m required{verdict}"
        )


def flown_clearance(record: FlightRecord, scenario: Scenario, mission: Mission | None = None) -> FlownClearance | None:
    """Return the smallest clearance of a flown path, if it is at the scenario's place.

    Heights are above the place of arming, on the scenario's ground. The ground counts from the first to the last time
    that it was cleared as required. If it always was, the rest of climb and descent is left out. Obstacles always
    count.

    Raises:
        BadInput: the flight is of another place.
        BadInput, MissionError: as the scenario's maps.
    """
    if len(record.path) < 2:
        return None
    begins = Geodetic(record.path[0].latitude_deg, record.path[0].longitude_deg)
    scenario.expect_here(begins)
    if apart(begins, scenario.frame.home) > 20_000.0:  # [m]: of another place
        return None
    points = _flown_points(record, scenario)
    least = _least_clear(points, scenario)
    if not np.isfinite(least.nearest.distance):
        return None
    place = np.asarray(least.nearest.place)
    sample = record.path[int(np.argmin(np.linalg.norm(points - place, axis=1)))]
    planned = guaranteed = None
    forecast = None if mission is None else Forecast(_from_ground(mission, scenario), scenario)
    if forecast is not None and forecast.cruise:
        checks = forecast.proof.checks
        planned = min(check.nearest.distance for check in checks if check.limit in ("obstacles", "ground"))
        guarantee = forecast.guarantee_if_known
        clearance = None if guarantee is None else guarantee.clearance
        guaranteed = None if clearance is None else clearance.guaranteed
    return FlownClearance(least, scenario.frame.geodetic(place), float(sample.time_s), planned, guaranteed)


def _from_ground(mission: Mission, scenario: Scenario) -> Mission:
    home = scenario.frame.moved(np.zeros(3), mission.frame)
    rise = float(scenario.airspace.ground(home[None, :])[0] - home[2])
    items = tuple(
        replace(item, altitude=item.altitude + rise) if plain_frame(item.frame) == Frame.GLOBAL else item
        for item in mission.items
    )
    return replace(mission, home=replace(mission.home, altitude=mission.home.altitude + rise), items=items)


def _flown_points(record: FlightRecord, scenario: Scenario) -> Points:
    places = [(sample.latitude_deg, sample.longitude_deg) for sample in record.path]
    latitude, longitude = np.array(places).T
    frame = scenario.frame
    at_home_height = frame.to_local(latitude, longitude, frame.home.altitude)
    ground = float(scenario.airspace.ground(at_home_height[:1])[0])
    return frame.to_local(latitude, longitude, frame.home.altitude + ground + np.array(record.heights))


def _least_clear(points: Points, scenario: Scenario) -> Check:
    world = scenario.airspace
    limits = scenario.limits
    checks = [Check("obstacles", world.obstacle_clearance(points), limits.obstacle_distance)]
    high = np.flatnonzero(points[:, 2] - world.ground(points) >= limits.height_above_ground)
    if len(high) and high[-1] > high[0]:
        over = points[high[0] : high[-1] + 1]
        ground = world.terrain_clearance(over)
        path = over[_in_column(over) : len(over) - _in_column(over[::-1])]
        if falls_short(ground.distance, limits.height_above_ground):
            checks.append(Check("ground", ground, limits.height_above_ground))
        elif len(path) > 1:  # a climb or descent passes every height
            checks.append(Check("ground", world.terrain_clearance(path), limits.height_above_ground))
    return min(checks, key=lambda check: check.slack)


def _in_column(points: Points) -> int:
    radius = 3.0  # of vertical climb and descent [m]
    outside = np.flatnonzero(np.linalg.norm((points - points[0])[:, :2], axis=1) > radius)
    return int(outside[0]) if len(outside) else len(points)
