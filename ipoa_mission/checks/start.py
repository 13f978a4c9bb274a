"""A flight that does not begin where its mission was made for: from another place, or with a later item."""

import math
from dataclasses import replace

import numpy as np

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.jump_targets import jump_target
from ipoa_mission.mission.commands import JUMPS
from ipoa_mission.mission.items import LEFT_OUT, Mission, takeoff
from ipoa_mission.world.frame import Geodetic, apart

#: So far from the mission's home a vehicle is at it: less than positioning by satellite is worth [m].
AT_HOME = 1.5
#: So near it may begin where no scenario tells what is on the way [m].
UNSEEN = 10.0
#: A vehicle on the ground first climbs to the height of its first item, but at least so far [m].
LEAST_CLIMB = 2.5


class NotAtStart(MissionError):
    """The vehicle stands where the flight may not begin."""


def begun_at(mission: Mission, first: int, there: Geodetic | None = None) -> Mission:
    """The mission as it is flown from a place on the ground, beginning with item `first`; numbers of items stay.

    Heights above home count from there. A vehicle that does not begin with a take-off climbs to the height of its
    first item all the same, and then flies straight to it.

    Raises:
        BadInput: there is no such item, it has no place to fly to, or a jump leads back to before it.
    """
    home = mission.home if there is None else there
    if first == 0:
        return replace(mission, home=home)
    if not 0 < first < len(mission.items):
        raise BadInput(f"expected an item from 1 to {len(mission.items)}, not {first + 1}", place="--from")
    height = mission.altitude_above_home(mission.items[first])
    if not (mission.items[first].has_position and np.isfinite(height)):
        raise BadInput(f"expected an item with a place and a height, and item {first + 1} has none", place="--from")
    for n, item in enumerate(mission.items[first:], first):
        if item.command in JUMPS and (target := jump_target(mission.items, n)) is not None and target < first:
            raise BadInput(f"item {n + 1} jumps back to item {target + 1}, before item {first + 1}", place="--from")
    begins = (LEFT_OUT,) * (first - 1) + (takeoff(home, max(height, LEAST_CLIMB)),)
    return replace(mission, home=home, items=begins + mission.items[first:])


def check_start(forecast: Forecast, first: int, there: Geodetic) -> tuple[str, ...]:
    """Whether a vehicle that stands `there` may begin with item `first` (index into the items); remarks for the user.

    Raises:
        NotAtStart: the way from there is not clear, or nobody knows and it is far from the mission's home; or it is
            nearer to another start place of the same survey.
    """
    mission, scenario = forecast.given, forecast.scenario
    aside = apart(there, mission.home)
    if aside <= AT_HOME and first == 0:
        return ()
    where = f"the vehicle stands {aside:.1f} m from the mission's home"
    if scenario is None:
        if aside > UNSEEN:
            raise NotAtStart(
                f"{where}, and without a scenario nobody can look at the way from there",
                hint="bring it there, or plan from where it stands: `fly SCENARIO` looks at the way",
            )
        return (f"{where}: no scenario tells what is on the way from there",)
    from ipoa_mission.checks.airspace_check import check_airspace

    frame = scenario.frame
    place = frame.local(Geodetic(there.latitude_deg, there.longitude_deg, mission.home.altitude))
    starts = () if scenario.survey is None else scenario.survey.starts or ()
    if any(math.dist(place[:2], start) < np.hypot(*place[:2]) for start in starts if math.hypot(*start) > AT_HOME):
        raise NotAtStart(
            f"{where}, and nearer to another of the survey's start places",
            hint=f"bring it to {mission.home.latitude_deg:.6f}, {mission.home.longitude_deg:.6f}, or fly what begins "
            "where it is",
        )
    ground = float(scenario.airspace.ground(place[None, :])[0])
    home = Geodetic(there.latitude_deg, there.longitude_deg, mission.home.altitude + ground)
    begun = Forecast(begun_at(mission, first, home), scenario)
    errors = [f for f in check_airspace(begun) if f.severity is Severity.ERROR]
    if errors:
        words = f"{where}; from there: {errors[0].message}"
        raise NotAtStart(words, hint="bring it to the mission's home, or plan from where it stands")
    return (f"{where}: the way from there was checked and is clear",)
