"""Quick searches, for tests of what becomes of a plan."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any, TypeVar

from ipoa_mission.planning.lattice import LatticeStrategy
from ipoa_mission.planning.planner import SearchStrategy, plan_path
from ipoa_mission.routing.fastest import RouteGrid, RouteSearch

T = TypeVar("T")
QUICK = SearchStrategy(LatticeStrategy(nodes=20_000), lattice_starts=2, max_rounds=4, enough_proved=1)
FEW = RouteGrid(straight_shares=(1.0, 0.3), turn_radii=(0.0, 7.0), spline_shares=(0.4,), spline_spacings=(25.0,))


def put(name: str, value: object) -> None:
    """Set a name as `setattr` of a monkeypatch does, for the process."""
    module, _, attribute = name.rpartition(".")
    setattr(import_module(module), attribute, value)


def search_quickly(patch: Callable[[str, object], None] = put) -> None:
    """Hasten `plan_flight` and the command line; `patch`: `setattr` of a monkeypatch."""
    patch("ipoa_mission.routing.seek.plan_path", partial(plan_path, strategy=QUICK))
    patch("ipoa_mission.routing.fastest.GRID", FEW)
    patch("ipoa_mission.routing.fastest.SEARCH", RouteSearch(starts=1, trials=20))


def once(answer: Callable[..., T], asked: Callable[..., object]) -> Callable[..., T]:
    """Cache answers by `asked` of the arguments."""
    answers = list[tuple[object, T]]()

    def remembering(*arguments: Any) -> T:
        question = asked(*arguments)
        for earlier, answered in answers:
            if earlier == question:
                return answered
        answers.append((question, answer(*arguments)))
        return answers[-1][1]

    return remembering
