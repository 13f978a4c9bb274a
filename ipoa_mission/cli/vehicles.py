import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.cli.groups import LinkOptions
from ipoa_mission.cli.interrupting import reporting_interrupt
from ipoa_mission.cli.options import Backend
from ipoa_mission.cli.output import progress_bar
from ipoa_mission.cli.overwriting import expect_log
from ipoa_mission.errors import BadInput, MissionError

if TYPE_CHECKING:
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.link.vehicle import Vehicle
    from ipoa_mission.progress import Progress

log = logging.getLogger(__name__)


@contextmanager
def connect_to(link: str, options: LinkOptions, usual_log: Path | None, reading: bool = False) -> "Iterator[Vehicle]":
    """Connect to the vehicle; log every frame (default: `usual_log`) without MAVSDK. Raises BadInput, LinkDown,
    NoAnswer, NotFlown.

    `reading`: any vehicle is accepted. Errors name the log. `options.timeout` ends all but a flight.
    """
    logs = {file: _written_ns(file) for file in options.written(usual_log)}
    try:
        with _vehicle_on(link, options, usual_log, reading) as vehicle:
            yield vehicle
    except MissionError as error:
        if kept := [file for file, before in logs.items() if _written_ns(file) not in (None, before)]:
            error.known["written"] = kept
        raise


def _written_ns(file: str) -> int | None:
    try:
        return Path(file).stat().st_mtime_ns
    except OSError:
        return None


def _vehicle_on(link: str, options: LinkOptions, usual_log: Path | None, reading: bool) -> "Vehicle":
    from ipoa_mission.cli.options import signer_of

    expect_log(options.log)
    timeout = options.timeout
    signer, began = signer_of(options.key), time.monotonic()
    if options.backend is Backend.MAVSDK:
        from ipoa_mission.link.mavsdk_backend import connect as connect_by_mavsdk

        if signer is not None:
            words = "the mavsdk backend does not sign"
            raise BadInput(words, hint="omit --backend", code="backend-cannot", place="--key")
        if timeout is not None:
            words = "MAVSDK has timers of its own"
            raise BadInput(words, hint="omit --backend", code="backend-cannot", place="--timeout")
        vehicle: Vehicle = connect_by_mavsdk(link, options.system, options.log, reading)
    else:
        from ipoa_mission.link.connect import connect
        from ipoa_mission.link.dialogue import SPECIFIED

        vehicle = connect(
            link,
            system=options.system,
            log=options.log or usual_log,
            signer=signer,
            patience=SPECIFIED if timeout is None else replace(SPECIFIED, total_s=timeout),
            anyway=options.anyway,
            reading=reading,
        )
        if timeout is not None:
            vehicle.give_up_after(timeout - (time.monotonic() - began))
    log.info("%s: system %d, %s, by %s", link, vehicle.system, vehicle.autopilot, options.backend)
    return vehicle


@contextmanager
def stages_shown(stage: "Stage") -> "Iterator[Progress]":
    """Show a bar; on an interruption report the state left behind."""
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.progress import silent

    left = {
        Stage.POSITION: "nothing was sent",
        Stage.CHECK: "nothing was sent",
        Stage.UPLOAD: "the mission on the vehicle may be the old or the new one",
        Stage.STORED: str(Stage.STORED),
        Stage.READY: "the vehicle was not armed",
        Stage.FLIGHT: "the vehicle flies on, unwatched",
    }
    if stage is Stage.START:
        with reporting_interrupt("see the hint", hint="look at it"), progress_bar("starting", is_waiting=True) as show:
            yield show
        return
    waits = stage in (Stage.POSITION, Stage.READY)
    is_long = waits or stage in (Stage.UPLOAD, Stage.FLIGHT)
    with (
        reporting_interrupt(left[stage]),
        progress_bar(stage, is_waiting=waits) if is_long else nullcontext(silent) as show,
    ):
        yield show


def states_firmware(file: Path, autopilot: Autopilot | None) -> bool:
    """Return whether a mission file names its firmware; `.waypoints` does not."""
    return autopilot is not None or file.suffix.lower() != ".waypoints"
