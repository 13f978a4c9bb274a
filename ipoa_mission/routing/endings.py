"""A flight of which every ending is clear: a return altitude and rally points for it, and what they leave to the path.

RTL can be seen to by the vehicle's return altitude, and where none helps by rally points; where the vehicle brakes, or
climbs under something, only another path or a lower speed helps. What the scenario names is the user's, and stays.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.checks.way_home import HEIGHT_STEP, HIGHEST
from ipoa_mission.forecast.endings import Endings
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.looks import CLIMBS, EVERY_S, GROUND, RETURNS, EndingWays, Looks
from ipoa_mission.routing.rally import rally_sets
from ipoa_mission.vehicles.ending import Ending

MOST_TRIES = 8  # return altitudes
SAG = 0.3  # a return is up to so much lower than it is set [m]


@dataclass(frozen=True)
class Shortfall:
    """An ending that is too near to something: ordered at a time [s], of which body, and what is missing at most [m].

    `part` is the leg of its way; `overhead`: what is too near hangs over the vehicle as it climbs. The ground is "".
    """

    ending: Ending
    time: float
    body: str
    missing: float
    part: int
    overhead: bool = False


def settled(forecast: Forecast) -> tuple[Forecast, tuple[Shortfall, ...]]:
    """The mission with the return altitude, and the rally points if need be, at which its endings keep the most.

    Returns:
        The forecast of it, and what is still too near: of each body the worst.
    """
    ways = EndingWays(forecast)
    braking = list(_shortfalls(ways, Ending.HOLD, ways.looks(Ending.HOLD)))
    if ways.why_unknown() is not None:
        return forecast, tuple(braking)
    if braking:  # another path it must be, and that is to turn back and climb in the clear as well
        return forecast, (*braking, *(one for one in _returning(ways) if one.part < RETURNS))
    best, short = forecast, _returning(ways)
    by = forecast.mission.autopilot.book.return_height
    may_rise = by.name not in forecast.world.vehicle.autopilot_parameters()
    bound, highest = forecast.world.airspace.bounds.upper[2], _highest(forecast)
    if short and may_rise:
        best, short = _at_another_height(ways, best, short, min(bound, highest))
    if any(one.part >= RETURNS for one in short) and not forecast.mission.rally:
        best, short = _with_rally_points(ways, best, short)
    if any(one.part >= RETURNS for one in short) and may_rise and highest > bound:
        best, short = _at_another_height(ways, best, short, highest)
    return best, tuple(short)


def _highest(forecast: Forecast) -> float:
    """How high above home a return may be: what the scenario allows above the ground, whatever its bounds are."""
    ceiling = forecast.world.planning.max_height_above_ground
    return HIGHEST if ceiling is None else min(HIGHEST, ceiling)


def _with_rally_points(
    ways: EndingWays, forecast: Forecast, short: list[Shortfall]
) -> tuple[Forecast, list[Shortfall]]:
    """The fewest rally points that make RTL clear; none where they do not."""
    for rally in rally_sets(ways.returning(forecast)):
        landing = Forecast(replace(forecast.given, rally=rally), forecast.scenario, forecast.wind)
        left = _returning(ways.returning(landing))
        if not any(one.part >= RETURNS for one in left):
            return landing, left
    return forecast, short


def why_not_planned(forecast: Forecast) -> str:
    """Which stretch of which ending is not clear, in words that go on."""
    endings = Endings(forecast)
    rows = [row for ending in (Ending.HOLD, Ending.RTL) for row in endings.rows(ending, timed=False) if not row.clear]
    worst = min(rows, key=lambda row: row.least_m - row.required_m)
    where = ", where it brakes" if worst.ending is Ending.HOLD else ""
    kept = f"keeps {worst.least_m:.2f} m of {worst.to}{where}, {worst.required_m:.2f} m required"
    return (
        f"RTL from {worst.from_s:.1f} to {worst.to_s:.1f} s after arming "
        f"{kept if math.isfinite(worst.least_m) else worst.to}"
    )


def planned_returns(forecast: Forecast) -> Iterator[str]:
    """That its vehicle needs another return altitude, and which rally points were planned, where it is so."""
    scenario, mission = forecast.world, forecast.mission
    by, given = mission.autopilot.book.return_height, scenario.vehicle.autopilot_parameters()
    if by.name in forecast.given.parameters and by.name not in given:
        value, highest = forecast.given.parameters[by.name], scenario.airspace.bounds.upper[2]
        beyond = f", above the upper bound of {highest:g} m" if value * by.unit > highest else ""
        yield (
            f"RTL is clear from every second with {by.name} = {value:g} in the vehicle{beyond} "
            f"({scenario.name}.params; `fly --set-params` writes it)"
        )
    if len(mission.rally) > len(scenario.rally_points):
        places = (forecast.frame.local(replace(p, altitude=mission.home.altitude)) for p in mission.rally)
        words = "; ".join(f"east {east:.0f}, north {north:.0f} m" for east, north, _ in places)
        yield f"RTL is clear from every second by rally points, at {words}: they are uploaded with the mission"


def _returning(ways: EndingWays) -> list[Shortfall]:
    """What RTL comes too near to; at first from few times, since one that is not clear is enough."""
    begin, end = ways.stops.times[[0, -1]]
    few = ways.at(Ending.RTL, np.linspace(begin, end, max(2, round((end - begin) / (2 * EVERY_S)))))
    return list(_shortfalls(ways, Ending.RTL, few)) or list(_shortfalls(ways, Ending.RTL, ways.looks(Ending.RTL)))


def _at_another_height(
    ways: EndingWays, forecast: Forecast, short: list[Shortfall], highest: float
) -> tuple[Forecast, list[Shortfall]]:
    """The lowest return altitude of those tried at which RTL is clear, else that which leaves the least to the path."""
    by = forecast.mission.autopilot.book.return_height
    now = forecast.mission.autopilot.book.complete(forecast.mission.parameters)[by.name] * by.unit
    best, tried, asked = (forecast, short), {now}, list(_heights(ways, short, now))
    for _ in range(MOST_TRIES):
        asked = sorted({height for height in asked if 0.0 < height <= highest} - tried)
        if not asked:
            break
        tried.add(height := asked.pop(0))
        raised = forecast.given.with_parameters({by.name: by.spelled(height)})
        other = Forecast(raised, forecast.scenario, forecast.wind)
        if not (left := _returning(ways.returning(other))):
            return other, []
        best = min(best, (other, left), key=_merit)
        asked += _heights(ways, left, height)
    return best


def _merit(settled: tuple[Forecast, list[Shortfall]]) -> tuple[float, float]:
    """What is left: first what no path helps against, then what is missing."""
    _, left = settled
    return sum(one.missing for one in left if one.part >= RETURNS), sum(one.missing for one in left)


def _heights(ways: EndingWays, short: list[Shortfall], now: float) -> Iterator[float]:
    """Heights, of every five meters, over what is in the way, and under what hangs over it."""
    bodies = {body.name: body.bounds[:, 2] for body in ways.roomy.airspace.obstacles}
    required = ways.required + SAG
    over = [now + one.missing for one in short if one.body == "" and one.part >= CLIMBS]
    for one in short:
        if one.body and one.part >= CLIMBS:
            base, top = bodies[one.body]
            over += [float(top) + required] if one.part >= RETURNS else []
            yield float(HEIGHT_STEP * math.floor((base - required) / HEIGHT_STEP))
    if over:
        yield float(HEIGHT_STEP * math.ceil(max(over) / HEIGHT_STEP))
        yield float(HEIGHT_STEP * math.ceil(min(over) / HEIGHT_STEP))


def _shortfalls(ways: EndingWays, ending: Ending, looks: Looks) -> Iterator[Shortfall]:
    """What is too near, of each body and each leg of the ways to it the worst."""
    short = np.where(looks.taken[..., None] & ~looks.clear[:, None, None], looks.near - ways.required, 0.0)
    where = np.argwhere(short < 0.0)
    seen = set[tuple[int, int]]()
    bodies = ways.roomy.airspace.obstacles
    for n, k, leg in where[np.argsort(short[tuple(where.T)], kind="stable")].tolist():
        number = int(looks.which[n, k, leg])
        if (number, leg) not in seen:
            seen.add((number, leg))
            name = "" if number == GROUND else bodies[number].name
            over = number >= 0 and leg == CLIMBS and float(bodies[number].bounds[0, 2]) > float(looks.ways[n, k, 1, 2])
            yield Shortfall(ending, float(looks.times[n]), name, -float(short[n, k, leg]), leg, over)
