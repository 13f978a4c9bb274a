import math
from dataclasses import dataclass

import numpy as np

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import item_places, join
from ipoa_mission.forecast.itinerary.program import as_flown
from ipoa_mission.forecast.timing.estimate import ItemTime
from ipoa_mission.geometry import Points, Vector, polyline_length
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.mission.items import Item
from ipoa_mission.planning.proof import Proof, prove

MOVING = WAYPOINTS | {Command.NAV_TAKEOFF}
MIN_HEADING_LENGTH = 0.5  # horizontal [m]


@dataclass(frozen=True)
class FlownItem:
    """One item as flown, and the leg to it.

    `heading` is from begin to end [rad], clockwise from north (NaN: vertical). `proof`: between two waypoints.
    """

    item: Item
    time: ItemTime
    name: str
    place: Vector | None
    above_ground: float
    way: Points
    length: float
    heading: float
    climb: float
    proof: Proof | None


def stops(forecast: Forecast) -> tuple[FlownItem, ...]:
    scenario = forecast.world
    rows, airspace, flown = [], scenario.airspace, as_flown(forecast.mission)
    places = item_places(flown, scenario.frame, airspace.ground)
    bent = {leg.seq for leg in forecast.cruise if leg.stray > 0}
    curves = {seq: join([leg for leg in forecast.cruise if leg.seq == seq]) for seq in bent}
    before, flying = np.zeros(3), False
    for time in forecast.estimate.items:
        item, place = flown.items[time.seq - 1], places[time.seq - 1]
        if place is not None and item.command == Command.NAV_LAND:
            place[2] = airspace.ground(place[None, :])[0]
        leg = (place if place is not None else before) - before
        run = float(np.hypot(*leg[:2]))
        way, stray = curves.get(time.seq, (before + np.array([[0.0], [1.0]]) * leg, 0.0))
        moves = item.command in MOVING and np.linalg.norm(leg) > 0
        between = place is not None and flying and moves and not forecast.unknown
        rows.append(
            FlownItem(
                item=item,
                time=time,
                name=item_words(item),
                place=place,
                above_ground=math.nan if place is None else float(place[2] - airspace.ground(place[None, :])[0]),
                way=way,
                length=polyline_length(way),
                heading=math.atan2(leg[0], leg[1]) % (2 * math.pi) if run > MIN_HEADING_LENGTH else math.nan,
                climb=float(leg[2]),
                proof=prove(way, scenario, stray) if between else None,
            )
        )
        if place is not None:
            before, flying = place, True
    return tuple(rows)
