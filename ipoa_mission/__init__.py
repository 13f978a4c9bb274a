"""Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, and know how long it will fly.

    from ipoa_mission import assemble, estimate, plan_path, read_scenario, write_plan

    scenario = read_scenario("missions/campus.toml")
    plan = plan_path(scenario, seed=7)
    mission = assemble(plan, scenario)
    write_plan(mission, "campus.plan")
    print(estimate(mission).total_s)

Names are imported when they are first used, so that `import ipoa_mission` costs nothing. docs/api.md shows them all.
In a notebook, `%load_ext ipoa_mission` lets missions, plans, estimates and flights be seen as tables.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ipoa_mission.errors import BadInput, MissionError
    from ipoa_mission.link.flight_log import read_flight
    from ipoa_mission.link.vehicle import connect
    from ipoa_mission.mission.assemble import assemble, weigh_routes
    from ipoa_mission.mission.check import check_mission
    from ipoa_mission.mission.exports import write_export
    from ipoa_mission.mission.files import read_mission, write_mission
    from ipoa_mission.mission.plan_file import write_plan
    from ipoa_mission.mission.table import mission_table
    from ipoa_mission.mission.waypoints_file import write_waypoints
    from ipoa_mission.planning.planner import plan_path
    from ipoa_mission.report.compare import compare_flight
    from ipoa_mission.report.page import write_report
    from ipoa_mission.scenario import read_scenario
    from ipoa_mission.simulator.fly import fly
    from ipoa_mission.timing.estimate import estimate

_WHERE = {
    "BadInput": "errors",
    "MissionError": "errors",
    "assemble": "mission.assemble",
    "check_mission": "mission.check",
    "compare_flight": "report.compare",
    "connect": "link.vehicle",
    "estimate": "timing.estimate",
    "fly": "simulator.fly",
    "mission_table": "mission.table",
    "plan_path": "planning.planner",
    "read_flight": "link.flight_log",
    "read_mission": "mission.files",
    "read_scenario": "scenario",
    "weigh_routes": "mission.assemble",
    "write_export": "mission.exports",
    "write_mission": "mission.files",
    "write_plan": "mission.plan_file",
    "write_report": "report.page",
    "write_waypoints": "mission.waypoints_file",
}

__all__ = [
    "BadInput",
    "MissionError",
    "assemble",
    "check_mission",
    "compare_flight",
    "connect",
    "estimate",
    "fly",
    "mission_table",
    "plan_path",
    "read_flight",
    "read_mission",
    "read_scenario",
    "weigh_routes",
    "write_export",
    "write_mission",
    "write_plan",
    "write_report",
    "write_waypoints",
]


def __getattr__(name: str) -> object:
    if name in _WHERE:
        return getattr(import_module(f"ipoa_mission.{_WHERE[name]}"), name)
    raise AttributeError(f"module 'ipoa_mission' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__


def load_ipython_extension(shell: Any) -> None:
    """What `%load_ext ipoa_mission` calls."""
    from ipoa_mission.report.notebook import show_in

    show_in(shell)
