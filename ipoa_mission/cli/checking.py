from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ipoa_mission.cli.groups import WorldOptions
from ipoa_mission.errors import BadInput, OptionConflict
from ipoa_mission.options import ANYWAY, FileArgument, JsonOption, argument, flag
from ipoa_mission.terminal import notes, picked, print_json, print_lines, print_table

if TYPE_CHECKING:
    from ipoa_mission.cli.reading import RequestedMission
    from ipoa_mission.forecast.contingency.energy_budget import Budget, ItemEnergy
    from ipoa_mission.forecast.forecast import Forecast
    from ipoa_mission.forecast.timing.estimate import Estimate, ItemTime


def check(
    files: Annotated[list[Path], argument("FILE...", "Mission files (.plan, .waypoints), or folders of them.")],
    options: WorldOptions,
    contingencies: Annotated[
        bool, flag("--contingencies", "Forecast RTL, LAND and others from every second of the flight.")
    ] = False,
    anyway: Annotated[bool, flag("--anyway", ANYWAY)] = False,
    as_json: JsonOption = False,
) -> None:
    """Check mission files: format, firmware rules, and with a scenario clearance, bounds and altitude.

    Exit code 1 if the flight would fail, 2 if a file cannot be read.

    Example: `ipoa-mission check campus.plan --scenario missions/campus.toml`
    """
    from ipoa_mission.checks.unsafe import unreadable
    from ipoa_mission.cli.check_files import CheckedFile, check_file, missions_in
    from ipoa_mission.cli.reading import read_world
    from ipoa_mission.mission.item_words import count_words

    if contingencies and options.scenario is None:
        hint = "the clearance of a contingency depends on the obstacles"
        raise OptionConflict("needs --scenario", hint=hint, place="--contingencies")
    if options.flown_by.air is not None and options.scenario is None:
        raise OptionConflict("needs --scenario", hint="wind moves a flight nearer to obstacles", place="--wind")
    is_one = len(files) == 1 and not files[0].is_dir()
    paths = missions_in(files)
    world = read_world(options.scenario, options.flown_by.air, options.ignore)
    checked: list[CheckedFile] = []
    wrong: BadInput | None = None
    for path in paths:
        try:
            checked.append(check_file(path, options, world, anyway)._replace(shows_contingencies=contingencies))
        except BadInput as error:
            wrong = error
            checked.append(CheckedFile(path, (unreadable(error),)))
        if not as_json and not (is_one and wrong):
            checked[-1].print()
    if is_one and wrong:
        raise wrong
    errors = sum(checked_file.errors for checked_file in checked)
    if as_json and is_one:
        print_json(checked[0].as_json())
    elif as_json:
        by_file = [{"file": str(checked_file.file)} | checked_file.as_json() for checked_file in checked]
        print_json({"ok": not errors, "files": by_file})
    elif not is_one:
        warnings = sum(len(checked_file.findings) for checked_file in checked) - errors
        severities = f"{count_words(errors, 'error')}, {count_words(warnings, 'warning')}"
        print_lines(f"{count_words(len(checked), 'file')}: {severities}")
    if errors:
        raise typer.Exit(BadInput.exit_code if wrong else 1)


def estimate(file: FileArgument, options: WorldOptions, as_json: JsonOption = False) -> None:
    """Estimate the flight time of a mission, item by item, next to QGroundControl's estimate.

    Time zero: armed, in the mission mode, on the ground.

    Example: `ipoa-mission estimate campus.plan --param WPNAV_ACCEL=500`
    """
    from ipoa_mission.checks.firmware_check import check_version
    from ipoa_mission.checks.unsafe import refuse_errors
    from ipoa_mission.cli.reading import read_forecast
    from ipoa_mission.mission.positions import refusals
    from ipoa_mission.report.summary import energy_as_json
    from ipoa_mission.unread import unread_as_json

    requested, forecast = read_forecast(file, options)
    wrong = refusals(requested.mission)
    if wrong:
        raise BadInput(wrong[0], place=file).followed_by(*(f"{file}: {words}" for words in wrong[1:]))
    as_read = forecast.mission_as_read
    refuse_errors(tuple(check_version(as_read.autopilot, as_read.firmware_version, as_read.unmeasured_version)))
    mission = forecast.mission
    prediction = forecast.estimate
    budget = known_budget(forecast)
    remarks = remarks_on(requested, forecast)
    if as_json:
        energy: dict[str, Any] = {"energy_wh": None if budget is None else round(budget.used.energy_wh, 3)}
        energy |= {} if budget is None else {"energy": energy_as_json(budget)}
        firmware = mission.autopilot.facts(mission.firmware_version)
        unread = unread_as_json(() if forecast.scenario is None else forecast.scenario.unread)
        context = {"firmware": firmware, "remarks": list(remarks), "unread": unread}
        print_json(estimate_as_json(prediction) | energy | context)
        return
    items = budget.items if budget else (None,) * len(prediction.items)
    rows = [_cells(item, used) for item, used in zip(prediction.items, items, strict=True)]
    columns = ["item", "", "leg\nm", "peak\nm/s", "takes\ns", "done\ns", "±\ns", "missed", "takes\nWh", "left"]
    columns.append("slowed by")
    title = f"{file.name} on {mission.autopilot.checked_for(mission.firmware_version)}, from arming"
    print_table(title, columns, rows)
    print_lines(*notes(remarks))
    print_lines(
        *route_in_words(prediction),
        f"estimated {prediction.total_s:.1f} s (between {prediction.low_s:.0f} and {prediction.high_s:.0f})"
        f"{prediction.besides}; "
        f"QGroundControl would say {prediction.qgroundcontrol_s:.0f} s",
        *([] if budget is None else budget.words),
    )


def _cells(item: "ItemTime", used: "ItemEnergy | None") -> tuple[str, ...]:
    from ipoa_mission.autopilot.commands import short_name

    peak = _number(item.peak_speed if item.length else 0.0)
    margin = max(item.done_s - item.low_s, item.high_s - item.done_s)
    missed = f"{100 * item.missed.share:.0f} %, {item.missed.cost_s:.0f} s" if item.missed.share else ""
    takes = "" if used is None else f"{used.takes.likely:.1f}"
    left = "" if used is None or used.left is None else f"{max(used.left.likely, 0.0):.0%}"
    leg = (short_name(item.command), _number(item.length), peak)
    times = (f"{item.duration_s:.1f}", f"{item.done_s:.1f}", f"{margin:.1f}")
    return (str(item.seq), *leg, *times, missed, takes, left, item.reason)


def known_budget(forecast: "Forecast") -> "Budget | None":
    if forecast.energy is None:
        return None
    from ipoa_mission.forecast.contingency.energy_budget import budget_of  # slow to import

    return budget_of(forecast)


def remarks_on(requested: "RequestedMission", forecast: "Forecast") -> tuple[str, ...]:
    from ipoa_mission.checks.firmware_check import check_firmware, check_version
    from ipoa_mission.finding import Severity

    prediction = forecast.estimate
    as_read = forecast.mission_as_read
    version = check_version(as_read.autopilot, as_read.firmware_version, as_read.unmeasured_version)
    unmeasured = (finding.message for finding in version)
    refused = (finding.message for finding in check_firmware(requested.mission) if finding.severity is Severity.ERROR)
    of_world = () if forecast.scenario is None else forecast.scenario.remarks
    remarks = [*requested.remarks, *unmeasured, *refused, *of_world, *prediction.remarks]
    file, planned_s = requested.planned or ("", prediction.total_s)
    if abs(planned_s - prediction.total_s) > 0.05:  # [s]
        why = "in its scenario's world and wind (--scenario), with its parameters"
        remarks.append(f"{file} has {planned_s:.1f} s for it: {why}")
    return tuple(dict.fromkeys(remarks))


def route_in_words(estimate: "Estimate") -> list[str]:
    return [f"first place to last waypoint {estimate.route_s:.1f} s"] if estimate.route_s > 0 else []


def estimate_as_json(estimate: "Estimate") -> dict[str, Any]:
    """Return JSON values; items are numbered as in the file, home is 0."""
    from ipoa_mission.forecast.timing.estimate import COUNTED_TERMS
    from ipoa_mission.report.summary import route_summary

    items = [
        picked(item, "seq", "done_s", "low_s", "high_s", "reason") | {"missed": picked(item.missed, "share", "cost_s")}
        for item in estimate.items
    ]
    waits = {"waits": list(estimate.waits)} if estimate.waits else {}
    times = picked(estimate, "total_s", "low_s", "high_s", "qgroundcontrol_s")
    terms = {"qgroundcontrol_counts": COUNTED_TERMS, "route": route_summary(estimate)}
    return times | terms | {"items": items, "remarks": list(estimate.remarks)} | waits


def _number(value: float) -> str:
    return f"{value:.1f}" if value else ""
