"""Read scenario files: tables as pydantic models, and the world that they describe.

`read_scenario` returns a `Scenario`. Read `model` first, then `surroundings`.
"""

from ipoa_mission.scenario.model import Scenario
from ipoa_mission.scenario.scenario_file import new_scenario, parse_scenario, read_scenario

__all__ = ["Scenario", "new_scenario", "parse_scenario", "read_scenario"]
