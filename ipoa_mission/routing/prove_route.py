"""What a route keeps of the scenario's limits as it will be flown: in straight legs, or along its spline's curves."""

import numpy as np

from ipoa_mission.items import Mission
from ipoa_mission.itinerary.legs import Leg, Phase, flown_legs, join
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.routing.build import draft_mission, starts_over_home
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario


def prove_route(route: Route, scenario: Scenario, spare: float = np.inf) -> Proof:
    """The proof from the first waypoint to the last; `spare` as for `prove`."""
    if not route.spline:
        return prove(route.points, scenario, spare=spare)
    mission = draft_mission(route, scenario)
    before = 0 if starts_over_home(route) else 1  # the leg from the take-off to the first waypoint
    legs = cruise(mission, scenario)[before : before + len(route.points) - 1]
    points, stray = join(legs)
    return prove(points, scenario, stray, spare)


def prove_mission(mission: Mission, scenario: Scenario) -> Proof:
    """The proof from the end of the take-off to the last waypoint."""
    points, stray = join(cruise(mission, scenario))
    return prove(points, scenario, stray)


def cruise(mission: Mission, scenario: Scenario) -> list[Leg]:
    """The legs between waypoints that are flown in any case."""
    legs = flown_legs(mission, scenario.frame, scenario.airspace.ground)
    return [leg for leg in legs if leg.phase is Phase.CRUISE and not leg.alternative]
