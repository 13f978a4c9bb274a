from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.deviation.kept_limits import ClearanceTask
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.scenario import Scenario


def clearance_task(scenario: Scenario, autopilot: Autopilot | None = None) -> ClearanceTask:
    """Return the scenario's limits, and the deviation law of its vehicle or of `autopilot` in its wind."""
    law = law_of(autopilot or scenario.vehicle.autopilot, scenario.wind.strongest)
    return ClearanceTask(scenario, law, scenario.safety.chance)
