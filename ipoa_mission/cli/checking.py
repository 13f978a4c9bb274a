"""`check` and `estimate`: what a mission file is worth before it flies."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ipoa_mission.cli.options import (
    AutopilotOption,
    FileArgument,
    JsonOption,
    ParameterFileOption,
    ParameterOption,
    read_parameter_options,
)
from ipoa_mission.cli.telling import notes, tell, tell_json, tell_table

if TYPE_CHECKING:
    from ipoa_mission.timing.estimate import Estimate

BAR = 10  # characters for the item that takes longest


def check(
    file: FileArgument,
    scenario: Annotated[
        Path | None,
        typer.Option("--scenario", metavar="SCENARIO", help="Check clearance, bounds and heights against it."),
    ] = None,
    autopilot: AutopilotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Check a mission file: its format, the firmware's rules, and with a scenario clearance, bounds and altitude.

    Exit code 1 when something would go wrong in flight.

    Example: `ipoa-mission check campus.plan --scenario missions/campus.toml`
    """
    from ipoa_mission.mission.check import Severity, check_mission
    from ipoa_mission.mission.files import read_mission
    from ipoa_mission.scenario import read_scenario

    mission = read_mission(file, autopilot)
    findings = check_mission(mission, None if scenario is None else read_scenario(scenario))
    errors = sum(finding.severity is Severity.ERROR for finding in findings)
    if as_json:
        rows = [{"severity": str(f.severity), "seq": f.seq, "message": f.message, "hint": f.hint} for f in findings]
        tell_json({"ok": not errors, "findings": rows})
    else:
        tell(*(line for f in findings for line in (str(f), *([f"hint: {f.hint}"] if f.hint else []))))
        counts = f"{_count(errors, 'error')}, {_count(len(findings) - errors, 'warning')}, {len(mission.items)} items"
        tell(f"{file}: {counts} for {mission.autopilot}")
    if errors:
        raise typer.Exit(1)


def estimate(
    file: FileArgument,
    autopilot: AutopilotOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    as_json: JsonOption = False,
) -> None:
    """Estimate how long a mission will fly, item by item, with QGroundControl's number beside it.

    Time zero is armed in the mission mode on the ground.

    Example: `ipoa-mission estimate campus.plan --param WPNAV_ACCEL=500`
    """
    from ipoa_mission.mission.files import read_mission
    from ipoa_mission.mission.items import command_name
    from ipoa_mission.timing.estimate import estimate as predict

    mission = read_mission(file, autopilot)
    found = predict(mission, read_parameter_options(param, param_file))
    if as_json:
        tell_json(estimate_as_json(found))
        return
    longest = max((item.duration_s for item in found.items), default=0.0)
    rows = [
        (
            str(item.seq),
            command_name(item.command),
            _number(item.length),
            _number(item.peak_speed if item.length else 0.0),
            f"{item.duration_s:.1f}",
            f"{item.done_s:.1f}",
            _bar(item.duration_s, longest),
            item.reason,
        )
        for item in found.items
    ]
    columns = ["item", "command", "leg\nm", "peak\nm/s", "takes\ns", "done at\ns", "", "what keeps it slow"]
    tell_table(
        f"{file.name} on {mission.autopilot}; time zero: armed, in the mission mode, on the ground", columns, rows
    )
    tell(*notes(found.remarks))
    tell(
        f"estimated {found.total_s:.1f} s (between {found.low_s:.0f} and {found.high_s:.0f}); "
        f"QGroundControl would say {found.qgroundcontrol_s:.0f} s"
    )


def estimate_as_json(found: "Estimate") -> dict[str, Any]:
    """An estimate for machines; items are numbered as in the file, where home is 0."""
    return {
        "total_s": round(found.total_s, 3),
        "low_s": round(found.low_s, 3),
        "high_s": round(found.high_s, 3),
        "qgroundcontrol_s": round(found.qgroundcontrol_s, 3),
        "items": [{"seq": item.seq, "done_s": round(item.done_s, 3), "reason": item.reason} for item in found.items],
        "remarks": list(found.remarks),
    }


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _number(value: float) -> str:
    return f"{value:.1f}" if value else ""


def _bar(value: float, longest: float) -> str:
    return "▇" * round(BAR * value / longest) if longest else ""
