"""Where a flight landed: at which rally point, and whether on the ground that its mission knows of.

A simulator's ground may be as high as home everywhere.
"""

import math

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.itinerary import rally_places
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.landing_ground import landing_height, landing_on
from ipoa_mission.world.frame import Geodetic, LocalFrame

NOTICED = 1.0  # [m]
AT_A_POINT = 10.0  # who lands no farther from it has landed there [m]


def landed_at_rally(mission: Mission, record: FlightRecord) -> tuple[str, ...]:
    """Words about a return that ended at a rally point; nothing where it ended at home or the mission has none."""
    if not record.completed or not record.path or not mission.rally:
        return ()
    end, frame = record.path[-1], LocalFrame(mission.home)
    there = Geodetic(end.latitude_deg, end.longitude_deg, mission.home.altitude)
    here = tuple(map(float, frame.local(there)[:2]))
    ways = [math.dist(here, place[:2]) for place in rally_places(mission)]
    nearest = min(range(len(ways)), key=ways.__getitem__)
    if ways[nearest] > AT_A_POINT or math.hypot(*here) <= ways[nearest]:
        return ()
    bearing = math.degrees(math.atan2(here[0], here[1])) % 360.0
    return (f"it landed at rally point {nearest + 1}, {math.hypot(*here):.0f} m {bearing:.0f}° from home",)


def landed_elsewhere(forecast: Forecast, record: FlightRecord) -> tuple[str, ...]:
    """Words about a landing that was higher or lower than the ground is there, and how long that is estimated to take.

    Nothing where the flight did not land or came down where it should.
    """
    mission = forecast.mission
    expected = landing_height(mission)
    if expected is None or not record.completed or not record.path:
        return ()
    landed = round(record.path[-1].height, 1) + 0.0
    if abs(landed - expected) < NOTICED:
        return ()
    other = Forecast(landing_on(mission, landed), wind=forecast.wind).estimate.total_s
    return (
        f"it landed {landed:.1f} m above home, but the ground there is {abs(expected - landed):.1f} m "
        f"{'higher' if expected > landed else 'lower'}: a simulator whose ground is level? `mock --scenario` has the "
        f"scenario's. To where it landed {other:.1f} s are estimated",
    )
