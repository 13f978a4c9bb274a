import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.cli.groups import FlownByOptions, LinkOptions
from ipoa_mission.cli.interrupting import ChangesMade, interruptible
from ipoa_mission.errors import BadInput, MissionError, WrongSuffix
from ipoa_mission.files import MISSIONS, recorded_writes
from ipoa_mission.options import (
    AutopilotOption,
    Backend,
    FileArgument,
    ForceOption,
    IgnoreOption,
    JsonOption,
    LinkOption,
    UnmeasuredVersionOption,
    argument,
    flag,
    signer_of,
)
from ipoa_mission.terminal import expect_free, expect_log, notes, print_json, print_lines, progress_bar

if TYPE_CHECKING:
    from ipoa_mission.link.vehicle import Vehicle


log = logging.getLogger(__name__)


@contextmanager
def connect_to(link: str, options: LinkOptions, usual_log: Path | None, reading: bool = False) -> "Iterator[Vehicle]":
    """Connect to the vehicle; log every frame (default: `usual_log`) without MAVSDK.

    `reading`: any vehicle is accepted. Errors name the log. `options.timeout` ends all but a flight.
    """
    written: list[Path] = []
    with recorded_writes(written):
        try:
            with _vehicle_on(link, options, usual_log, reading) as vehicle:
                yield vehicle
        except MissionError as error:
            logs = [path for path in options.written(usual_log) if Path(path) in written and Path(path).exists()]
            if logs:
                error.known["written"] = logs
            raise


def _vehicle_on(link: str, options: LinkOptions, usual_log: Path | None, reading: bool) -> "Vehicle":
    from ipoa_mission.link.dialogue import SPECIFIED
    from ipoa_mission.link.vehicle import ConnectionOptions

    expect_log(options.log)
    timeout = options.timeout
    signer = signer_of(options.key)
    began = time.monotonic()
    retry_policy = SPECIFIED if timeout is None else replace(SPECIFIED, total_s=timeout)
    if options.backend is Backend.MAVSDK:
        from ipoa_mission.link.mavsdk_backend import connect as connect_by_mavsdk

        if signer is not None:
            words = "the mavsdk backend does not sign"
            raise BadInput(words, hint="omit --backend", code="backend-cannot", place="--key")
        by_options = ConnectionOptions(retry_policy, reading=reading)
        vehicle: Vehicle = connect_by_mavsdk(link, options.system, options.log, by_options)
    else:
        from ipoa_mission.link.connect import connect

        vehicle = connect(
            link,
            system=options.system,
            log=options.log or usual_log,
            signer=signer,
            retry_policy=retry_policy,
            anyway=options.anyway,
            reading=reading,
        )
    if timeout is not None:
        vehicle.give_up_after(timeout - (time.monotonic() - began))
    log.info("%s: system %d, %s, by %s", link, vehicle.system, vehicle.autopilot, options.backend)
    return vehicle


def states_firmware(file: Path, autopilot: Autopilot | None) -> bool:
    """A `.waypoints` file names none."""
    return autopilot is not None or file.suffix.lower() != ".waypoints"


@dataclass
class UploadOptions:
    autopilot: AutopilotOption = None
    unmeasured_version: UnmeasuredVersionOption = False
    ignore: IgnoreOption = None
    as_json: JsonOption = False


@interruptible
def upload(
    changes: ChangesMade, file: FileArgument, link: LinkOption, on_link: LinkOptions, options: UploadOptions
) -> None:
    """Put a mission, its fence and rally points on a vehicle, read them back and compare every item.

    It is first checked for this vehicle's firmware, and the vehicle's home and parameters are compared with the
    mission's (NAME.params).

    Example: `ipoa-mission upload campus.plan --link udpin:127.0.0.1:14550`
    """
    from ipoa_mission.checks.unsafe import refuse_errors
    from ipoa_mission.cli.reading import read_requested
    from ipoa_mission.flight.procedure import upload_mission
    from ipoa_mission.mission.mission_io import read_mission_file
    from ipoa_mission.rules import expect_ignorable

    flown_by = FlownByOptions(autopilot=options.autopilot, unmeasured_version=options.unmeasured_version)
    is_for_firmware = states_firmware(file, options.autopilot)
    ignored = expect_ignorable(options.ignore or ())
    read_mission_file(file, options.autopilot)
    default_log = file.with_name(f"{file.stem}-upload.tlog")
    with connect_to(link, on_link, default_log) as vehicle:
        requested = read_requested(file, flown_by, None if is_for_firmware else vehicle.autopilot)
        if not on_link.anyway:
            refuse_errors([finding for finding in requested.findings if finding.code not in ignored])
        mission = requested.mission
        sent = upload_mission(vehicle, mission, anyway=on_link.anyway, ignore=ignored, stages=changes.stage)
        remarks = (*requested.remarks, *sent)
    counts = {"items": len(mission.items), "fence": len(mission.fence), "rally": len(mission.rally)}
    words = [f"{_counted(counts)} on {_name(vehicle)}, read back and equal", *notes(remarks)]
    result = counts | {"remarks": list(remarks), "written": on_link.written(default_log)}
    _report(options.as_json, vehicle, result, words)


@dataclass
class DownloadOptions:
    force: ForceOption = False
    as_json: JsonOption = False


@interruptible
def download(
    changes: ChangesMade,
    file: Annotated[Path, argument("FILE", "File to write: .plan or .waypoints.")],
    link: LinkOption,
    on_link: LinkOptions,
    to: DownloadOptions,
) -> None:
    """Read the mission on a vehicle, with its fence and rally points, into a file.

    Example: `ipoa-mission download vehicle.plan --link tcp:127.0.0.1:5760`
    """
    from ipoa_mission.mission.item_words import count_words
    from ipoa_mission.mission.mission_io import write_mission

    if file.suffix.lower() not in MISSIONS:
        raise WrongSuffix(f'expected a name that ends in .plan or .waypoints, not in "{file.suffix}"', place=file)
    expect_free([file], to.force, ask=not to.as_json)
    default_log = file.with_name(f"{file.stem}-download.tlog")
    with (
        changes.reporting(f"{file} was not written"),
        connect_to(link, on_link, default_log, reading=True) as vehicle,
        progress_bar("download") as show,
    ):
        mission = vehicle.download(show)
    remarks = write_mission(mission, file)
    log = on_link.written(default_log)
    counts = {"items": len(mission.items), "fence": len(mission.fence), "rally": len(mission.rally)}
    words = [f"{count_words(len(mission.items))} written to {file}", *notes(remarks)]
    _report(to.as_json, vehicle, counts | {"written": [str(file), *log], "remarks": list(remarks)}, words, log)


@interruptible
def clear(changes: ChangesMade, link: LinkOption, on_link: LinkOptions, as_json: JsonOption = False) -> None:
    """Delete a vehicle's mission, fence and rally points.

    Example: `ipoa-mission clear --link udpin:127.0.0.1:14550`
    """
    from ipoa_mission.link.messages import MissionType

    words = "some of the vehicle's lists may be deleted"
    after = "the vehicle's lists are deleted"
    with connect_to(link, on_link, None) as vehicle, changes.reporting(words, "repeat the command", after):
        vehicle.clear(MissionType.ALL)
    result = {"cleared": ["mission", "fence", "rally"], "written": on_link.written(None)}
    _report(as_json, vehicle, result, [f"{_name(vehicle)} has no mission, fence or rally points now"])


@interruptible
def pause(changes: ChangesMade, link: LinkOption, on_link: LinkOptions, as_json: JsonOption = False) -> None:
    """Order a flying vehicle to hold its position; `resume` or `rtl` ends the hold.

    Example: `ipoa-mission pause --link udpin:127.0.0.1:14550`
    """
    _order(changes, link, on_link, as_json, "hold")


@interruptible
def resume(changes: ChangesMade, link: LinkOption, on_link: LinkOptions, as_json: JsonOption = False) -> None:
    """Order a flying vehicle to continue its mission at the interrupted item.

    Example: `ipoa-mission resume --link udpin:127.0.0.1:14550`
    """
    _order(changes, link, on_link, as_json, "mission")


@interruptible
def rtl(changes: ChangesMade, link: LinkOption, on_link: LinkOptions, as_json: JsonOption = False) -> None:
    """Order a flying vehicle to return and land by its own parameters, which know no obstacles.

    Example: `ipoa-mission rtl --link udpin:127.0.0.1:14550`
    """
    _order(changes, link, on_link, as_json, "rtl")


def scan(
    link: LinkOption,
    seconds: Annotated[float, flag("--seconds", "Time to listen [s].", "S", min=0.1)] = 3.0,
    as_json: JsonOption = False,
) -> None:
    """List the autopilots heard on a link: class of vehicle and version.

    Example: `ipoa-mission scan --link udpin:127.0.0.1:14550`
    """
    from ipoa_mission.link.connect import open_connection
    from ipoa_mission.link.dialogue import NoAnswer
    from ipoa_mission.link.discovery import scan as listen
    from ipoa_mission.link.discovery import version_of

    with open_connection(link) as connection:
        heard = listen(connection, seconds)
        versions = {vehicle.system: version_of(connection, vehicle.system) for vehicle in heard}
        rows = [
            {
                "system": vehicle.system,
                "autopilot": str(vehicle.kind.autopilot),
                "kind": str(vehicle.kind),
                "firmware_version": str(versions[vehicle.system] or "") or None,
                "flown": vehicle.kind.is_flown,
                "armed": vehicle.armed,
                "contested": connection.contested(vehicle.system),
            }
            for vehicle in heard
        ]
    if not rows:
        words = f"no autopilot heard within {seconds:g} s"
        raise NoAnswer(words, hint="check that the autopilot runs and sends to this link", code="not-heard", place=link)
    if as_json:
        print_json(rows)
    else:
        print_lines(*(_in_words(row) for row in rows))


def _order(changes: ChangesMade, link: str, on_link: LinkOptions, as_json: bool, does: str) -> None:
    with connect_to(link, on_link, None) as vehicle:
        done, order = {
            "hold": ("holds its position", vehicle.pause),
            "mission": ("continues its mission", vehicle.resume),
            "rtl": ("returns and lands", vehicle.return_to_launch),
        }[does]
        with changes.reporting("the vehicle may have received the order", after=f"the vehicle {done}"):
            order()
    result = {"does": does, "mode": vehicle.mode, "written": on_link.written(None)}
    _report(as_json, vehicle, result, [f"{_name(vehicle)} {done}, in {vehicle.mode}"])


def _counted(counts: dict[str, int]) -> str:
    from ipoa_mission.mission.item_words import count_words

    nouns = {"items": "item", "fence": "fence area", "rally": "rally point"}
    lists = [count_words(counts[key], noun) for key, noun in nouns.items() if counts[key] or key == "items"]
    return " and ".join(lists) + (" is" if lists == ["1 item"] else " are")


def _name(vehicle: "Vehicle") -> str:
    version = vehicle.version_heard
    return f"vehicle {vehicle.system} ({vehicle.autopilot}{f' {version}' if version else ''})"


def _report(
    as_json: bool, vehicle: "Vehicle", result: dict[str, Any], words: list[str], log: list[str] | None = None
) -> None:
    if as_json:
        version = vehicle.version_heard
        who = {"system": vehicle.system, "autopilot": str(vehicle.autopilot)}
        print_json(who | {"firmware_version": str(version) if version else None} | result)
    else:
        print_lines(*words, *(f"written: {path}" for path in (result["written"] if log is None else log)))


def _in_words(row: Mapping[str, object]) -> str:
    armed = ", armed" if row["armed"] else ""
    contested = ", and another vehicle has the same system id" if row["contested"] else ""
    unchanged = "" if row["flown"] else ": nothing was changed on it"
    version = f" {row['firmware_version']}" if row["firmware_version"] else ""
    return f"system {row['system']}: {row['kind']}{version}{armed}{contested}{unchanged}"
