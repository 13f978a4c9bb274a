"""Check landings on ground that is higher or lower than home."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.slow_landing import SlowStretch
from ipoa_mission.checks.numbered_finding import Numbered, item_of
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.itinerary.flown_legs import Phase

if TYPE_CHECKING:
    from ipoa_mission.forecast.forecast import Forecast


@dataclass(frozen=True)
class Landing:
    """`counted`: the greatest ground height [m] that the autopilot assumes, without a range finder."""

    item: Numbered
    east: float
    north: float
    height: float
    counted: float

    @property
    def words(self) -> str:
        return f"{self.item}: {self.where}"

    @property
    def where(self) -> str:
        return f"at east {self.east:.1f}, north {self.north:.1f} the ground is {_above_or_below(self.height)} home"


def landings(forecast: "Forecast") -> Iterator[Landing]:
    mission, reported = forecast.mission, set[tuple[int, float]]()
    for leg in forecast.legs:
        if leg.phase is not Phase.LANDING or leg.points[-1, 2] > leg.points[0, 2]:
            continue
        height = forecast.frame.geodetic(leg.points[-1]).altitude - mission.home.altitude
        if (leg.seq, round(height, 1)) not in reported:
            reported.add((leg.seq, round(height, 1)))
            at = item_of(mission, leg.seq)
            item = at.item
            lands_at = item.command == Command.NAV_LAND and item.has_position
            below = min(item.height(mission.home), 0.0) if lands_at else 0.0  # ArduCopter 4.7 counts from there
            counted = height - (below if mission.autopilot.guidance.lands_below_item else 0.0)
            east, north = (float(value) for value in leg.points[-1, :2])
            yield Landing(at, east, north, height, counted)


def check_ground(forecast: "Forecast") -> Iterator[Finding]:
    scenario = forecast.world
    at_home = float(scenario.airspace.ground(np.zeros((1, 3)))[0])
    if abs(at_home) > 0.5:  # [m]
        yield Finding(
            "home-not-on-ground",
            Severity.WARNING,
            0,
            f"home: the ground there is {_above_or_below(at_home)} home's altitude: a vehicle measures heights from "
            f"its take-off, and flies {abs(at_home):.1f} m {'higher' if at_home > 0 else 'lower'} than planned",
            f"set home.altitude_amsl = {scenario.home.altitude_amsl + at_home:.1f}",
        )
    yield from check_landings(forecast)


def check_landings(forecast: "Forecast") -> Iterator[Finding]:
    mission = forecast.mission
    stretch = mission.autopilot.slow_stretch(mission.parameters)
    if stretch is None:
        return
    for landing in landings(forecast):
        if stretch.is_fast(landing.counted):
            wanted = name_values(mission.autopilot.slowed(mission.parameters, landing.counted))
            hint = f"{wanted} in the vehicle and under [vehicle.parameters] would slow it down in time"
            message = f"{landing.where}: {touches_down(stretch, landing)}"
            yield landing.item.warning("fast-touchdown", message, hint)
        elif landing.height < -5.0:  # [m]
            descent = stretch.ends - landing.height
            slowly = f"flown at {stretch.landing:.1f} m/s and take {descent / stretch.landing:.0f} s"
            message = f"{landing.where}: without a rangefinder the last {descent:.0f} m are {slowly}"
            hint = "a rangefinder, or a waypoint low over that place with its altitude above terrain, shortens it"
            yield landing.item.warning("slow-landing", message, hint)


def touches_down(stretch: SlowStretch, landing: Landing) -> str:
    return (
        f"without a rangefinder the vehicle touches down at up to {stretch.touchdown(landing.counted):.1f} m/s, "
        f"not at {stretch.landing:.1f}"
    )


def name_values(parameters: Parameters) -> str:
    return " and ".join(f"{name} = {value:g}" for name, value in parameters.items())


def _above_or_below(height: float) -> str:
    return f"{abs(height):.1f} m {'above' if height > 0 else 'below'}"
