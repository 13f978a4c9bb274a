"""`show` and `export`: a mission file for the eye, and for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import AutopilotOption, FileArgument, JsonOption, LearnedOption
from ipoa_mission.cli.telling import notes, tell, tell_json, tell_table

ScenarioOption = Annotated[
    Path | None, typer.Option("--scenario", metavar="SCENARIO", help="The world it flies in, for heights above ground.")
]


def show(
    file: FileArgument,
    scenario: ScenarioOption = None,
    autopilot: AutopilotOption = None,
    vehicle: LearnedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Print a mission as a table: leg length, heading, climb, height, and when each item will be done.

    Example: `ipoa-mission show campus.plan --scenario missions/campus.toml`
    """
    from dataclasses import asdict

    from ipoa_mission.checks.positions import refusals
    from ipoa_mission.cli.reading import read_with_parameters, read_world
    from ipoa_mission.errors import MissionError
    from ipoa_mission.exports.table import mission_table
    from ipoa_mission.timing.estimate import estimate
    from ipoa_mission.tube.flown_in import flown_in
    from ipoa_mission.wind import CALM

    mission, remarks = read_with_parameters(file, autopilot, vehicle=vehicle)
    world = read_world(scenario)
    rows, errors = mission_table(mission, world), refusals(mission)
    done: dict[int, float] = {}
    try:
        if not errors:
            wind = CALM if world is None else world.wind.air()
            timed = estimate(mission if world is None else flown_in(mission, world), wind=wind)
            done = {item.seq: item.done_s for item in timed.items}
        total = f"estimated {timed.total_s:.0f} s" if not errors else "no time: a position or height makes no sense"
    except MissionError as error:
        total = f"no time: {error}"
    remarks += tuple(errors)
    if as_json:
        tell_json([asdict(row) | {"done_s": done.get(row.seq)} for row in rows])
        return
    cells = [
        (
            str(row.seq),
            row.command,
            _number(row.length),
            _number(row.heading_deg, "03.0f"),
            _number(row.climb, "+z.1f"),
            _number(row.height),
            _number(row.height_above_ground),
            _number(done.get(row.seq)),
            row.detail or (f"hold {row.hold_s:g} s" if row.hold_s else f"{row.speed:g} m/s" if row.speed else ""),
        )
        for row in rows
    ]
    home = mission.home
    place = f"home {home.latitude_deg:.6f}, {home.longitude_deg:.6f}, {home.altitude:.1f} m AMSL"
    columns = ["item", "command", "leg\nm", "heading\n°", "climb\nm", "height\nm", "above\nground m", "done at\ns", ""]
    tell_table(f"{file.name}: {len(mission.items)} items for {mission.autopilot}; {place}", columns, cells)
    climbs = [row.climb for row in rows if row.climb is not None]
    up, down = sum(c for c in climbs if c > 0), -sum(c for c in climbs if c < 0)
    length = sum(row.length for row in rows if row.length is not None)
    tell(f"{length:.0f} m, {up:.0f} m up and {down:.0f} m down; {total}", *notes(remarks))


def export(
    file: FileArgument,
    target: Annotated[Path, typer.Argument(metavar="TARGET", help="File to write: .kml, .geojson, .csv or .gpx.")],
    autopilot: AutopilotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write a mission for other programs: KML, GeoJSON, CSV or GPX, by the suffix; or as the other mission format.

    Example: `ipoa-mission export campus.plan campus.kml`
    """
    from ipoa_mission.exports import write_export
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


def _number(value: float | None, form: str = "z.1f") -> str:
    return "" if value is None else format(value, form)
