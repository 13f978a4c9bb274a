"""Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, and know how long it will fly.

    from ipoa_mission import assemble, estimate, plan_path, read_scenario, write_plan

    scenario = read_scenario("missions/campus.toml")
    plan = plan_path(scenario, seed=7)
    mission = assemble(plan, scenario)
    write_plan(mission, "campus.plan")
    print(estimate(mission).total_s)

Names are imported when they are first used, so that `import ipoa_mission` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ipoa_mission.mission.assemble import assemble
    from ipoa_mission.mission.files import read_mission
    from ipoa_mission.mission.plan_file import write_plan
    from ipoa_mission.mission.waypoints_file import write_waypoints
    from ipoa_mission.planning.planner import plan_path
    from ipoa_mission.scenario import read_scenario
    from ipoa_mission.timing.estimate import estimate

_WHERE = {
    "assemble": "mission.assemble",
    "estimate": "timing.estimate",
    "plan_path": "planning.planner",
    "read_mission": "mission.files",
    "read_scenario": "scenario",
    "write_plan": "mission.plan_file",
    "write_waypoints": "mission.waypoints_file",
}

__all__ = [
    "assemble",
    "estimate",
    "plan_path",
    "read_mission",
    "read_scenario",
    "write_plan",
    "write_waypoints",
]


def __getattr__(name: str) -> object:
    if name in _WHERE:
        return getattr(import_module(f"ipoa_mission.{_WHERE[name]}"), name)
    raise AttributeError(f"module 'ipoa_mission' has no attribute {name!r}")
