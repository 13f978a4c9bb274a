"""Choose a return altitude and rally points that make every contingency clear.

Values named in the scenario stay.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.checks.unsafe import Unsafe
from ipoa_mission.forecast.contingency.contingencies import (
    Contingencies,
    contingencies_of,
    lands_by_choice,
    to_return_instead,
    who_lands,
)
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths, ReturnLeg
from ipoa_mission.forecast.contingency.shortfalls import (
    Shortfall,
    change_return_altitude,
    find_return_shortfalls,
    find_shortfalls,
    highest_return,
    return_altitude,
)
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.routing.rally import rally_sets
from ipoa_mission.routing.repairs import slow_landings
from ipoa_mission.scenario import Scenario

NAMED = 3  # in a note on LAND


def settled(forecast: Forecast) -> tuple[Forecast, tuple[Shortfall, ...]]:
    """Return the clearest forecast, and the worst remaining shortfall of each body."""
    ways = forecast.cached(ContingencyPaths)
    braking = list(find_shortfalls(ways, Contingency.HOLD))
    if Contingency.SMART_RTL in contingencies_of(forecast):
        braking += find_shortfalls(ways, Contingency.SMART_RTL)
    if lands_by_choice(forecast):
        braking += find_shortfalls(ways, Contingency.LAND)
    if ways.why_unknown() is not None:
        return forecast, tuple(braking)
    if braking:  # needs another path
        return forecast, (*braking, *(one for one in find_return_shortfalls(ways) if one.part < ReturnLeg.RETURNS))
    best, short = forecast, find_return_shortfalls(ways)
    if not names_return_altitude(forecast.world) and (short or return_altitude(forecast) > highest_return(forecast)):
        best, short = change_return_altitude(ways, best, short)
    if any(one.part >= ReturnLeg.RETURNS for one in short) and not forecast.mission.rally:
        best, short = _with_rally_points(ways, best, short)
    return best, tuple(short)


def names_return_altitude(scenario: Scenario) -> bool:
    table = scenario.vehicle.autopilot.parameter_table
    return table.return_height.name in table.by_old_names(scenario.vehicle.autopilot_parameters())


def _with_rally_points(
    ways: ContingencyPaths, forecast: Forecast, short: list[Shortfall]
) -> tuple[Forecast, list[Shortfall]]:
    """Return the fewest rally points that make RTL clear with a slow landing."""
    for rally in rally_sets(ways.returning(forecast)):
        try:
            mission = slow_landings(replace(forecast.given, rally=rally), forecast.world)
        except Unsafe:
            continue
        landing = Forecast(mission, forecast.scenario, forecast.wind)
        left = find_return_shortfalls(ways.returning(landing))
        if not any(one.part >= ReturnLeg.RETURNS for one in left):
            return landing, left
    return forecast, short


def why_not_planned(forecast: Forecast) -> str:
    contingencies = forecast.cached(Contingencies)
    asked = [
        contingency
        for contingency in contingencies_of(forecast)
        if contingency is not Contingency.LAND or lands_by_choice(forecast)
    ]
    rows = [row for contingency in asked for row in contingencies.rows(contingency, timed=False) if not row.clear]
    worst = min(rows, key=lambda row: row.least_m - row.required_m)
    when = f"from {worst.from_s:.1f} to {worst.to_s:.1f} s after arming"
    if worst.contingency is Contingency.LAND:
        return f"LAND {when}, by {who_lands(forecast)}, is {worst.keeps}"
    where = ", where it brakes" if worst.contingency is Contingency.HOLD else ""
    kept = f"keeps {worst.least_m:.2f} m of {worst.to}{where}, {worst.required_m:.2f} m required"
    order = "SmartRTL" if worst.contingency is Contingency.SMART_RTL else "RTL"
    return f"{order} {when} {kept if math.isfinite(worst.least_m) else worst.to}"


def or_else(forecast: Forecast) -> str:
    returns = f"or {to_return_instead(forecast)}; " if lands_by_choice(forecast) else ""
    return f'{returns}or [safety] returns = "warn", to be warned only'


def planned_returns(forecast: Forecast) -> Iterator[str]:
    scenario, mission = forecast.world, forecast.mission
    name = mission.autopilot.parameter_table.return_height.name
    if name in forecast.given.parameters and not names_return_altitude(scenario):
        yield (
            f"RTL is clear from every second with {name} = {forecast.given.parameters[name]:g} in the vehicle "
            f"({scenario.name}.params; `fly --set-params` writes it)"
        )
    if len(mission.rally) > len(scenario.rally_points):
        places = (forecast.frame.local(replace(p, altitude=mission.home.altitude)) for p in mission.rally)
        words = "; ".join(f"east {east:.0f}, north {north:.0f} m" for east, north, _ in places)
        yield f"RTL is clear from every second by rally points, at {words}: they are uploaded with the mission"
    asked = scenario.safety.returns == "planned" and Contingency.LAND in contingencies_of(forecast)
    if asked and not lands_by_choice(forecast):
        yield from _lands_on(forecast)


def _lands_on(forecast: Forecast) -> Iterator[str]:
    """Yield how long a LAND may come down on an obstacle."""
    ways = forecast.cached(ContingencyPaths)
    samples = ways.samples(Contingency.LAND)
    names = list(dict.fromkeys(one.body or "the ground" for one in find_shortfalls(ways, Contingency.LAND, samples)))
    if names:
        lasts, whole = np.diff(samples.times), samples.times[-1] - samples.times[0]
        seconds = lasts[~(samples.clear[1:] & samples.clear[:-1])].sum()
        others = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        yield (
            f"LAND in place may, in {seconds:.0f} of {whole:.0f} s in the air, end "
            f"on or too near {', '.join(names[:NAMED])}{others} (`check --endings` says when)"
        )
