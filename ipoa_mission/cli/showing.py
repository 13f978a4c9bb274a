from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from ipoa_mission.cli.checking import known_budget, remarks_on
from ipoa_mission.cli.groups import WorldOptions
from ipoa_mission.errors import MissionError, WrongSuffix
from ipoa_mission.files import MISSIONS
from ipoa_mission.options import AutopilotOption, FileArgument, ForceOption, JsonOption, ScenarioOption, argument
from ipoa_mission.terminal import notes, print_json, print_lines, print_table

if TYPE_CHECKING:
    from ipoa_mission.forecast.forecast import Forecast
    from ipoa_mission.forecast.timing.estimate import Estimate
    from ipoa_mission.report.table import Row


def show(file: FileArgument, options: WorldOptions, as_json: JsonOption = False) -> None:
    """Print a mission as a table: leg length, heading, climb, height, and the time of each item.

    Example: `ipoa-mission show campus.plan --scenario missions/campus.toml`
    """
    from dataclasses import asdict

    from ipoa_mission.cli.reading import read_forecast
    from ipoa_mission.mission.item_words import count_words
    from ipoa_mission.mission.positions import refusals
    from ipoa_mission.report.table import rows_of
    from ipoa_mission.unread import unread_as_json

    requested, forecast = read_forecast(file, options)
    mission = forecast.mission
    rows = rows_of(forecast)
    errors = refusals(mission)
    timed, total, energy = (None, "no time: a position or height is not valid", []) if errors else _estimated(forecast)
    done = {} if timed is None else {item.seq: item.done_s for item in timed.items}
    of_world = () if forecast.scenario is None else forecast.scenario.remarks
    remarks = remarks_on(requested, forecast) if done else (*requested.remarks, *errors, *of_world)
    if as_json:
        items = [asdict(row) | {"done_s": done.get(row.seq)} for row in rows]
        unread = unread_as_json(() if forecast.scenario is None else forecast.scenario.unread)
        print_json({"items": items, "remarks": list(remarks), "unread": unread})
        return
    firmware = mission.autopilot.checked_for(mission.firmware_version)
    print_lines(f"{file.name}: {count_words(len(mission.items))} for {firmware}")
    home = mission.home
    place = f"home {home.latitude_deg:.6f}, {home.longitude_deg:.6f}, {home.altitude:.1f} m AMSL"
    columns = ["item", "command", "leg\nm", "hdg\n°", "climb\nm", "height\nm", "above\nground", "done\ns", ""]
    print_table(place, columns, [_cells(row, done.get(row.seq)) for row in rows])
    flown = 0.0 if timed is None else sum(item.length for item in timed.items)
    print_lines(*_lengths(rows, flown, total), *energy, *notes(remarks))


def _estimated(forecast: "Forecast") -> "tuple[Estimate | None, str, list[str]]":
    timed = None
    try:
        timed = forecast.estimate
        budget = known_budget(forecast)
    except MissionError as error:
        return timed, f"no time: {error}", []
    return timed, f"estimated {timed.total_s:.0f} s{timed.besides}", budget.words if budget else []


def _cells(row: "Row", done_s: float | None) -> tuple[str, ...]:
    from ipoa_mission.report.table import shown

    leg = (shown(row.length), shown(row.heading(0), "03.0f"), shown(row.climb, "+z.1f"))
    heights = (shown(row.height), shown(row.height_above_ground))
    does = row.detail or (f"hold {row.hold_s:g} s" if row.hold_s else f"{row.speed:g} m/s" if row.speed else "")
    passes = f"{row.passes} passes" if row.passes > 1 and row.length is not None else ""
    return (str(row.seq), row.command, *leg, *heights, shown(done_s), ", ".join(filter(None, (does, passes))))


def _lengths(rows: "Sequence[Row]", flown: float, total: str) -> Iterator[str]:
    climbs = [row.climb for row in rows if row.climb is not None]
    up = sum(climb for climb in climbs if climb > 0)
    down = -sum(climb for climb in climbs if climb < 0)
    length = sum(row.length for row in rows if row.length is not None)
    once = f"{length:.0f} m, {up:.0f} m up and {down:.0f} m down"
    if any(row.passes > 1 for row in rows):
        yield "passes: leg of the first pass, time of the last"
        once += " once through" + (f", {flown:.0f} m flown in all passes" if flown else "")
    yield f"{once}; {total}"


@dataclass
class ExportOptions:
    scenario: ScenarioOption = None
    autopilot: AutopilotOption = None
    force: ForceOption = False
    as_json: JsonOption = False


def export(
    file: FileArgument,
    target: Annotated[Path, argument("TARGET", "File in the format of its suffix, like .kml.")],
    options: ExportOptions,
) -> None:
    """Write a mission for other programs, like KML, or as the other mission format.

    Example: `ipoa-mission export campus.plan campus.kml --scenario missions/campus.toml`
    """
    from ipoa_mission.cli.reading import read_world, taken_for
    from ipoa_mission.mission.mission_io import read_by_items, read_mission_file, write_mission
    from ipoa_mission.report.exports import EXPORTS, write_export
    from ipoa_mission.terminal import expect_free

    suffix = target.suffix.lower()
    suffixes = (*EXPORTS, *MISSIONS)
    if suffix not in suffixes:
        raise WrongSuffix(f'expected a name that ends in {", ".join(suffixes)}, not in "{suffix}"', place=target)
    read = read_by_items(file, read_mission_file(file, options.autopilot))
    world = read_world(options.scenario)
    expect_free([target], options.force, ask=not options.as_json)
    remarks = taken_for(read)
    if suffix in MISSIONS:
        remarks += write_mission(read.mission, target, read)
    else:
        write_export(read.mission, target, world)
    if options.as_json:
        print_json({"written": str(target), "remarks": list(remarks)})
    else:
        print_lines(f"written: {target}", *notes(remarks))
