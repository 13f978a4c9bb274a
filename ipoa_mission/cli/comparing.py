"""`compare`: a flown mission held against its estimate."""

import math
from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import (
    AutopilotOption,
    FileArgument,
    JsonOption,
    ParameterFileOption,
    ParameterOption,
    read_parameter_options,
)
from ipoa_mission.cli.telling import tell, tell_json, tell_table


def compare(
    file: FileArgument,
    log: Annotated[Path, typer.Argument(metavar="LOG", help="The flight's log: .tlog, ArduPilot .bin or PX4 .ulg.")],
    autopilot: AutopilotOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE", help="Also draw it: .png or .svg.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Hold the log of a flown mission against the estimate, leg by leg.

    Example: `ipoa-mission compare campus.plan campus.tlog`
    """
    from ipoa_mission.link.flight_log import read_flight
    from ipoa_mission.mission.files import read_mission
    from ipoa_mission.report.compare import compare_flight
    from ipoa_mission.timing.estimate import estimate

    mission = read_mission(file, autopilot)
    found = estimate(mission, read_parameter_options(param, param_file))
    flight = read_flight(log, mission)
    held = compare_flight(mission, found, flight)
    if picture is not None:
        from ipoa_mission.report.compare import flown_track
        from ipoa_mission.report.comparison_plot import draw_comparison
        from ipoa_mission.report.plots import write_picture

        flown_path = flown_track(mission, flight)
        points = None if flown_path is None else flown_path.points
        write_picture(draw_comparison(held, found.track.points, points, file.stem), picture)
    if as_json:
        tell_json(
            {
                "estimated_s": round(held.estimated_total_s, 3),
                "flown_s": _known(held.flown_total_s),
                "route_error": _known(held.route_error),
                "total_error": _known(held.total_error),
                "legs": [
                    {"seq": leg.seq, "estimated_s": round(leg.estimated_s, 3), "flown_s": round(leg.flown_s, 3)}
                    for leg in held.legs
                ],
            }
        )
        return
    rows = [
        (str(leg.seq), f"{leg.estimated_s:.1f}", f"{leg.flown_s:.1f}", f"{leg.error_s:+.1f}", f"{leg.flown_done_s:.1f}")
        for leg in held.legs
    ]
    columns = ["item", "estimated\ns", "flown\ns", "difference\ns", "done at\ns"]
    tell_table(f"{file.name} on {mission.autopilot}, as {log.name} has it", columns, rows)
    flown = f"{held.flown_total_s:.1f} s" if math.isfinite(held.flown_total_s) else "longer than the log"
    tell(f"estimated {held.estimated_total_s:.1f} s, flown {flown}")
    if math.isfinite(held.route_error):
        tell(f"from the first waypoint to the last: {held.route_error:+.1%}")


def _known(value: float) -> float | None:
    return round(value, 4) if math.isfinite(value) else None
