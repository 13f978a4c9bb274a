"""What a route keeps of the scenario's limits as it will be flown: in straight legs, or along its spline's curves."""

import numpy as np

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.legs import join
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.routing.build import draft_mission, items_of_waypoints
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario


def prove_route(route: Route, scenario: Scenario, spare: float = np.inf) -> Proof:
    """The proof from the first waypoint to the last; `spare` as for `prove`."""
    if not route.spline:
        return prove(route.points, scenario, spare=spare)
    between = {index + 1 for index in items_of_waypoints(route)[1:]}
    legs = [leg for leg in Forecast(draft_mission(route, scenario), scenario).cruise if leg.seq in between]
    points, stray = join(legs)
    return prove(points, scenario, stray, spare)
