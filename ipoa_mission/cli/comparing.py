"""`compare`: flown missions held against their estimates."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.cli.options import (
    AutopilotOption,
    JsonOption,
    ParameterFileOption,
    ParameterOption,
    expect_mission,
    read_parameter_options,
)
from ipoa_mission.cli.telling import notes, tell, tell_json, tell_table
from ipoa_mission.errors import BadInput, MissionError

if TYPE_CHECKING:
    from ipoa_mission.items import Mission
    from ipoa_mission.report.compare import ComparedFlight


def compare(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="[FILE] LOG",
            help="The log: .tlog, ArduPilot .bin or PX4 .ulg; first the mission, unless the log has it.",
        ),
    ],
    number: Annotated[
        int | None, typer.Option("--flight", metavar="N", min=1, help="Only the N-th flight in the log.")
    ] = None,
    autopilot: AutopilotOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE", help="Also draw it: .png or .svg.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Hold the log of a flown mission against the estimate, leg by leg; each flight in the log by itself.

    Mission, parameters and firmware are the log's own; those given here go before.

    Example: `ipoa-mission compare campus.plan campus.tlog`
    """
    from ipoa_mission.link.flight_log import read_flights
    from ipoa_mission.report.compare import compare_logged

    if len(files) > 2:
        raise BadInput(f"{files[2]}: expected a mission and a log at most")
    *missions, log = files
    file = expect_mission(missions[0]) if missions else None
    flown = read_flights(log)
    if autopilot not in (None, flown.autopilot):
        raise BadInput(f"{log}: expected a log of {autopilot}, not of {flown.autopilot}")
    own = () if file is None else _read_mission(file, log, flown.autopilot, autopilot is None)
    mission, beside = own or (None, ())
    if number is not None and number > len(flown.flights):
        raise BadInput(f"--flight {number}: expected a number up to {len(flown.flights)}, so many are in {log}")
    numbers = range(1, len(flown.flights) + 1) if number is None else [number]
    if picture is not None and len(numbers) > 1:
        raise BadInput(f"--picture: expected --flight N too: {log} has {len(numbers)} flights")
    given = read_parameter_options(param, param_file)
    found = {n: compare_logged(flown.flights[n - 1], mission, given) for n in numbers}
    held = {n: one for n, one in found.items() if one is not None}
    if not held:
        raise MissionError(f"{log}: {_no_mission(flown.autopilot, log)}", hint="compare FILE LOG, with what was flown")
    if picture is not None:
        _draw(held[numbers[0]], picture, (file or log).stem)
    remarks = [*beside, *flown.remarks]
    remarks += [f"flight {n}: {_no_mission(flown.autopilot, log)}; left out" for n in found if n not in held]
    on = f"{flown.autopilot} {flown.version}".strip()
    title = f"{log.name}: {on}" if file is None else f"{file.name} on {flown.autopilot}, as {log.name} has it"
    if as_json:
        flights = [{"flight": n, **_as_json(one)} for n, one in held.items()]
        about = {"autopilot": flown.autopilot.value, "version": flown.version, "remarks": remarks}
        tell_json({**flights[0], **about, "flights": flights})
        return
    _tell(held, title, remarks)


def _read_mission(file: Path, log: Path, autopilot: Autopilot, may_differ: bool) -> tuple["Mission", tuple[str, ...]]:
    """The mission in a file, for the autopilot of the log; what a plan says of itself may differ if nobody insists."""
    from ipoa_mission.cli.reading import read_with_parameters

    mission, remarks = read_with_parameters(file, None if may_differ and file.suffix == ".plan" else autopilot)
    if mission.autopilot is not autopilot:
        raise BadInput(
            f"{file}: expected a mission for {autopilot}, as {log} is of it, not for {mission.autopilot}",
            hint=f"--autopilot {autopilot}, if that is what was flown",
        )
    return mission, remarks


def _no_mission(autopilot: Autopilot, log: Path) -> str:
    """Why a log does not tell which mission was flown."""
    if autopilot is Autopilot.PX4 and log.suffix.lower() == ".ulg":
        return "PX4 does not write its mission into its logs"
    if log.suffix.lower() == ".bin":
        return "the log does not have the whole list of items that was flown"
    return "the mission was neither uploaded nor downloaded while this log was written"


def _draw(one: "ComparedFlight", picture: Path, title: str) -> None:
    from ipoa_mission.report.compare import flown_track
    from ipoa_mission.report.comparison_plot import draw_comparison
    from ipoa_mission.report.plots import write_picture

    flown_path = flown_track(one.mission, one.record)
    points = None if flown_path is None else flown_path.points
    write_picture(draw_comparison(one.comparison, one.estimate.track.points, points, title), picture)


def _as_json(one: "ComparedFlight") -> dict[str, Any]:
    held = one.comparison
    return {
        "armed_s": round(one.armed_s, 3),
        "completed": one.record.completed,
        "why_not": one.record.why_not,
        "estimated_s": round(held.estimated_total_s, 3),
        "flown_s": _known(held.flown_total_s),
        "route_error": _known(held.route_error),
        "total_error": _known(held.total_error),
        "legs": [
            {
                "seq": leg.seq,
                "estimated_s": round(leg.estimated_s, 3),
                "flown_s": round(leg.flown_s, 3),
                "done_s": round(leg.flown_done_s, 3),
            }
            for leg in held.legs
        ],
        "parameters": one.parameters,
        "remarks": list(one.remarks),
    }


def _tell(held: dict[int, "ComparedFlight"], title: str, remarks: list[str]) -> None:
    if len(held) > 1:
        columns = ["flight", "armed at\ns", "items", "estimated\ns", "flown\ns", "total", "route"]
        tell_table(title, columns, [_row(n, one) for n, one in held.items()])
    for n, one in held.items():
        comparison = one.comparison
        rows = [
            (
                str(leg.seq),
                *(f"{s:.1f}" for s in (leg.estimated_s, leg.flown_s)),
                f"{leg.error_s:+.1f}",
                f"{leg.flown_done_s:.1f}",
            )
            for leg in comparison.legs
        ]
        which = f"flight {n}" if len(held) > 1 else title
        tell_table(which, ["item", "estimated\ns", "flown\ns", "difference\ns", "done at\ns"], rows)
        tell(f"estimated {comparison.estimated_total_s:.1f} s, flown {_flown(one)}")
        if math.isfinite(comparison.route_error):
            tell(f"from the first waypoint to the last: {comparison.route_error:+.1%}")
        if one.parameters:
            tell("parameters: " + ", ".join(f"{name} {value:g}" for name, value in one.parameters.items()))
        tell(*notes(one.remarks), *([""] if len(held) > 1 else []))
    tell(*notes(remarks))


def _row(number: int, one: "ComparedFlight") -> tuple[str, ...]:
    held = one.comparison
    errors = (f"{error:+.1%}" if math.isfinite(error) else "" for error in (held.total_error, held.route_error))
    items = f"{len(one.record.item_reached_s)} of {len(one.mission.items)}"
    return (
        str(number),
        f"{one.armed_s:.1f}",
        items,
        f"{held.estimated_total_s:.1f}",
        _seconds(held.flown_total_s),
        *errors,
    )


def _seconds(value: float) -> str:
    return f"{value:.1f}" if math.isfinite(value) else ""


def _flown(one: "ComparedFlight") -> str:
    total = one.comparison.flown_total_s
    return f"{total:.1f} s" if math.isfinite(total) else f"not to its end: {one.record.why_not}"


def _known(value: float) -> float | None:
    return round(value, 4) if math.isfinite(value) else None
