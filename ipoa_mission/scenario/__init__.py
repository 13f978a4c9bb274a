"""The scenario: a TOML file, its tables as pydantic models, and the world that they describe.

Entry: `read_scenario` returns a `Scenario`, whose `airspace`, `limits` and `geofence` the planner asks.
Read `model` first, then `surroundings`, which builds the airspace from maps and sections.
The other modules define tables (`*_section(s)`, `obstacles`, `camera`), `explain` errors, and write a `new` scenario.
"""

from ipoa_mission.scenario.model import Scenario
from ipoa_mission.scenario.scenario_file import parse_scenario, read_scenario

__all__ = ["Scenario", "parse_scenario", "read_scenario"]
