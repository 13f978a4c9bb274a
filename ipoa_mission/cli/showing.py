"""`show` and `export`: a mission file for the eye, and for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import AutopilotOption, FileArgument, JsonOption
from ipoa_mission.cli.telling import notes, tell, tell_json, tell_table

ScenarioOption = Annotated[
    Path | None, typer.Option("--scenario", metavar="SCENARIO", help="The world it flies in, for heights above ground.")
]


def show(
    file: FileArgument,
    scenario: ScenarioOption = None,
    autopilot: AutopilotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Print a mission as a table: leg length, heading, climb, height, and when each item will be done.

    Example: `ipoa-mission show campus.plan --scenario missions/campus.toml`
    """
    from dataclasses import asdict

    from ipoa_mission.mission.files import read_mission
    from ipoa_mission.mission.table import mission_table
    from ipoa_mission.scenario import read_scenario
    from ipoa_mission.timing.estimate import estimate

    mission = read_mission(file, autopilot)
    world = None if scenario is None else read_scenario(scenario)
    rows = mission_table(mission, world)
    done = {
        item.seq: item.done_s
        for item in estimate(mission, {} if world is None else world.vehicle.autopilot_parameters()).items
    }
    if as_json:
        tell_json([asdict(row) | {"done_s": done.get(row.seq)} for row in rows])
        return
    cells = [
        (
            str(row.seq),
            row.command,
            _number(row.length),
            _number(row.heading_deg, 0),
            _number(row.climb),
            _number(row.height),
            _number(row.height_above_ground),
            _number(done.get(row.seq)),
            row.detail or (f"hold {row.hold_s:g} s" if row.hold_s else f"{row.speed:g} m/s" if row.speed else ""),
        )
        for row in rows
    ]
    columns = ["item", "command", "leg m", "heading", "climb m", "height m", "above ground m", "done s", ""]
    tell_table(f"{file.name} for {mission.autopilot}", columns, cells)


def export(
    file: FileArgument,
    target: Annotated[Path, typer.Argument(metavar="TARGET", help="File to write: .kml, .geojson, .csv or .gpx.")],
    autopilot: AutopilotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write a mission for other programs: KML, GeoJSON, CSV or GPX, by the suffix; or as the other mission format.

    Example: `ipoa-mission export campus.plan campus.kml`
    """
    from ipoa_mission.mission.exports import write_export
    from ipoa_mission.mission.files import read_mission, write_mission

    mission = read_mission(file, autopilot)
    if target.suffix in (".plan", ".waypoints"):
        remarks = write_mission(mission, target)
    else:
        remarks = ()
        write_export(mission, target)
    if as_json:
        tell_json({"written": str(target), "remarks": list(remarks)})
    else:
        tell(f"written: {target}", *notes(remarks))


def _number(value: float | None, digits: int = 1) -> str:
    return "" if value is None else f"{value:.{digits}f}"
