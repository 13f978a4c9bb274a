import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.cli.groups import LinkOptions
from ipoa_mission.cli.interrupting import done, reporting_interrupt
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

    left, after = {
        Stage.POSITION: ("the mission was not sent", ""),
        Stage.PARAMETERS: ("the mission was not sent", ""),
        Stage.CHECK: ("the mission was not sent", ""),
        Stage.UPLOAD: ("the mission on the vehicle may be the old or the new one", str(Stage.STORED)),
        Stage.STORED: (str(Stage.STORED), str(Stage.STORED)),
        Stage.READY: ("the vehicle was not armed", ""),
        Stage.START: ("the start was not completed", "the vehicle was started"),
        Stage.FLIGHT: ("the vehicle flies on, unwatched", ""),
    }[stage]
    hint = "look at the vehicle: it may be armed" if stage is Stage.START else None
    waits = stage in (Stage.POSITION, Stage.READY, Stage.START)
    is_long = stage not in (Stage.CHECK, Stage.STORED)
    words = "starting" if stage is Stage.START else stage
    with (
        reporting_interrupt(left, hint, after),
        progress_bar(words, is_waiting=waits) if is_long else nullcontext(silent) as show,
    ):
        yield partial(_show_parameters, show) if stage is Stage.PARAMETERS else show


def _show_parameters(show: "Progress", share: float, names: str) -> None:
    done["parameters"] = f"{'parameters were' if share == 1.0 else 'some parameters may be'} written: {names}"
    show(share, names)


def note_flown(name: str, is_armed: bool) -> None:
    """Replace the state at the start, for Ctrl-C after the flight."""
    from ipoa_mission.flight.procedure import Stage

    for before in (str(Stage.STORED), "the vehicle was started"):
        done.pop(before, None)
    done[name] = f"{name}: the vehicle {'is armed, and no longer watched' if is_armed else 'is disarmed'}"


def states_firmware(file: Path, autopilot: Autopilot | None) -> bool:
    """Return whether a mission file names its firmware; `.waypoints` does not."""
    return autopilot is not None or file.suffix.lower() != ".waypoints"
