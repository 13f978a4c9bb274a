"""Compare legs with a scenario's limits, and landings with the ground at home."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.autopilot.returning import SlowStretch
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.mission.items import Item

if TYPE_CHECKING:  # not for an upload
    from ipoa_mission.planning.proof import Check
    from ipoa_mission.scenario import Scenario

ROUNDING = {"m": 0.02, "deg": 0.5}  # of positions to 1e-7 degrees and to millimeters


def broken_limits(leg: Leg, scenario: "Scenario") -> "list[Check]":
    from ipoa_mission.planning.proof import prove

    limits = {"obstacles"}  # a take-off and a landing are steep, and begin or end on the ground
    if leg.stage in (FlightStage.ROUTE, FlightStage.RETURN):
        limits |= {"ground", "ceiling", "bounds"}
    if leg.stage is FlightStage.ROUTE and np.ptp(leg.points[:, :2], axis=0).max() >= ROUNDING["m"]:
        limits |= {"climb", "descent"}
    checks = prove(leg.points, scenario, leg.chord_error).checks
    return [c for c in checks if c.limit in limits and c.slack < -ROUNDING[c.unit]]


class Landing(NamedTuple):
    """`assumed_height`: the ground's height [m] over the level that LAND slows down above, without a range finder."""

    seq: int
    item: Item
    east: float
    north: float
    height: float
    assumed_height: float

    @property
    def words(self) -> str:
        return f"item {self.seq} ({self.item.name}): {self.where}"

    @property
    def where(self) -> str:
        return f"at east {self.east:.1f}, north {self.north:.1f} the ground is {above_or_below(self.height)} home"

    def touches_down(self, stretch: SlowStretch) -> str:
        speed = f"{stretch.touchdown(self.assumed_height):.1f} m/s"
        return f"without a rangefinder the vehicle touches down at up to {speed}, not at {stretch.landing:.1f}"


def landings(forecast: Forecast) -> Iterator[Landing]:
    mission = forecast.mission
    reported = set[tuple[int, float]]()
    for leg in forecast.legs:
        if leg.stage is not FlightStage.LANDING or leg.points[-1, 2] > leg.points[0, 2]:
            continue
        height = forecast.frame.geodetic(leg.points[-1]).altitude - mission.home.altitude
        if (leg.seq, round(height, 1)) not in reported:
            reported.add((leg.seq, round(height, 1)))
            item = mission.items[leg.seq - 1]
            lands_at = item.command == Command.NAV_LAND and item.has_position
            below = min(item.height(mission.home), 0.0) if lands_at else 0.0  # ArduCopter 4.7 counts from there
            assumed_height = height - (below if mission.autopilot.guidance.lands_below_item else 0.0)
            east, north, _ = leg.points[-1].tolist()
            yield Landing(leg.seq, item, east, north, height, assumed_height)


def above_or_below(height: float) -> str:
    return f"{abs(height):.1f} m {'above' if height > 0 else 'below'}"
