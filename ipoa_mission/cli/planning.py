"""`plan` and `schema`: from a scenario file to mission files."""

from pathlib import Path

from ipoa_mission.cli.options import (
    AutopilotOption,
    JsonOption,
    OptimizerOption,
    OutOption,
    ParameterFileOption,
    ParameterOption,
    PlannerOption,
    PolishOption,
    ReportOption,
    ScenarioArgument,
    SeedOption,
    WindOption,
    read_parameter_options,
    read_wind_option,
)
from ipoa_mission.cli.telling import tell, tell_json, tell_table


def plan(
    scenario: ScenarioArgument,
    out: OutOption = Path(),
    seed: SeedOption = 0,
    optimizer: OptimizerOption = None,
    planner: PlannerOption = None,
    polish: PolishOption = True,
    autopilot: AutopilotOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    wind: WindOption = None,
    report: ReportOption = False,
    as_json: JsonOption = False,
) -> None:
    """Plan a scenario and write its mission: NAME.plan (QGroundControl), NAME.waypoints, and NAME.json about it.

    Example: `ipoa-mission plan missions/campus.toml --out out --seed 7`
    """
    from ipoa_mission.cli.folders import expect_folder
    from ipoa_mission.cli.job import adapt_scenario, plan_mission
    from ipoa_mission.cli.summary import ROUTE_COLUMNS, describe, route_rows, summarise
    from ipoa_mission.cli.writing import write_files

    expect_folder(out)
    parameters, air = read_parameter_options(param, param_file), read_wind_option(wind)
    job = plan_mission(adapt_scenario(scenario, optimizer, planner, polish, autopilot, parameters), seed, air)
    files = write_files(job, out)
    if report:
        from ipoa_mission.report.page import write_report

        files.append(out / f"{job.name}.html")
        write_report(files[-1], job.scenario, job.plan, job.mission, job.estimate, remarks=job.remarks)
    if as_json:
        tell_json(summarise(job) | {"written": [str(file) for file in files]})
    else:
        tell(*describe(job))
        tell_table("start to goal, by how the waypoints are chosen", ROUTE_COLUMNS, route_rows(job))
        tell(f"written: {', '.join(map(str, files))}")


def schema() -> None:
    """Print the JSON Schema of scenario files, so that editors complete and check them.

    Example: `ipoa-mission schema > scenario.schema.json`
    """
    from ipoa_mission.scenario import Scenario

    tell_json(Scenario.model_json_schema())
