"""The legs of a mission against the world of a scenario, by the same proof that the planner's path went through."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.checks.numbered_finding import item_of, leg_name
from ipoa_mission.checks.way_home import remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg, Phase
from ipoa_mission.planning.proof import Check, prove
from ipoa_mission.scenario import Scenario

#: What rounding positions to 1e-7 degrees and to millimetres may cost, by unit.
ROUNDING = {"m": 0.02, "deg": 0.5}
SAME_HOME = 1.0  # [m]

ANGLES = {"climb", "descent"}

#: The limits that each kind of leg is held against; a climb or a descent is steep, and begins or ends on the ground.
LIMITS = {
    Phase.CRUISE: {"obstacles", "ground", "ceiling", "bounds", *ANGLES},
    Phase.RETURN: {"obstacles", "ground", "ceiling", "bounds"},
    Phase.TAKEOFF: {"obstacles"},
    Phase.LANDING: {"obstacles"},
}


def check_airspace(forecast: Forecast) -> Iterator[Finding]:
    """Findings about home, then about each leg.

    Between waypoints a leg must keep the scenario's limits. On the climb, on the way home and on the landing, which no
    planner chose, breaking one is a warning, and touching something an error.
    """
    mission, scenario = forecast.mission, forecast.world
    offset = np.abs(scenario.frame.local(mission.home))
    if offset.max() > SAME_HOME:
        message = f"home: lies {np.linalg.norm(offset):.1f} m from the scenario's home: heights above home differ"
        yield Finding("home-differs", Severity.WARNING, 0, message)
    told = set[str]()
    for leg in forecast.legs:
        for check in broken(leg, scenario):
            words = check.words()
            begins = np.linalg.norm(np.array(check.nearest.place) - leg.points[0]) < ROUNDING["m"]
            if leg.phase is Phase.CRUISE and words in told and begins:
                continue  # said of the leg before, where the two meet
            told |= {words} if leg.phase is Phase.CRUISE else set()
            item, message = item_of(mission, leg.seq), f"{leg_name(leg)}: {words}"
            if leg.phase is not Phase.CRUISE and not _touches(check, scenario):
                yield item.warning("leg-too-near", message)
            else:
                hint, remedies = remedy(forecast) if leg.phase is Phase.RETURN else (None, ())
                yield item.error("leg-too-near", message, hint, remedies)


def broken(leg: Leg, scenario: Scenario) -> list[Check]:
    """The limits that a leg breaks by more than rounding; straight up or down no angle is too steep."""
    limits = LIMITS[leg.phase] - (ANGLES if np.ptp(leg.points[:, :2], axis=0).max() < ROUNDING["m"] else set())
    checks = prove(leg.points, scenario, leg.stray).checks
    return [c for c in checks if c.limit in limits and c.slack < -ROUNDING[c.unit]]


def _touches(check: Check, scenario: Scenario) -> bool:
    solid = check.limit in ("obstacles", "ground")
    return solid and check.nearest.distance < scenario.vehicle.radius - ROUNDING["m"]
