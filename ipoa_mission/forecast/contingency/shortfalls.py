"""Find contingencies too near to obstacles, and return altitudes that clear them."""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import GROUND, SAMPLING, ContingencySamples, ReturnLeg
from ipoa_mission.forecast.contingency.enlarged_airspace import SHARING, EnlargedAirspace
from ipoa_mission.forecast.deviation.kept_limits import clearance_task, with_margins
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.planning.proof import Check, prove_ground
from ipoa_mission.scenario import Scenario

HEIGHT_STEP, MAX_HEIGHT = 5, 500  # [m above home]
SAG = 0.3  # below the set height of a return [m]


class Shortfall(NamedTuple):
    """A contingency too near to a body, ordered at a time [s], with its greatest missing distance [m].

    `number`: index of the obstacle, whose name another may have. `overhead`: above the climbing vehicle.
    """

    contingency: Contingency
    time: float
    body: str
    number: int
    missing: float
    part: int
    overhead: bool = False

    @property
    def comes_down(self) -> bool:
        return self.contingency is Contingency.LAND and self.part > ReturnLeg.BRAKES


def find_return_shortfalls(paths: ContingencyPaths) -> list[Shortfall]:
    begin, end = paths.in_air
    times = np.linspace(begin, end, max(2, round((end - begin) / (2 * SAMPLING.step_s))))
    few = paths.at(Contingency.RTL, times)
    return [*find_shortfalls(paths, Contingency.RTL, few)] or [*find_shortfalls(paths, Contingency.RTL)]


def highest_return(forecast: Forecast) -> float:
    """Return the greatest return altitude [m above home] in bounds, own fence and, if that is on, the mission's."""
    mission = forecast.mission
    world = forecast.world
    table = mission.autopilot.parameter_table
    values = {**table.others, **table.by_old_names(mission.parameters)}
    if mission.fence:
        switch = table.by_meaning["fence switch"].name
        values[switch] = values[switch] or 1.0
    ceiling = world.airspace.bounds.upper[2] - float(forecast.home[2])
    allowed = [MAX_HEIGHT, ceiling, world.planning.max_height_above_ground or math.inf]
    fence = mission.autopilot.own_fence(values)
    if fence is not None:
        allowed.append(fence.ceiling.value - forecast.deviation_law.highest.distance(0.01))
    return min(allowed)


def return_altitude(forecast: Forecast) -> float:
    """Return the height of a return from far away [m above home]."""
    mission = forecast.mission
    values = mission.complete_parameters
    ups = (0.0, *(place.altitude for place in mission.rally))
    far = 1e5  # [m]
    return max(mission.autopilot.return_height(values, 0.0, far, up) for up in ups)


def heights_above(above: float) -> Iterator[float]:
    return (float(height) for height in range(HEIGHT_STEP, MAX_HEIGHT + 1, HEIGHT_STEP) if height > above)


def clear_in(scenario: Scenario) -> Callable[[Iterable[Leg]], bool]:
    """Return a test of paths for the required clearance, with room for the deviation bound."""
    airspace = scenario.cached(EnlargedAirspace.of)
    higher = with_margins(clearance_task(scenario), SHARING)
    required = scenario.limits.obstacle_distance
    spare = 0.0 if scenario.safety.chance is None else SAG

    def is_clear(legs: Iterable[Leg]) -> bool:
        return all(
            airspace.obstacle_clearance(leg.points).distance >= required + spare
            and all(check.slack >= spare for check in prove_ground(leg.points, higher))
            for leg in legs
        )

    return is_clear


def try_return_altitudes(
    paths: ContingencyPaths, forecast: Forecast, shortfalls: list[Shortfall]
) -> list[tuple[Forecast, list[Shortfall]]]:
    """Return the lowest clear return altitude that was tried, else all tried ones, the smallest shortfall first."""

    def merit(tried: tuple[Forecast, list[Shortfall]]) -> tuple[bool, float, float]:
        returns = sum(each.missing for each in tried[1] if each.part >= ReturnLeg.RETURNS)
        return return_altitude(tried[0]) > allowed, returns, sum(each.missing for each in tried[1])

    table = forecast.mission.autopilot.parameter_table
    by = table.by_meaning["return height"]
    now = by.si(table.complete(forecast.mission.parameters)[by.name])
    allowed = highest_return(forecast)
    highest = allowed - (return_altitude(forecast) - now)  # PX4 measures from the height of its goal
    others = [(forecast, shortfalls)]
    tried = {now}
    least = now + _ground_missing(shortfalls)
    heights = list(_heights(paths, shortfalls, now))
    if now > highest:
        heights.append(float(HEIGHT_STEP * math.floor(highest / HEIGHT_STEP)))
    for _ in range(8):
        heights = sorted({height for height in heights if max(least, 1e-9) <= height <= highest} - tried)
        if not heights:
            break
        tried.add(height := heights.pop(0))
        raised = forecast.mission_as_read.with_parameters({by.name: by.spelled(height)})
        other = Forecast(raised, forecast.scenario, forecast.wind)
        if not (left := find_return_shortfalls(paths.returning(other))):
            return [(other, [])]
        others.append((other, left))
        heights += _heights(paths, left, height)
        least = max(least, height + _ground_missing(left))
    return sorted(others, key=merit)


def _ground_missing(shortfalls: list[Shortfall]) -> float:
    """Return by how much a level return has to be higher over the ground at least [m]."""
    return max(
        (each.missing for each in shortfalls if not each.body and each.part == ReturnLeg.RETURNS), default=-math.inf
    )


def _heights(paths: ContingencyPaths, shortfalls: list[Shortfall], now: float) -> Iterator[float]:
    """Return multiples of 5 m above obstacles in the way, below those overhead."""
    required = paths.required + SAG - float(paths.forecast.home[2])
    over = [now + each.missing for each in shortfalls if each.body == "" and each.part >= ReturnLeg.CLIMBS]
    for each in shortfalls:
        if each.body and each.part >= ReturnLeg.CLIMBS:
            base, top = paths.enlarged.whole.obstacles[each.number].bounds[:, 2]
            over += [float(top) + required] if each.part >= ReturnLeg.RETURNS else []
            yield float(HEIGHT_STEP * math.floor((base - required) / HEIGHT_STEP))
    if over:
        yield float(HEIGHT_STEP * math.ceil(max(over) / HEIGHT_STEP))
        yield float(HEIGHT_STEP * math.ceil(min(over) / HEIGHT_STEP))


def find_shortfalls(
    paths: ContingencyPaths, contingency: Contingency, samples: ContingencySamples | None = None
) -> Iterator[Shortfall]:
    """Return the worst shortfall to each body by leg, the greatest first; `samples`: by default at all times."""
    samples = paths.samples(contingency) if samples is None else samples
    slack = np.where(samples.possible[..., None] & ~samples.clear[:, None, None], samples.near - paths.required, 0.0)
    where = np.argwhere(slack < 0.0)
    reported = set[tuple[int, int]]()
    bodies = paths.enlarged.whole.obstacles
    for n, k, leg in where[np.argsort(slack[tuple(where.T)], kind="stable")].tolist():
        number = int(samples.which[n, k, leg])
        if (number, leg) in reported:
            continue
        reported.add((number, leg))
        name = "" if number == GROUND else bodies[number].name
        climbs = number >= 0 and leg == ReturnLeg.CLIMBS and contingency is Contingency.RTL
        over = climbs and float(bodies[number].bounds[0, 2]) > float(samples.paths[n, k, 1, 2])
        yield Shortfall(contingency, float(samples.times[n]), name, number, -float(slack[n, k, leg]), leg, over)


def nearest_of_legs(paths: ContingencyPaths, samples: ContingencySamples, n: int, legs: range) -> Check:
    parts = [path[legs.start : legs.stop + 1] for path in samples.paths[n][samples.possible[n]]]
    aside, height = samples.excess[n].tolist()
    if GROUND in samples.which[n, :, legs.start : legs.stop]:
        return paths.lowest([part[:2] for part in parts], max(aside, height))
    return Check("obstacles", paths.nearest(parts, aside, height), paths.required)


def nearest_of(paths: ContingencyPaths, contingency: Contingency, samples: ContingencySamples, n: int) -> Check:
    return Check("obstacles", paths.exact_clearance(contingency, samples, n), paths.required)
