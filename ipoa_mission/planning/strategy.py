"""Search effort of the planner."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LatticeStrategy:
    """`max_ways_climbing`: with limited climbs."""

    nodes: int = 100_000
    max_nodes_per_side: int = 200
    max_levels: int = 60  # without limited climbs
    min_slope: float = 0.07  # flatter climbs would need too many levels
    refinements: tuple[float, ...] = (1.0, 2.0, 3.0)  # of the spacing, each if the one before has no route
    max_ways: int = 24
    max_ways_climbing: int = 8
    max_cost_ratio: float = 1.6  # of a route to the cheapest
    max_ways_beside: int = 8  # besides those through narrow gaps
    control_points_per_turn: int = 4
    max_control_points: int = 80


@dataclass(frozen=True)
class SearchStrategy:
    """A width is a share of the varied length.

    >>> quick = SearchStrategy(straight_starts=1, lattice_starts=2, max_rounds=4)
    """

    lattice: LatticeStrategy = LatticeStrategy()
    straight_starts: int = 1  # searches
    straight_width: float = 0.25
    lattice_starts: int = 2  # searches
    cheapest_starts: int = 1  # the others from the best polished
    lattice_width: float = 0.08
    coarse_control_points: int = 100  # fewer may not follow the route
    closer_factor: int = 4
    max_improved: int = 2  # piece by piece
    max_rounds: int = 4
    piece: int = 10
    piece_width: float = 0.12
    enough_control_points: int = 150
    few_control_points: int = 60  # of a polished curve, which is refined once more
    hidden_loop: float = 1.001  # of cost to even-step cost; control points are redistributed above
    enough_proved: int = 2  # if the best of all is not valid
    max_polished: int = 6


USUAL = SearchStrategy()
# Each of many legs is short and has fewer options.
MANY_LEGS = SearchStrategy(
    lattice=LatticeStrategy(nodes=30_000, max_ways=8, max_ways_climbing=4),
    lattice_starts=1,
    cheapest_starts=1,
    max_improved=1,
    max_rounds=12,
)
FEW_LEGS = 5  # for the usual strategy


def strategy_for(legs: int) -> SearchStrategy:
    return USUAL if legs <= FEW_LEGS else MANY_LEGS
