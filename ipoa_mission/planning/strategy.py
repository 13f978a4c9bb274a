"""How hard the planner looks for a path: an argument with defaults, so that a benchmark can sweep it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LatticeStrategy:
    """The lattices that guesses come from; `max_ways_climbing` where climbs are limited."""

    nodes: int = 100_000  # about as many
    max_nodes_per_side: int = 200
    max_levels: int = 60  # where climbs are not limited
    min_slope: float = 0.07  # flatter climbs would need too many levels
    refinements: tuple[float, ...] = (1.0, 2.0, 3.0)  # of the spacing, where the lattice before knows no way
    max_ways: int = 24
    max_ways_climbing: int = 8
    max_cost_ratio: float = 1.6  # of a way over the cheapest
    max_ways_beside: int = 8  # added beside those that lead through what is too narrow
    control_points_per_turn: int = 4
    max_control_points: int = 80  # of a guess


@dataclass(frozen=True)
class SearchStrategy:
    """The searches round the guesses; a width is a share of the length of what is varied.

    >>> quick = SearchStrategy(straight_starts=1, lattice_starts=2, max_rounds=4)
    """

    lattice: LatticeStrategy = LatticeStrategy()
    straight_starts: int = 1  # searches that begin at the straight line
    straight_width: float = 0.25
    lattice_starts: int = 5  # searches that begin at lattice ways
    cheapest_starts: int = 4  # of these at the lattice's cheapest, the others at those best polished
    lattice_width: float = 0.08
    coarse_control_points: int = 100  # with fewer a curve may not be able to follow a way
    closer_factor: int = 4  # times as many let it
    max_improved: int = 3  # curves that are searched again piece by piece
    max_rounds: int = 40
    piece: int = 10  # control points that are then varied at a time
    piece_width: float = 0.12
    perturb: float = 0.08  # share of its length that a piece is then bent aside by, both ways,
    kicked_control_points: int = 60  # of curves with so many
    least_gain: float = 1e-4  # of the cost, that such a bend must save
    enough_control_points: int = 150
    hidden_loop: float = 1.001  # a curve that costs so many times what even steps see of it is set out anew
    settled: int = 2  # curves that hold when they are settled, where the best of all does not, and
    max_settled: int = 6  # how many are tried for that


USUAL = SearchStrategy()
#: Over many places to pass each leg is short, and there is less to choose from on it: what is tried is for all legs.
MANY_LEGS = SearchStrategy(
    lattice=LatticeStrategy(nodes=30_000, max_ways=8, max_ways_climbing=4),
    lattice_starts=1,
    cheapest_starts=1,
    max_improved=1,
    max_rounds=12,
)
FEW_LEGS = 5  # for which the usual strategy is taken


def strategy_for(legs: int) -> SearchStrategy:
    """The strategy for a path of so many legs between places to pass."""
    return USUAL if legs <= FEW_LEGS else MANY_LEGS
