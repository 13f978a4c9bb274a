"""The way home as a leg like any other: planned, where the straight one of an RTL is not clear."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ipoa_mission.checks.airspace_check import broken
from ipoa_mission.checks.way_home import clear_in
from ipoa_mission.errors import MissionError
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.place_sections import Place

if TYPE_CHECKING:
    from ipoa_mission.routing.attempt import Attempt


class WayHomeBlocked(MissionError):
    """The straight way home of a mission that ends in RTL is not clear, at whatever altitude."""


def expect_way_home(attempt: "Attempt") -> None:
    """See that the own return of a mission whose endings are planned is clear, and what is below it, if it may land.

    Raises:
        WayHomeBlocked: it is not.
    """
    scenario = attempt.scenario
    if scenario.safety.returns != "planned" or scenario.route.ending != "rtl" or leads_home(scenario):
        return
    if not attempt.is_promised:
        return
    after = attempt.promise.flight.way[1]
    lands = any(one.comes_down and one.time > after for one in attempt.short)
    ways = attempt.forecast.ways_home
    if lands or not clear_in(scenario)(ways) or any(broken(way, scenario) for way in ways):
        raise WayHomeBlocked("the straight way home is not clear")


def by_way_of_the_goal(scenario: Scenario) -> Scenario:
    """The scenario with its goal as a via point, and over home, as high as the start, as its goal."""
    over_home = Place(east=0.0, north=0.0, up=float(scenario.start_point[2]))
    return scenario.model_copy(update={"via": (*scenario.via, scenario.goal), "goal": over_home})


def leads_home(scenario: Scenario) -> bool:
    """Whether its goal is over home."""
    return bool((scenario.goal_point[:2] == 0.0).all())


def planned_way_home(scenario: Scenario, asked: Scenario) -> Iterator[str]:
    """That the way home was planned, where it was."""
    if leads_home(scenario) and not leads_home(asked):
        yield "the way home is planned as the way out is, by way of the goal: the straight one is not clear"
