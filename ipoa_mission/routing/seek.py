"""A path with room for the tube: sought where there is room all round first, then through the gaps that are left."""

from dataclasses import replace

from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.planner import NoPath, plan_path
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.planning.search import Progress
from ipoa_mission.routing.assemble import Option, weigh_routes
from ipoa_mission.scenario import Scenario
from ipoa_mission.tube.room import with_room


def plan_with_room(scenario: Scenario, seed: int, progress: Progress) -> tuple[Plan, tuple[Option, ...]]:
    """A plan and what each mode of choosing waypoints would come to on it, quickest first.

    Raises:
        BadInput: the optimiser is unknown, or has no such setting; start and goal are the same place.
        NoPath: a given place breaks a limit, or no path was found that keeps them all.
    """
    if scenario.safety.chance is None:
        plan = plan_path(scenario, seed, progress)
        return plan, weigh_routes(plan, scenario)
    found: list[tuple[Plan, tuple[Option, ...]]] = []
    for keep_gaps in (False, True):
        roomy = with_room(scenario, keep_gaps)
        try:
            plan = plan_path(roomy, seed, progress)
        except NoPath:
            if keep_gaps and not found:
                raise
            continue
        plan = replace(plan, cost=curve_cost(plan.curve, scenario), proof=prove_curve(plan.curve, scenario))
        found.append((plan, weigh_routes(plan, scenario)))
        if any(option.mode == scenario.route.mode for option in found[-1][1]):
            return found[-1]
    return found[-1]
