"""`fly` and `mock`: a mission in the air, on a real vehicle or on the built-in autopilot."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ipoa_mission.cli.options import (
    AnywayOption,
    AutopilotOption,
    FileOrScenario,
    JsonOption,
    KeyOption,
    OptimizerOption,
    OutOption,
    ParameterFileOption,
    ParameterOption,
    ReportOption,
    SeedOption,
    SystemOption,
    read_parameter_options,
)
from ipoa_mission.cli.telling import progress_bar, tell, tell_json, tell_table
from ipoa_mission.vehicle import Autopilot

if TYPE_CHECKING:
    from ipoa_mission.link.logbook import FlightRecord
    from ipoa_mission.mission.items import Mission
    from ipoa_mission.timing.estimate import Estimate

ZURICH = (47.397742, 8.545594, 488.0)

LossOption = Annotated[float, typer.Option("--loss", min=0, max=1, help="Share of frames that the link loses.")]
DuplicateOption = Annotated[float, typer.Option("--duplicate", min=0, max=1, help="Share of frames that come twice.")]
DelayOption = Annotated[float, typer.Option("--delay", metavar="S", min=0, help="Delay of the link, one way.")]
ReorderOption = Annotated[float, typer.Option("--reorder", min=0, max=1, help="Share of frames held back.")]
NakOption = Annotated[int | None, typer.Option("--nak-at", metavar="N", min=0, help="Refuse the item of this number.")]


def fly(
    source: FileOrScenario,
    link: Annotated[
        str | None, typer.Option("--link", metavar="URL", help="A real vehicle; left out, the built-in autopilot.")
    ] = None,
    out: OutOption = Path(),
    seed: SeedOption = 0,
    optimizer: OptimizerOption = None,
    autopilot: AutopilotOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    system: SystemOption = None,
    key: KeyOption = None,
    anyway: AnywayOption = False,
    loss: LossOption = 0.0,
    duplicate: DuplicateOption = 0.0,
    delay: DelayOption = 0.0,
    reorder: ReorderOption = 0.0,
    nak_at: NakOption = None,
    report: ReportOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fly a mission from upload to landing, and hold the flown time against the estimate.

    A scenario is planned first and its mission files are written. Without `--link` the built-in autopilot flies it, as
    fast as it goes. Every frame goes to NAME.tlog.

    Example: `ipoa-mission fly missions/campus.toml --out out`
    """
    from ipoa_mission.cli.job import PlannedJob, prepare, write_files
    from ipoa_mission.cli.summary import describe

    job = prepare(source, seed, autopilot, optimizer, read_parameter_options(param, param_file))
    out.mkdir(parents=True, exist_ok=True)
    if isinstance(job, PlannedJob):
        written = write_files(job, out)
        if not as_json:
            tell(*describe(job), f"written: {', '.join(map(str, written))}")
    log = out / f"{job.name}.tlog"
    with progress_bar("flying") as show:
        total = len(job.mission.items)
        watching: Callable[[int], None] = lambda done: show(done / total, f"item {done} of {total}")  # noqa: E731
        if link is None:
            from ipoa_mission.simulator.faults import Faults
            from ipoa_mission.simulator.fly import fly as fly_here

            faults = Faults(loss, duplicate, delay, reorder, nak_at=nak_at)
            record = fly_here(job.mission, job.parameters, seed, faults, log, flying=watching)
        else:
            record = _fly_there(job.mission, link, system, log, key, anyway, watching)
    if report and isinstance(job, PlannedJob):
        from ipoa_mission.report.page import write_report

        page = out / f"{job.name}.html"
        write_report(page, job.scenario, job.plan, job.mission, job.estimate, record, job.remarks)
    if as_json:
        tell_json(flight_as_json(job.estimate, record))
        return
    if not record.completed:
        tell(*record.messages)
    tell_table(
        f"{job.name} on {job.mission.autopilot}",
        ["item", "estimated s", "flown s", "difference s"],
        _legs(job.estimate, record),
    )
    tell(
        f"estimated {job.estimate.total_s:.1f} s, flown {record.total_s:.1f} s; "
        f"QGroundControl would have said {job.estimate.qgroundcontrol_s:.0f} s"
    )
    if not record.completed:
        raise typer.Exit(1)


def mock(
    autopilot: Annotated[Autopilot, typer.Option("--autopilot", help="Whom to answer as.")] = Autopilot.PX4,
    link: Annotated[
        str,
        typer.Option("--link", metavar="URL", help="udpin or udpout, tcpin; loopback unless you name another host."),
    ] = "udpin:127.0.0.1:14540",
    speedup: Annotated[float, typer.Option("--speedup", metavar="N", help="So many times as fast as real.")] = 1.0,
    home: Annotated[
        tuple[float, float, float],
        typer.Option("--home", metavar="LAT LON ALT", help="Where it stands: degrees, and metres AMSL."),
    ] = ZURICH,
    system: SystemOption = None,
    key: KeyOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    loss: LossOption = 0.0,
    duplicate: DuplicateOption = 0.0,
    delay: DelayOption = 0.0,
    reorder: ReorderOption = 0.0,
    nak_at: NakOption = None,
    seed: SeedOption = 0,
) -> None:
    """Be an autopilot: answer and fly as PX4 or as ArduPilot until Ctrl-C, for any ground station.

    Example: `ipoa-mission mock --autopilot ardupilot --link tcpin:127.0.0.1:5760 --speedup 10`
    """
    from ipoa_mission.cli.linking import signer_of
    from ipoa_mission.errors import BadInput
    from ipoa_mission.simulator.faults import Faults
    from ipoa_mission.simulator.server import serve
    from ipoa_mission.world.frame import Geodetic

    latitude_deg, longitude_deg, _ = home
    if not (-90 <= latitude_deg <= 90 and -180 <= longitude_deg <= 180):
        raise BadInput(f"--home: expected latitude and longitude in degrees, not {latitude_deg} {longitude_deg}")
    tell(f"{autopilot} at {link}, {speedup:g} times as fast as real; Ctrl-C ends it")
    serve(
        link,
        autopilot,
        Geodetic(*home),
        speedup,
        Faults(loss, duplicate, delay, reorder, nak_at=nak_at),
        read_parameter_options(param, param_file),
        system or 1,
        seed,
        signer_of(key),
    )


def flight_as_json(found: "Estimate", record: "FlightRecord") -> dict[str, Any]:
    """Estimate and flight for machines; items are numbered as in the file, where home is 0."""
    from ipoa_mission.cli.checking import estimate_as_json

    return {
        "completed": record.completed,
        "flown_s": round(record.total_s, 3),
        "flown_items": [
            {"seq": index + 1, "done_s": round(at, 3)} for index, at in sorted(record.item_reached_s.items())
        ],
        "estimate": estimate_as_json(found),
        "messages": list(record.messages),
    }


def _legs(found: "Estimate", record: "FlightRecord") -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for item in found.items:
        flown = record.item_reached_s.get(item.seq - 1)
        told = ("", "") if flown is None else (f"{flown:.1f}", f"{item.done_s - flown:+.1f}")
        rows.append((str(item.seq), f"{item.done_s:.1f}", *told))
    return rows


def _fly_there(
    mission: "Mission",
    link: str,
    system: int | None,
    log: Path,
    key: Path | None,
    anyway: bool,
    watching: Callable[[int], None],
) -> "FlightRecord":
    from ipoa_mission.cli.linking import connect_to, put

    with connect_to(link, system, log, key) as vehicle:
        put(mission, vehicle, anyway)
        vehicle.arm()
        vehicle.start()
        return vehicle.watch(watching)
