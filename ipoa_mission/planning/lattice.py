"""Quick guesses: a coarse lattice over the airspace, and the distinct ways through it.

The cheapest way from the start to a node and from it to the goal are known for all nodes after two runs of Dijkstra's
algorithm. Where their sum is locally least on the surfaces a quarter, half and three quarters of the way, another
passage between the obstacles begins.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from ipoa_mission.geometry import Points, Vector, leg_lengths
from ipoa_mission.planning.limits import places
from ipoa_mission.planning.problem import PathProblem, Trail, follow

NODES = 60_000  # about how many nodes a lattice has
FINER = (1.0, 2.0, 3.0)  # how much finer the next lattice is if one knows no way
MOST = 8  # ways that are returned
DEAREST = 1.6  # ways dearer than the cheapest by this factor are left out


@dataclass(frozen=True, eq=False)
class Lattice:
    """Nodes from `corner` in steps of `spacing` (3,); `slack` and `price` are (nx, ny, nz).

    Slack is what a node has more than the required clearance [m]; the price is the cost per metre, infinite where
    slack is negative.
    """

    corner: Vector
    spacing: Vector
    slack: NDArray[np.float64]
    price: NDArray[np.float64]

    def nearest(self, point: Vector) -> int:
        """The free node nearest to a point, by its flat number."""
        free = np.nonzero(np.isfinite(self.price.ravel()))[0]
        return int(free[np.argmin(((self.place(free) - point) ** 2).sum(axis=1))])

    def place(self, node: NDArray[np.intp]) -> Points:
        """Where nodes (n,) are, (n, 3)."""
        return self.corner + self.spacing * np.column_stack(np.unravel_index(node, self.price.shape))


def guesses(problem: PathProblem, coarsest: int) -> list[Trail]:
    """Curves from start over all via points to the goal: the straight one, then those that follow lattice ways.

    Lattices before number `coarsest` of `FINER` are not tried.
    """
    scenario = problem.scenario
    straight = places(scenario)
    inner = max(scenario.planning.control_points, 3, 5 * (len(straight) - 1))
    found: list[Points] = []
    for fineness in FINER[coarsest:]:
        lattice = lay(problem, fineness)
        if found := ways(lattice, problem, MOST):
            break
    turns = max((_turns(way, 2 * lattice.spacing[0]) for way in found), default=0)
    inner = int(min(max(inner, 4 + 2 * turns), 40))
    return [follow(guide, inner, scenario) for guide in (straight, *found)]


def lay(problem: PathProblem, fineness: float = 1.0) -> Lattice:
    """A lattice over the bounds; `fineness` 2 has half the spacing on the map."""
    from ipoa_mission.planning._kernels import survey

    lower, upper = _region(problem)
    size = upper - lower
    pitch = max((size[0] * size[1] * max(size[2], 1e-3) / NODES) ** (1 / 3), size[:2].max() / 120) / fineness
    limits = problem.rules
    rise = min(pitch * min(limits.climb, limits.descent, 1.0), max(size[2] / 6, 0.5))
    count = np.maximum(np.ceil(size / (pitch, pitch, rise)).astype(int), 1) + 1
    spacing = size / (count - 1)
    nodes = lower + spacing * np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 3)
    slack, threat = survey(nodes, problem.chart, problem.rules)
    price = np.where(slack >= 0, problem.rules.length + threat, np.inf)
    return Lattice(lower, spacing, slack.reshape(count), price.reshape(count))


def ways(lattice: Lattice, problem: PathProblem, most: int) -> list[Points]:
    """Up to `most` distinct ways from start over all via points to the goal, (k, 3) each, the cheapest first.

    Empty if the lattice knows no way.
    """
    stops = places(problem.scenario)
    legs = [_leg_ways(lattice, a, b, most) for a, b in pairwise(stops)]
    if not all(legs):
        return []
    cheapest = [leg[0] for leg in legs]
    variants = [cheapest] + [
        [*cheapest[:i], other, *cheapest[i + 1 :]] for i, leg in enumerate(legs) for other in leg[1:]
    ]
    return [np.vstack([variant[0], *(way[1:] for way in variant[1:])]) for variant in variants[:most]]


def _leg_ways(lattice: Lattice, start: Vector, goal: Vector, most: int) -> list[Points]:
    from ipoa_mission.planning._kernels import spread

    if not np.isfinite(lattice.price).any():
        return []
    source, target = lattice.nearest(start), lattice.nearest(goal)
    there, before = spread(lattice.price, lattice.spacing, source)
    back, after = spread(lattice.price, lattice.spacing, target)
    if not np.isfinite(there[target]):
        return []
    through = there + back
    found: list[Points] = []
    nodes = [target, *_passages(through, there, lattice.price.shape)]
    for node in nodes:
        way = np.array([*_trace(before, node)[::-1], *_trace(after, node)[1:]])
        points = np.vstack([start, lattice.place(way), goal])
        if all(_apart(points, other) > 3 * lattice.spacing[0] for other in found):
            found.append(points)
        if len(found) == most:
            break
    return found


def _passages(through: Vector, there: Vector, shape: tuple[int, ...]) -> Iterator[int]:
    """Nodes at which a way through is cheaper than through any node around, the cheapest first."""
    best = through[np.isfinite(through)].min()
    share = np.divide(there, through, out=np.zeros_like(there), where=np.isfinite(through) & (through > 0))
    chosen: list[tuple[float, int]] = []
    for middle in (0.25, 0.5, 0.75):
        on_surface = (np.abs(share - middle) < 0.04) & (through < DEAREST * best)
        surface = np.where(on_surface, through, np.inf).reshape(shape)
        least = (surface == minimum_filter(surface, size=5, mode="nearest")) & np.isfinite(surface)
        chosen += [(float(through[node]), int(node)) for node in np.nonzero(least.ravel())[0]]
    return (node for _, node in sorted(chosen))


def _trace(before: NDArray[np.int64], node: int) -> list[int]:
    way = [node]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return way


def _apart(a: Points, b: Points) -> float:
    """The greatest distance between points at the same share of two polylines."""
    return float(np.linalg.norm(_even(a) - _even(b), axis=1).max())


def _even(points: Points, count: int = 24) -> Points:
    travelled = np.concatenate([[0.0], np.cumsum(leg_lengths(points))])
    return np.column_stack([np.interp(np.linspace(0, travelled[-1], count), travelled, points[:, k]) for k in range(3)])


def _turns(way: Points, tolerance: float) -> int:
    """How many corners a way has if it may be shortened within a tolerance [m] (Douglas and Peucker)."""
    return len(shapely.simplify(shapely.LineString(way[:, :2]), tolerance, preserve_topology=False).coords) - 2


def _region(problem: PathProblem) -> tuple[Vector, Vector]:
    """The part of the bounds that matters: above everything that stands there is nothing to find."""
    scenario, limits = problem.scenario, problem.limits
    airspace, stops = scenario.airspace, places(scenario)
    tops = [obstacle.bounds[1, 2] for obstacle in airspace.obstacles]
    above = 2 * max(limits.obstacle_distance, problem.rules.d_safe)
    highest = max([*tops, float(problem.chart.heights.max()), float(stops[:, 2].max())]) + above
    lower, upper = np.asarray(airspace.bounds.lower, float), np.asarray(airspace.bounds.upper, float)
    lowest = max(lower[2], float(problem.chart.heights.min()) + min(limits.height_above_ground, 1.0))
    lower = np.array([lower[0], lower[1], min(lowest, float(stops[:, 2].min()))])
    return lower, np.array([upper[0], upper[1], min(upper[2], highest)])
