from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from ipoa_mission.errors import BadInput, LogUseless, MissionError, OptionConflict
from ipoa_mission.files import MISSIONS
from ipoa_mission.options import ForceOption, JsonOption, LogSystemOption, argument, flag
from ipoa_mission.terminal import notes, print_json, print_lines, print_table

if TYPE_CHECKING:
    from ipoa_mission.autopilot.learned import LearnedVehicle
    from ipoa_mission.learn.fit import Evidence


def learn(
    files: Annotated[
        list[Path], argument("[FILE] LOG...", "Logs, each after its mission if the log does not contain it.")
    ],
    out: Annotated[Path, flag("--out", "Vehicle file to write.", "FILE")] = Path("vehicle.toml"),
    system: LogSystemOption = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Learn a vehicle from its flights: drag, lag, ground delays, hover power, with 90 % intervals.

    Values that the flights do not determine stay as simulated. Each flight is timed with the values of the others;
    without an improvement only the hover power is written, or nothing, exit code 1. Logs with attitudes give the drag
    at any speed and in wind; without them fly in little wind, and near the top speed.

    Example: `ipoa-mission learn monday.bin tuesday.bin --out vehicle.toml`
    """
    from dataclasses import asdict, replace

    from ipoa_mission.autopilot.learned import write_vehicle
    from ipoa_mission.files import write_atomically
    from ipoa_mission.learn.fit import PRIOR_DEVIATIONS, cross_validate, energy_error, fit, median_errors
    from ipoa_mission.terminal import expect_free

    expect_free([out], force, ask=not as_json)
    flights, remarks, version = _gathered(files, system)
    judged = cross_validate(flights) if len(flights) > 1 else []
    try:
        vehicle = replace(fit(flights), version=version)
    except MissionError as error:
        raise error.followed_by(*remarks) from error
    before, after = median_errors(judged)
    if len(flights) == 1:
        if vehicle.hover_power is None:
            cross_validate(flights)  # raises if one flight is not enough
        vehicle = vehicle.with_numbers(dict.fromkeys(PRIOR_DEVIATIONS))
        remarks.append("one flight gives the hover power; times need two flights or more")
    elif before > 0 and not after < before:
        words = f"the learned values do not improve other flights' times: error {after:.1%}, not below {before:.1%}"
        if vehicle.hover_power is None:
            raise MissionError(words, hint="the estimate is as good without a vehicle file", code="option-conflict")
        vehicle = vehicle.with_numbers(dict.fromkeys(PRIOR_DEVIATIONS))
        remarks.append(words)
    write_atomically(out, write_vehicle(vehicle))
    energy = energy_error(judged)
    if as_json:
        outcome = {"energy_error": energy and round(energy, 5), "remarks": remarks, "written": str(out)}
        why = {name: _reasons(name, flights) for name, learned in asdict(vehicle).items() if learned is None}
        fitted = {
            "vehicle": asdict(vehicle) | {"autopilot": vehicle.autopilot.name},
            "left_out": [asdict(one) for one in judged],
            "median_error": {"before": round(before, 5), "after": round(after, 5)},
        }
        print_json(fitted | {"undetermined": why} | outcome)
        return
    columns = ["flight", "flown\ns", "estimated\ns", "with the\nvehicle s", "measured\nWh", "estimated\nWh"]
    if judged:
        numbers = [(one.flown_s, one.before_s, one.after_s, one.energy_wh, one.forecast_wh) for one in judged]
        cells = [[f"{number:.1f}" if number else "" for number in row] for row in numbers]
        rows = [(one.name, *row) for one, row in zip(judged, cells, strict=True)]
        print_table("each flight with the values of the others", columns, rows)
    print_lines(*_words(vehicle, flights))
    if before > 0:
        print_lines(f"median error of a flight {after:.1%}, {before:.1%} without")
    if energy is not None:
        print_lines(f"median error of its energy {energy:.1%}")
    print_lines(*notes(remarks))
    print_lines(f"written: {out}")


def _gathered(files: list[Path], system: int | None) -> tuple[list["Evidence"], list[str], str]:
    from ipoa_mission import read_mission
    from ipoa_mission.learn.fit import flights_in

    flights: list[Evidence] = []
    remarks: list[str] = []
    kinds: set[tuple[str, str]] = set()
    mission = None
    for n, file in enumerate(files):
        if file.suffix.lower() in MISSIONS:
            if n + 1 == len(files) or mission is not None:
                raise OptionConflict("expected a log after it", place=file)
            mission = file
            continue
        reader = None if mission is None else partial(read_mission, mission)
        usable, left, version, autopilot = flights_in(file, reader, system)
        flights = flights + usable
        remarks = remarks + left
        mission = None
        if usable:
            kinds.add((autopilot.name, version))
    if not flights:
        raise LogUseless("; ".join(remarks) or "expected a flight to learn from")
    if len({autopilot for autopilot, _ in kinds}) > 1:
        flown = " and ".join(f"{autopilot} {version}".strip() for autopilot, version in sorted(kinds))
        raise BadInput(f"expected logs of one vehicle, not of {flown}", code="other-autopilot")
    return flights, remarks, max(version for _, version in kinds)


def _reasons(name: str, flights: list["Evidence"]) -> list[str]:
    return [*dict.fromkeys(filter(None, (flight.measured.reasons.get(name) for flight in flights)))]


def _words(vehicle: "LearnedVehicle", flights: list["Evidence"]) -> Iterator[str]:
    from ipoa_mission.autopilot.learned import QUANTITIES

    for name, quantity in QUANTITIES.items():
        learned = getattr(vehicle, name)
        if learned is None:
            yield "; ".join([f"{name}: as simulated, or undetermined", *_reasons(name, flights)])
        else:
            yield f"{name}: {learned.value:.3g} ({learned.low:.3g} to {learned.high:.3g}), {quantity.meaning}"
