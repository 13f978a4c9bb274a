"""The way home from the middle of a mission: RTL, by hand or by a failsafe, from wherever on its path it is ordered.

The vehicle flies on until it has braked, climbs to its return altitude and flies home straight, whatever stands there.
For a short piece of the path all these ways together are three flat bodies: where it brakes, where it climbs, and the
triangle to home. Their distance to obstacles is a bound; where it is too small, the ways from the piece's ends are
proved. Over the ground ways are looked at from every few meters. PX4 flies back to where it was ordered home while it
climbs: its ways begin at five places between there and where it stood.
"""

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.checks.way_home import HEIGHT_STEP
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.stops import Stops, stops_of
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.planning.proof import Check, prove_heights
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import nearest_of

GROUND_EVERY = 3.0  # over the ground the way home is looked at from places so far apart [m]
ROUNDING = 0.02  # [m]
MOST_PIECES = 800  # that a path is cut into
MOST_LOOKS = 200  # at the ground
MOST_TRIES = 6  # return altitudes
BACK = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of the way back to where PX4 was ordered home, at which it may turn home
BRAKES, CLIMBS, RETURNS = range(3)


@dataclass(frozen=True)
class Broken:
    """A limit that is broken if RTL is ordered on the way to item `seq`; `part` is `BRAKES`, `CLIMBS` or `RETURNS`."""

    seq: int
    part: int
    check: Check


def check_failsafe_return(forecast: Forecast) -> Iterator[Finding]:
    """A warning where the vehicle, ordered home, would come nearer to something than the scenario allows."""
    if len((stops := stops_of(forecast)).seqs) < 2:
        return
    broken = list(_once(broken_returns(forecast, stops)))
    for going, verb, order in ((False, "brakes and climbs", "RTL or pause"), (True, "flies home", "RTL")):
        some = [one for one in broken if (one.part == RETURNS) is going]
        if some:
            worst = min(some, key=lambda one: one.check.slack)
            message = f"{_items_in_words(some)}: {order} on the way there {verb} {worst.check.words()}"
            yield Finding(
                "return-too-near",
                Severity.WARNING,
                worst.seq,
                message,
                _remedy(forecast, stops, some) if going else None,
            )


def broken_returns(
    forecast: Forecast, stops: Stops, parts: Collection[int] = (BRAKES, CLIMBS, RETURNS)
) -> Iterator[Broken]:
    """What breaks a limit in `parts` of the returns from the way to each item, one of each, not always the worst."""
    scenario = forecast.world
    for ways in forecast.returns_from(stops.stands):
        sheets = _Sheets(stops, ways[:, 1:], forecast.mission.autopilot.guidance.climbs_coming_back)
        yield from sheets.near_obstacles(scenario, parts)
        yield from sheets.near_the_ground(scenario, parts)


@dataclass(frozen=True, eq=False)
class _Sheets:
    """Ways home to one goal, `ways` (n, 2, 3): over where the vehicle stands, and over the goal.

    `comes_back`: it flies back to where it was ordered home while it climbs, as PX4 does.
    """

    stops: Stops
    ways: NDArray[np.float64]
    comes_back: bool

    def near_obstacles(self, scenario: Scenario, parts: Collection[int]) -> Iterator[Broken]:
        """One for each item and part."""
        obstacles, required = scenario.airspace.obstacles, scenario.limits.obstacle_distance - ROUNDING
        base, top = np.array([body.bounds[:, 2] for body in obstacles]).reshape(-1, 2).T
        for part in parts:
            outlines, low, high = self._bodies(part)
            in_reach = np.flatnonzero((base < high.max() + required) & (top > low.min() - required))
            plans = np.array([obstacles[n].plan for n in in_reach])
            pieces, others = shapely.STRtree(plans).query(outlines, "dwithin", required)
            over = np.maximum(base[in_reach[others]] - high[pieces], low[pieces] - top[in_reach[others]])
            bound = np.hypot(shapely.distance(outlines[pieces], plans[others]), np.maximum(over, 0.0))
            settled, doubtful = set[int](), np.argsort(bound, kind="stable")[: np.count_nonzero(bound < required)]
            for piece in dict.fromkeys(pieces[doubtful].tolist()):
                first = piece * self._step
                if (seq := int(self.stops.seqs[first])) not in settled:
                    ends = (first, min(first + self._step, len(self.ways) - 1))
                    near = [obstacles[n] for n in in_reach[others[pieces == piece]]]
                    distances = (nearest_of(near, *way) for k in ends for way in self._ways(k, part))
                    nearest = min(distances, key=lambda clearance: clearance.distance)
                    check = Check("obstacles", nearest, scenario.limits.obstacle_distance)
                    if check.slack < -ROUNDING:
                        settled.add(seq)
                        yield Broken(seq, part, check)

    def near_the_ground(self, scenario: Scenario, parts: Collection[int]) -> Iterator[Broken]:
        """Its limits on the way home and while it brakes."""
        gone = arc_lengths(self.stops.stands)
        _, looked_at = np.unique(np.floor(gone / max(GROUND_EVERY, gone[-1] / MOST_LOOKS)), return_index=True)
        seqs = self.stops.seqs[looked_at]
        for seq in np.unique(seqs):
            some = looked_at[seqs == seq]
            for part in (part for part in (BRAKES, RETURNS) if part in parts):
                way = np.concatenate([way for k in some for way in self._ways(k, part)])
                for check in prove_heights(way, scenario):
                    if check.limit == "ground" and check.slack < -ROUNDING:
                        yield Broken(int(seq), part, check)

    def _ways(self, k: int, part: int) -> list[Points]:
        """The ways of one part on which it may be from place number `k`, each (2, 3)."""
        place, stand = self.stops.places[k], self.stops.stands[k]
        if part == BRAKES:
            return [np.stack((place, stand))]
        below_top = (stand, *self.ways[k])[part - 1 : part + 1]
        back = np.array([*(place - stand)[:2], 0.0])
        turns = BACK if self.comes_back else BACK[:1]
        return [
            np.stack((below_top[0] + t * back, below_top[1] + (t * back if part == CLIMBS else 0.0))) for t in turns
        ]

    @property
    def _step(self) -> int:
        """So many places make a piece of the path."""
        return math.ceil(len(self.stops.seqs) / MOST_PIECES)

    def _bodies(self, part: int) -> tuple[NDArray[np.object_], Vector, Vector]:
        """Outlines around what is flown in one part from each piece (m,), and from which height to which (m,) [m]."""
        corners = [self.stops.places, self.stops.stands, self.ways[:, 0], self.ways[:, 1]][part : part + 2]
        heights = np.stack([points[:, 2] for points in corners], axis=1)
        if self.comes_back:
            corners = [self.stops.places, *corners]
        firsts = np.arange(0, len(self.stops.seqs) - 1, self._step)
        around = np.minimum(firsts[:, None] + np.arange(self._step + 1), len(self.stops.seqs) - 1)
        flown = np.concatenate([points[around, :2] for points in corners], axis=1)
        low, high = heights[around].min(axis=(1, 2)), heights[around].max(axis=(1, 2))
        return np.asarray(shapely.convex_hull(shapely.multipoints(flown))), low, high


def _once(broken: Iterable[Broken]) -> Iterator[Broken]:
    """Without a way home that is too near to something only where the vehicle brakes."""
    nearest: dict[tuple[int, str], float] = {}
    for one in broken:
        key = one.seq, one.check.nearest.what
        if one.check.slack < nearest.get(key, 0.0) - ROUNDING:
            nearest[key] = one.check.slack
            yield one


def _remedy(forecast: Forecast, stops: Stops, broken: list[Broken]) -> str | None:
    """A return altitude, a multiple of five meters, at which the way home is clear from everywhere."""
    mission, scenario = forecast.mission, forecast.world
    by = mission.autopilot.book.return_height
    height, tops = 0.0, {body.name: float(body.bounds[1, 2]) for body in scenario.airspace.obstacles}
    for _ in range(MOST_TRIES):
        wanted = max(_height_over(one.check, tops) for one in broken)
        height = max(height + HEIGHT_STEP, HEIGHT_STEP * math.ceil(wanted / HEIGHT_STEP))
        higher = Forecast(mission.with_parameters({by.name: by.spelled(height)}), scenario)
        if not (broken := list(broken_returns(higher, stops, (RETURNS,)))):
            highest = scenario.airspace.bounds.upper[2]
            beyond = f" (above the upper bound of {highest:g} m)" if height > highest else ""
            set_to = f"{by.name} = {by.spelled(height):.0f}{beyond}"
            return f"{set_to} makes it clear, in the vehicle and under [vehicle.parameters]"
    return None


def _height_over(check: Check, tops: dict[str, float]) -> float:
    place = check.nearest.place[2]
    return tops[check.nearest.what] + check.required if check.limit == "obstacles" else place - check.slack


def _items_in_words(broken: list[Broken]) -> str:
    """Items 3, 4, 5 and 7 are "items 3 to 5, 7"."""
    seqs = np.unique([one.seq for one in broken])
    runs = np.split(seqs, np.flatnonzero(np.diff(seqs) > 1) + 1)
    words = ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs)
    return f"item{'' if len(seqs) == 1 else 's'} {words}"
