"""Choose a return altitude and rally points that make every contingency clear, unless the scenario names them."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.errors import Unsafe
from ipoa_mission.forecast.contingency.contingencies import (
    Contingencies,
    contingencies_of,
    lands_by_choice,
    to_return_instead,
    who_lands,
)
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import SAMPLING, ReturnLeg
from ipoa_mission.forecast.contingency.shortfalls import (
    Shortfall,
    find_return_shortfalls,
    find_shortfalls,
    highest_return,
    return_altitude,
    try_return_altitudes,
)
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Matrix, Points, Vector
from ipoa_mission.routing.repairs import slow_landings
from ipoa_mission.routing.resample import lefts
from ipoa_mission.scenario import Scenario

NAMED = 3  # in a note on LAND
RALLIED_ALTITUDES = 3  # at which rally points are tried


def choose_returns(forecast: Forecast) -> tuple[Forecast, tuple[Shortfall, ...]]:
    """Return the clearest forecast, and the worst remaining shortfall of each body."""
    paths = forecast.cached(ContingencyPaths)
    braking = list(find_shortfalls(paths, Contingency.HOLD))
    if Contingency.SMART_RTL in contingencies_of(forecast):
        braking += find_shortfalls(paths, Contingency.SMART_RTL)
    if lands_by_choice(forecast):
        braking += find_shortfalls(paths, Contingency.LAND)
    if paths.why_unknown() is not None:
        return forecast, tuple(braking)
    short = find_return_shortfalls(paths)
    if braking or any(shortfall.part < ReturnLeg.CLIMBS for shortfall in short):
        return forecast, (*braking, *(shortfall for shortfall in short if shortfall.part < ReturnLeg.RETURNS))
    tried = [(forecast, short)]
    if not names_return_altitude(forecast.world) and (short or return_altitude(forecast) > highest_return(forecast)):
        tried = try_return_altitudes(paths, forecast, short)
    if _of_returns(tried[0][1]) and not forecast.mission.rally:
        for result in tried[:RALLIED_ALTITUDES]:
            rallied = _with_rally_points(paths, *result)
            tried.append(rallied)
            if not _of_returns(rallied[1]):
                break
        tried.sort(key=lambda result: bool(_of_returns(result[1])))
    clearest, remaining = tried[0]
    return clearest, tuple(remaining)


def _of_returns(shortfalls: list[Shortfall]) -> list[Shortfall]:
    return [shortfall for shortfall in shortfalls if shortfall.part >= ReturnLeg.RETURNS]


def names_return_altitude(scenario: Scenario) -> bool:
    table = scenario.vehicle.autopilot.parameter_table
    return table.by_meaning["return height"].name in table.by_old_names(scenario.vehicle.autopilot_parameters())


def _with_rally_points(
    paths: ContingencyPaths, forecast: Forecast, short: list[Shortfall]
) -> tuple[Forecast, list[Shortfall]]:
    """Return the fewest rally points that make RTL clear with a slow landing."""
    search = _RallySearch(paths.returning(forecast), [shortfall.time for shortfall in _of_returns(short)])
    known = set[Shortfall]()
    for _ in range(EFFORT.max_proved):
        rally = search.propose()
        if rally is None:
            break
        try:
            mission = slow_landings(replace(forecast.mission_as_read, rally=rally), forecast.world)
        except Unsafe:
            continue
        rallied = Forecast(mission, forecast.scenario, forecast.wind)
        remaining = find_return_shortfalls(paths.returning(rallied))
        unclear = set(_of_returns(remaining))
        if not unclear:
            return rallied, remaining
        if unclear & known:  # wherever it returns to
            break
        known |= unclear
        search.add_samples([shortfall.time for shortfall in unclear])
    return forecast, short


def why_not_planned(forecast: Forecast) -> str:
    rows = [
        row
        for contingency in contingencies_of(forecast)
        if contingency is not Contingency.LAND or lands_by_choice(forecast)
        for row in forecast.cached(Contingencies).rows(contingency, timed=False)
        if not row.clear
    ]
    worst = min(rows, key=lambda row: row.least_m - row.required_m)
    when = f"from {worst.from_s:.1f} to {worst.to_s:.1f} s after arming"
    if worst.contingency is Contingency.LAND:
        return f"LAND {when}, by {who_lands(forecast)}, is {worst.keeps}"
    where = ", where it brakes" if worst.contingency is Contingency.HOLD else ""
    kept = f"keeps {worst.least_m:.2f} m of {worst.to}{where}, {worst.required_m:.2f} m required"
    order = "SmartRTL" if worst.contingency is Contingency.SMART_RTL else "RTL"
    return f"{order} {when} {kept if math.isfinite(worst.least_m) else worst.to}"


def other_options_hint(forecast: Forecast) -> str:
    returns = f"or {to_return_instead(forecast)}; " if lands_by_choice(forecast) else ""
    return f'{returns}or [safety] returns = "warn", to be warned only'


def return_remarks(forecast: Forecast) -> Iterator[str]:
    scenario, mission = forecast.world, forecast.mission
    name = mission.autopilot.parameter_table.by_meaning["return height"].name
    parameters = forecast.mission_as_read.parameters
    if name in parameters and not names_return_altitude(scenario):
        yield (
            f"RTL is clear from every second with {name} = {parameters[name]:g} in the vehicle "
            f"({scenario.name}.params; `fly --set-params` writes it)"
        )
    if len(mission.rally) > len(scenario.rally_points):
        places = (forecast.frame.local(replace(p, altitude=mission.home.altitude)) for p in mission.rally)
        words = "; ".join(f"east {east:.0f}, north {north:.0f} m" for east, north, _ in places)
        yield f"RTL is clear from every second by rally points, at {words}: they are uploaded with the mission"
    may_land = scenario.safety.returns == "planned" and Contingency.LAND in contingencies_of(forecast)
    if may_land and not lands_by_choice(forecast):
        yield from _lands_on(forecast)


def _lands_on(forecast: Forecast) -> Iterator[str]:
    paths = forecast.cached(ContingencyPaths)
    samples = paths.samples(Contingency.LAND)
    shortfalls = find_shortfalls(paths, Contingency.LAND, samples)
    names = list(dict.fromkeys(shortfall.body or "the ground" for shortfall in shortfalls))
    if names:
        is_clear = samples.clear[1:] & samples.clear[:-1]
        unclear_s = np.diff(samples.times)[~is_clear].sum()
        in_air_s = samples.times[-1] - samples.times[0]
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        yield (
            f"LAND in place may, in {unclear_s:.0f} of {in_air_s:.0f} s in the air, end "
            f"on or too near {', '.join(names[:NAMED])}{more} (`check --contingencies` says when)"
        )


class RallyEffort(NamedTuple):
    max_points: int = 4
    max_proved: int = 6  # sets
    beam: int = 8  # sets of each size that are extended
    place_step: float = 25.0  # along the path [m]
    lateral_distances: tuple[float, ...] = (0.0, 15.0, 30.0)  # from the path [m]
    landing_clearance: float = 2.0  # around a landing place [m]
    sample_count: int = 60
    sample_step: float = 0.5  # next to a shortfall [s]
    min_separation: float = 12.0  # of home and rally points [m]: PX4 ignores those within 10 m of home


EFFORT = RallyEffort()


class _RallySearch:
    """Search the fewest rally points that make returns from sampled instants clear."""

    _margins: NDArray[np.float64]  # of returns from each instant to each goal [m]
    _away: NDArray[np.float64]  # horizontal distances of goals [m]

    def __init__(self, paths: ContingencyPaths, times: list[float]) -> None:
        self._paths = paths
        self._tried = set[tuple[int, ...]]()
        self._goals = np.vstack([np.zeros(3), _with_room(paths, _places(paths))])
        self._sample(np.unique([*np.linspace(*paths.in_air, EFFORT.sample_count), *times]))
        if paths.forecast.mission.items[-1].command == Command.NAV_RETURN_TO_LAUNCH:
            end_of_cruise = int(np.searchsorted(self._times, paths.flight.cruise_span[1]))
            reachable = self._margins[min(end_of_cruise, len(self._times) - 1)] >= 0.0
            reachable[0] = True
            self._goals = self._goals[reachable]
            self._margins = self._margins[:, reachable]
            self._away = self._away[:, reachable]

    def add_samples(self, times: list[float]) -> None:
        """Sample next to the times [s] of shortfalls, which lie between the samples."""
        beside = EFFORT.sample_step * np.arange(-1, 2)
        self._sample(np.unique([*self._times, *np.clip(np.add.outer(times, beside), *self._paths.in_air).ravel()]))

    def _sample(self, times: Vector) -> None:
        places, stopped = self._paths.stops().at(times)
        height = self._paths.returns(places, stopped, self._paths.stops().seqs_at(times))[0][:, 0, 3, 2]
        self._times = times
        self._margins = _margins(self._paths, stopped, height, self._goals)
        self._away = np.linalg.norm(stopped[:, None, :2] - self._goals[None, :, :2], axis=2)

    def propose(self) -> tuple[Geodetic, ...] | None:
        """Return the smallest new set with the greatest least margin, by beam search."""
        beam: list[tuple[int, ...]] = [(0,)]
        for _ in range(min(EFFORT.max_points, len(self._goals) - 1)):
            ranks = dict[tuple[int, ...], tuple[int, float]]()
            for chosen in beam:
                least = _least_margins(self._margins, self._away, chosen)
                unserved = np.count_nonzero(least < 0.0, axis=0)
                worst = least.min(axis=0)
                for n in np.lexsort((-worst, unserved))[: EFFORT.beam].tolist():
                    if n not in chosen:
                        ranks[tuple(sorted((*chosen, n)))] = int(unserved[n]), -float(worst[n])
            beam = sorted(ranks, key=lambda chosen: (ranks[chosen], chosen))[: EFFORT.beam]
            for chosen in beam:
                if ranks[chosen][0] == 0 and chosen not in self._tried:
                    self._tried.add(chosen)
                    return tuple(_rally_point(self._paths.forecast, self._goals[n]) for n in chosen[1:])
        return None


def _least_margins(margins: NDArray[np.float64], away: NDArray[np.float64], chosen: tuple[int, ...]) -> Matrix:
    """Return the least margin of possible returns at instants (n,) to `chosen` goals and one of all goals (m,)."""
    farthest = np.minimum(away, away[:, chosen].min(axis=1, keepdims=True)) + 2 * SAMPLING.position_error
    least = np.where(away <= farthest, margins, np.inf)
    for goal in chosen:
        least = np.where(away[:, [goal]] <= farthest, np.minimum(least, margins[:, [goal]]), least)
    return least


def _margins(paths: ContingencyPaths, stopped: Points, height: NDArray[np.float64], goals: Points) -> Matrix:
    """Return the margins [m] of level legs from places (n, 3) to goals (m, 3), (n, m)."""
    starts = np.repeat(np.column_stack([stopped[:, :2], height]), len(goals), axis=0)
    ends = np.column_stack([np.tile(goals[:, :2], (len(stopped), 1)), starts[:, 2]])
    near, _ = paths.enlarged.whole.legs_clearance(starts, ends, paths.required + SAMPLING.max_slack)
    return np.asarray(near - paths.required).reshape(len(stopped), len(goals))


def _places(paths: ContingencyPaths) -> Points:
    track = paths.flight.pieces.points
    traveled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(track[:, :2], axis=0).T))])
    stations = np.arange(0.0, traveled[-1] + EFFORT.place_step, EFFORT.place_step)
    spots = np.column_stack([np.interp(stations, traveled, track[:, k]) for k in range(2)])
    aside = lefts(spots)[:, :2] if len(spots) > 1 else np.zeros_like(spots)
    spaced = np.zeros((1, 2))
    for distance in EFFORT.lateral_distances:
        for sign in (1.0, -1.0) if distance else (1.0,):
            for spot in spots + sign * distance * aside:
                if np.hypot(*(spot - spaced).T).min() >= EFFORT.min_separation:
                    spaced = np.vstack([spaced, spot])
    return np.column_stack([spaced[1:], paths.forecast.world.airspace.ground(spaced[1:])])


def _with_room(paths: ContingencyPaths, places: Points) -> Points:
    if not len(places):
        return places
    air = paths.enlarged.whole
    top = np.column_stack([places[:, :2], np.full(len(places), air.bounds.upper[2])])
    near, _ = air.legs_clearance(top, places, paths.required + EFFORT.landing_clearance)
    middle = (air.bounds.lower[2] + air.bounds.upper[2]) / 2
    inside = air.bounds.margin(np.column_stack([places[:, :2], np.full(len(places), middle)]))
    return places[(near >= paths.required + EFFORT.landing_clearance) & (inside > 0.0)]


def _rally_point(forecast: Forecast, place: np.ndarray) -> Geodetic:
    there = forecast.frame.geodetic(place)
    above = round(there.altitude - forecast.mission.home.altitude, 3)
    return Geodetic(round(there.latitude_deg, 7), round(there.longitude_deg, 7), above)
