"""Search effort of the planner: an argument with defaults, so that a benchmark can vary it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LatticeStrategy:
    """Lattices of the guesses; `max_ways_climbing` applies with limited climbs."""

    nodes: int = 100_000  # about
    max_nodes_per_side: int = 200
    max_levels: int = 60  # without limited climbs
    min_slope: float = 0.07  # flatter climbs would need too many levels
    refinements: tuple[float, ...] = (1.0, 2.0, 3.0)  # of the spacing, each if the lattice before has no route
    max_ways: int = 24
    max_ways_climbing: int = 8
    max_cost_ratio: float = 1.6  # of a route to the cheapest
    max_ways_beside: int = 8  # added to those through gaps that are too narrow
    control_points_per_turn: int = 4
    max_control_points: int = 80  # of a guess


@dataclass(frozen=True)
class SearchStrategy:
    """Searches around the guesses; a width is a share of the varied length.

    >>> quick = SearchStrategy(straight_starts=1, lattice_starts=2, max_rounds=4)
    """

    lattice: LatticeStrategy = LatticeStrategy()
    straight_starts: int = 1  # searches from the straight line
    straight_width: float = 0.25
    lattice_starts: int = 5  # searches from lattice routes
    cheapest_starts: int = 4  # of these from the cheapest routes, the others from the best polished
    lattice_width: float = 0.08
    coarse_control_points: int = 100  # a curve with fewer may not follow its route
    closer_factor: int = 4  # factor on them for such a curve
    max_improved: int = 3  # curves searched again piece by piece
    max_rounds: int = 40
    piece: int = 10  # control points varied at a time
    piece_width: float = 0.12
    perturb: float = 0.08  # lateral bend of a piece, as a share of its length, both ways
    perturbed_control_points: int = 60  # least number in a perturbed curve
    least_gain: float = 1e-4  # relative gain that a bend must have
    enough_control_points: int = 150
    hidden_loop: float = 1.001  # ratio of cost to even-step cost above which control points are redistributed
    settled: int = 2  # valid curves to settle if the best of all is not valid
    max_settled: int = 6  # attempts for that


USUAL = SearchStrategy()
#: With many places to pass, each leg is short and has fewer options; attempts count for all legs.
MANY_LEGS = SearchStrategy(
    lattice=LatticeStrategy(nodes=30_000, max_ways=8, max_ways_climbing=4),
    lattice_starts=1,
    cheapest_starts=1,
    max_improved=1,
    max_rounds=12,
)
FEW_LEGS = 5  # greatest number for the usual strategy


def strategy_for(legs: int) -> SearchStrategy:
    return USUAL if legs <= FEW_LEGS else MANY_LEGS
