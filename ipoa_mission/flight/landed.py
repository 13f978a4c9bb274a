"""Report where a flight landed; a simulator's ground may be at home's height everywhere."""

import math

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.itinerary import rally_places
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.landing_ground import landing_height, landing_on
from ipoa_mission.world.frame import Geodetic, LocalFrame

MIN_HEIGHT_DIFFERENCE = 1.0  # [m]
RALLY_RADIUS = 10.0  # [m]


def landed_at_rally(mission: Mission, record: FlightRecord) -> tuple[str, ...]:
    if not record.completed or not record.path or not mission.rally:
        return ()
    end, frame = record.path[-1], LocalFrame(mission.home)
    there = Geodetic(end.latitude_deg, end.longitude_deg, mission.home.altitude)
    here = tuple(map(float, frame.local(there)[:2]))
    ways = [math.dist(here, place[:2]) for place in rally_places(mission)]
    nearest = min(range(len(ways)), key=ways.__getitem__)
    if ways[nearest] > RALLY_RADIUS or math.hypot(*here) <= ways[nearest]:
        return ()
    bearing = math.degrees(math.atan2(here[0], here[1])) % 360.0
    return (f"it landed at rally point {nearest + 1}, {math.hypot(*here):.0f} m {bearing:.0f}° from home",)


def landed_elsewhere(forecast: Forecast, record: FlightRecord) -> tuple[str, ...]:
    """Report other ground than expected, and the time to it."""
    mission = forecast.mission
    expected = landing_height(mission)
    if expected is None or not record.completed or not record.path:
        return ()
    landed = round(record.path[-1].height, 1) + 0.0
    if abs(landed - expected) < MIN_HEIGHT_DIFFERENCE:
        return ()
    other = Forecast(landing_on(mission, landed), wind=forecast.wind).estimate.total_s
    return (
        f"it landed {landed:.1f} m above home, but the ground there is {abs(expected - landed):.1f} m "
        f"{'higher' if expected > landed else 'lower'}: is it a simulator with level ground? `mock --scenario` has the "
        f"scenario's. The estimate to that landing is {other:.1f} s",
    )
