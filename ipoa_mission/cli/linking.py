"""`upload`, `download` and `scan`: the vehicle at the other end of a link."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.cli.options import (
    AnywayOption,
    FileArgument,
    JsonOption,
    KeyOption,
    LinkOption,
    LogOption,
    SystemOption,
)
from ipoa_mission.cli.telling import progress_bar, tell, tell_json

if TYPE_CHECKING:
    from ipoa_mission.link.signing import Signer
    from ipoa_mission.link.vehicle import Vehicle
    from ipoa_mission.mission.items import Mission


def upload(
    file: FileArgument,
    link: LinkOption,
    system: SystemOption = None,
    log: LogOption = None,
    key: KeyOption = None,
    anyway: AnywayOption = False,
    as_json: JsonOption = False,
) -> None:
    """Put a mission on a vehicle, read it back and compare every item; fence and rally points go with it.

    Example: `ipoa-mission upload campus.plan --link udpin:127.0.0.1:14550`
    """
    from ipoa_mission.mission.files import read_mission

    mission = read_mission(file)
    with connect_to(link, system, log or file.with_suffix(".tlog"), key) as vehicle:
        put(mission, vehicle, anyway)
        if as_json:
            tell_json({"system": vehicle.system, "autopilot": str(vehicle.autopilot), "items": len(mission.items)})
        else:
            tell(
                f"{len(mission.items)} items are on vehicle {vehicle.system} ({vehicle.autopilot}), read back and equal"
            )


def download(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write: .plan or .waypoints.")],
    link: LinkOption,
    system: SystemOption = None,
    log: LogOption = None,
    key: KeyOption = None,
) -> None:
    """Read the mission on a vehicle, with its fence and rally points, into a file.

    Example: `ipoa-mission download vehicle.plan --link tcp:127.0.0.1:5760`
    """
    from ipoa_mission.mission.files import write_mission

    with connect_to(link, system, log or file.with_suffix(".tlog"), key) as vehicle, progress_bar("download") as show:
        mission = vehicle.download(lambda done, total: show(done / max(total, 1), f"{done} of {total}"))
    left_out = write_mission(mission, file)
    tell(f"{len(mission.items)} items written to {file}", *left_out)


def clear(link: LinkOption, log: LogOption = None, system: SystemOption = None, key: KeyOption = None) -> None:
    """Have a vehicle forget its mission, fence and rally points.

    Example: `ipoa-mission clear --link udpin:127.0.0.1:14550`
    """
    from ipoa_mission.link.messages import MissionType

    with connect_to(link, system, log or Path("clear.tlog"), key) as vehicle:
        vehicle.clear(MissionType.ALL)
        tell(f"vehicle {vehicle.system} ({vehicle.autopilot}) has no mission, fence or rally points now")


def scan(
    link: LinkOption,
    seconds: Annotated[float, typer.Option("--seconds", min=0.1, help="How long to listen.")] = 3.0,
    as_json: JsonOption = False,
) -> None:
    """Name the autopilots that are heard on a link.

    Example: `ipoa-mission scan --link udpin:127.0.0.1:14550`
    """
    from ipoa_mission.link.vehicle import open_line
    from ipoa_mission.link.vehicle import scan as listen

    line = open_line(link)
    try:
        found = listen(line, seconds)
    finally:
        line.close()
    if as_json:
        tell_json([{"system": one.system, "autopilot": str(one.autopilot)} for one in found])
    else:
        tell(*(f"system {one.system}: {one.autopilot}" for one in found) if found else ["nobody is heard"])
    if not found:
        raise typer.Exit(1)


def connect_to(link: str, system: int | None, log: Path, key: Path | None) -> "Vehicle":
    """The vehicle on a link; every frame goes to `log`."""
    from ipoa_mission.link.vehicle import connect

    return connect(link, system, log, signer_of(key))


def signer_of(key: Path | None) -> "Signer | None":
    """Who signs with the key in a file; its timestamps go on growing in a file beside it."""
    if key is None:
        return None
    from ipoa_mission.link.signing import persistent_signer, read_key

    return persistent_signer(read_key(key), key.with_name(f"{key.name}.timestamp"))


def put(mission: "Mission", vehicle: "Vehicle", anyway: bool) -> None:
    """Check a mission as the vehicle's own firmware would meet it, and upload it.

    Raises:
        Unsafe: it would crash or be refused, and `anyway` does not say to send it all the same.
    """
    from dataclasses import replace

    from ipoa_mission.mission.check import check_mission
    from ipoa_mission.mission.unsafe import refuse_errors

    if not anyway:
        refuse_errors(check_mission(replace(mission, autopilot=vehicle.autopilot)))
    with progress_bar("upload") as show:
        vehicle.upload(mission, lambda done, total: show(done / max(total, 1), f"{done} of {total}"))
