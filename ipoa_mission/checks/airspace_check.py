"""Check the legs of a mission in a scenario's airspace."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.checks.numbered_finding import item_of, leg_name
from ipoa_mission.checks.way_home import remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg, Phase
from ipoa_mission.planning.proof import Check, prove
from ipoa_mission.scenario import Scenario

# of positions to 1e-7 degrees and to millimeters
ROUNDING = {"m": 0.02, "deg": 0.5}
HOME_TOLERANCE = 1.0  # [m]

ANGLES = {"climb", "descent"}

# A climb or a descent is steep, and begins or ends on the ground.
LIMITS = {
    Phase.CRUISE: {"obstacles", "ground", "ceiling", "bounds", *ANGLES},
    Phase.RETURN: {"obstacles", "ground", "ceiling", "bounds"},
    Phase.TAKEOFF: {"obstacles"},
    Phase.LANDING: {"obstacles"},
}


def check_airspace(forecast: Forecast) -> Iterator[Finding]:
    """Report a home elsewhere, then each broken limit of each leg.

    The planner chooses no climb, way home or landing: there it is a warning, and contact an error.
    """
    mission, scenario = forecast.mission, forecast.world
    offset = np.abs(scenario.frame.local(mission.home))
    if offset.max() > HOME_TOLERANCE:
        message = f"home: lies {np.linalg.norm(offset):.1f} m from the scenario's home: heights above home differ"
        yield Finding("home-differs", Severity.WARNING, 0, message)
    reported = set[str]()
    for leg in forecast.legs:
        for check in broken(leg, scenario):
            words = check.words()
            begins = np.linalg.norm(np.array(check.nearest.place) - leg.points[0]) < ROUNDING["m"]
            if words in reported and begins:
                continue
            reported |= {words} if leg.phase is Phase.CRUISE else set()
            item, message = item_of(mission, leg.seq), f"{leg_name(leg)}: {words}"
            if leg.phase is not Phase.CRUISE and not _touches(check, scenario):
                yield item.warning("leg-too-near", message)
            else:
                hint, remedies = remedy(forecast) if leg.phase is Phase.RETURN else (None, ())
                yield item.error("leg-too-near", message, hint, remedies)


def broken(leg: Leg, scenario: Scenario) -> list[Check]:
    """Return the limits broken by more than rounding."""
    limits = LIMITS[leg.phase] - (ANGLES if np.ptp(leg.points[:, :2], axis=0).max() < ROUNDING["m"] else set())
    checks = prove(leg.points, scenario, leg.stray).checks
    return [c for c in checks if c.limit in limits and c.slack < -ROUNDING[c.unit]]


def _touches(check: Check, scenario: Scenario) -> bool:
    solid = check.limit in ("obstacles", "ground")
    return solid and check.nearest.distance < scenario.vehicle.radius - ROUNDING["m"]
