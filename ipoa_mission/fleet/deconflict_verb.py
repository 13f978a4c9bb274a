import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ipoa_mission.errors import BadInput, OptionConflict
from ipoa_mission.options import ForceOption, JsonOption, argument, expect_mission, flag, read_number, read_wind_option
from ipoa_mission.terminal import expect_folder, expect_free, picked, print_json, print_lines, print_table, round_finite

if TYPE_CHECKING:
    from ipoa_mission.fleet.contingency_conflicts import ContingencyConflict
    from ipoa_mission.fleet.encounters import Conflict
    from ipoa_mission.fleet.repairs import TimetableSlot
    from ipoa_mission.geodesy import LocalFrame


@dataclass
class DeconflictOptions:
    separation: Annotated[float, flag("--separation", "Least distance of two vehicles.", "M", min=0.1, max=1e4)] = 10.0
    confidence: Annotated[float, flag("--confidence", "Probability that a pair keeps it.", min=0.5, max=0.999999)] = (
        0.999
    )
    departures: Annotated[str | None, flag("--departures", "When each may depart; default all at 0 s.", "S,S,...")] = (
        None
    )
    most_delay: Annotated[float, flag("--most-delay", "The longest delay of a departure.", "S", min=0.0, max=1e5)] = (
        600.0
    )
    wind: Annotated[
        str | None, flag("--wind", "A steady wind by speed and origin: 6@270 is from the west.", "M/S@DEG")
    ] = None
    out: Annotated[Path | None, flag("--out", "Write changed missions and timetable.json to it.", "DIR")] = None
    force: ForceOption = False
    as_json: JsonOption = False

    def earliest_departures(self, count: int) -> list[float]:
        texts = ["0"] * count if self.departures is None else self.departures.split(",")
        seconds = [read_number(text) for text in texts]
        if len(seconds) != count or not all(0.0 <= second < math.inf for second in seconds):
            words = f"expected {count} times of 0 s or more, as 0,30, not {self.departures}"
            raise BadInput(words, place="--departures")
        return seconds


def deconflict(
    files: Annotated[list[Path], argument("FILE...", "Missions: .plan or .waypoints.")], options: DeconflictOptions
) -> None:
    """Predict where missions may meet, and delay, hold or raise vehicles until each pair keeps its separation.

    The probability counts early and late flights and their deviations, as measured on autopilots, and a second of doubt
    for each departure. Vehicles on their pads count. A pad of two missions is used by one after the other.

    A repair is the one found with the least sum of added time. It is forecast as its missions are written. Exit code 1
    if none keeps all pairs apart.

    Example: `ipoa-mission deconflict north.plan south.plan --separation 15`
    """
    from ipoa_mission.fleet.contingency_conflicts import contingency_conflicts
    from ipoa_mission.fleet.fleet import read_fleet
    from ipoa_mission.fleet.repairs import Deconfliction, RepairLimits, TimetableSlot

    if len(files) < 2:
        raise OptionConflict("expected two missions or more", place="FILE")
    earliest = options.earliest_departures(len(files))
    if options.out is not None:
        expect_folder(options.out)
    vehicles = read_fleet([expect_mission(file) for file in files], read_wind_option(options.wind))
    planned = list(map(TimetableSlot, vehicles, earliest))
    search = Deconfliction(planned, options.separation, RepairLimits(1.0 - options.confidence, options.most_delay))
    timetable = search.timetable()
    slots = planned if timetable is None else timetable
    meetings, unknown = contingency_conflicts(slots, search.frame, options.separation)
    result: dict[str, Any] = {
        "separation_m": options.separation,
        "confidence": options.confidence,
        "conflicts": [_row(each, search.frame) for each in search.conflicts(planned)],
        "contingencies": [_row(each, search.frame) for each in meetings],
        "unknown_contingencies": unknown,
    }
    if timetable is None:
        result |= {"blocking": search.blocking_pair(), "written": []}
    else:
        result["timetable"] = [
            {"mission": slot.vehicle.flight.name, "file": str(slot.vehicle.file), "change": slot.vehicle.change}
            | picked(slot, "departs_s", "added_s", digits=1)
            for slot in timetable
        ]
        result["added_s"] = round(sum(slot.added_s for slot in timetable), 1)
        result["remaining"] = [_row(each, search.frame) for each in search.conflicts(timetable)]
        result["written"] = [] if options.out is None else _write(timetable, options.out, options.force, result)
    if options.as_json:
        print_json(result)
    else:
        _print(result)
    if timetable is None:
        raise typer.Exit(1)


def _write(timetable: "list[TimetableSlot]", out: Path, force: bool, result: dict[str, Any]) -> list[str]:
    """Write all changed missions and the timetable, or nothing; never over a mission of the fleet."""
    from ipoa_mission.files import write_together

    contents: dict[Path, str | bytes | None] = {}
    rows = zip(timetable, result["timetable"], strict=True)
    changed = [(slot.vehicle, row) for slot, row in rows if slot.vehicle.change]
    names = names_of_changed([vehicle.file.stem for vehicle, _ in changed])
    for name, (vehicle, row) in zip(names, changed, strict=True):
        row["file"] = str(out / f"{name}.plan")
        contents |= {out / f"{name}{suffix}": content for suffix, content in vehicle.contents.items()}
    read = {slot.vehicle.file.resolve() for slot in timetable}
    if any(file.resolve() in read for file in contents):
        words = "expected another folder than that of the missions: nothing is written over them"
        raise BadInput(words, code="already-there", place=f"--out {out}")
    contents[out / "timetable.json"] = json.dumps(result, indent=2) + "\n"
    expect_free(contents, force, ask=False)
    out.mkdir(parents=True, exist_ok=True)
    write_together(contents)
    return [str(file) for file in contents]


def names_of_changed(stems: Sequence[str]) -> list[str]:
    """Return file names, unlike also where case does not count; a repeated stem gets its number."""
    names = list[str]()
    for number, stem in enumerate(stems, start=1):
        name = stem
        while name.casefold() in map(str.casefold, names):
            name = f"{name}-{number}"
        names.append(name)
    return names


def _row(met: "Conflict | ContingencyConflict", frame: "LocalFrame") -> dict[str, Any]:
    row = met._asdict()
    place = frame.geodetic(row.pop("place"))
    row |= {"latitude_deg": place.latitude_deg, "longitude_deg": place.longitude_deg, "altitude_amsl": place.altitude}
    digits = {"latitude_deg": 7, "longitude_deg": 7, "probability": 6}
    floats = {name: value for name, value in row.items() if isinstance(value, float)}
    return row | {name: round_finite(value, digits.get(name, 1)) for name, value in floats.items()}


def _print(result: dict[str, Any]) -> None:
    if result["conflicts"]:
        _print_rows(f"possible losses of a separation of {result['separation_m']:g} m", result["conflicts"])
    else:
        print_lines(f"no pair comes within {result['separation_m']:g} m")
    if "blocking" in result:
        print_lines(f"no departures, holds or heights keep {' and '.join(result['blocking'])} apart")
    elif result["conflicts"]:
        _print_rows("a timetable that keeps all pairs apart", result["timetable"])
    if result["contingencies"]:
        title = "warning: the first one's contingency, ordered from one second to another, may meet the second one"
        _print_rows(title, result["contingencies"])
    for each in result["unknown_contingencies"]:
        print_lines(f"unknown: {each['contingency']} of {each['vehicle']}: {each['why']}")
    for file in result["written"]:
        print_lines(f"written: {file}")


def _print_rows(title: str, rows: list[dict[str, Any]]) -> None:
    joined = [[" and ".join(value) if isinstance(value, tuple) else value for value in row.values()] for row in rows]
    cells = [tuple("" if value is None else str(value) for value in row) for row in joined]
    print_table(title, [key.replace("_", "\n") for key in rows[0]], cells)
