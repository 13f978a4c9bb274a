"""Plan the way home as a leg if the straight RTL is not clear."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingency.shortfalls import clear_in
from ipoa_mission.forecast.leg_limits import broken_limits
from ipoa_mission.scenario import Scenario

if TYPE_CHECKING:
    from ipoa_mission.routing.attempt import Attempt


class WayHomeBlocked(MissionError):
    """The straight way home is not clear at any altitude."""


def expect_way_home(attempt: "Attempt") -> None:
    """Raise WayHomeBlocked if a planned return is not clear, or the ground below if it may land."""
    scenario = attempt.scenario
    if scenario.safety.returns != "planned" or scenario.route.ending != "rtl" or leads_home(scenario):
        return
    if not attempt.is_guaranteed:
        return
    after = attempt.guarantee.flight.cruise_span[1]
    lands = any(shortfall.comes_down and shortfall.time > after for shortfall in attempt.short)
    returns = attempt.forecast.ways_home
    if lands or not clear_in(scenario)(returns) or any(broken_limits(leg, scenario) for leg in returns):
        raise WayHomeBlocked("the straight way home is not clear")


def by_way_of_the_goal(scenario: Scenario) -> Scenario:
    """Return the scenario with its goal as a via point, and a new one over home."""
    over_home = type(scenario.goal)(east=0.0, north=0.0, up=float(scenario.start_point[2]))
    return scenario.model_copy(update={"via": (*scenario.via, scenario.goal), "goal": over_home})


def leads_home(scenario: Scenario) -> bool:
    return bool((scenario.goal_point[:2] == 0.0).all())


def by_way_of_the_goal_remarks(scenario: Scenario, asked: Scenario) -> Iterator[str]:
    if leads_home(scenario) and not leads_home(asked):
        yield "the way home is planned by way of the goal, because the straight one is not clear"
