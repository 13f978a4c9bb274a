from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from ipoa_mission.errors import MissionError
from ipoa_mission.link.channel import MavutilChannel, open_channel
from ipoa_mission.link.codec import Codec, numbered, read_tlog
from ipoa_mission.link.connection import Connection, SignsOtherwise
from ipoa_mission.link.dialogue import SPECIFIED, NoAnswer, RetryPolicy
from ipoa_mission.link.discovery import FoundVehicle, autopilots_in, round_trips_in
from ipoa_mission.link.messages import STATION_COMPONENT, STATION_SYSTEM, Ping
from ipoa_mission.link.signing import Signer
from ipoa_mission.link.vehicle import ConnectionOptions, Vehicle
from ipoa_mission.link.vehicle_state import NotFlown

PRESENCE_S = 10.0  # for the first heartbeat
OTHER_HEARTBEATS_S = 1.2  # for others after it


def connect(
    link: Any,
    *,
    system: int | None = None,
    log: str | Path | None = None,
    signer: Signer | None = None,
    retry_policy: RetryPolicy = SPECIFIED,
    fast: bool = True,
    anyway: bool = False,
    reading: bool = False,
) -> Vehicle:
    """Open a link and find the vehicle on it.

    Args:
        link: a connection string, a connection of pymavlink's mavutil, or MAVSDK's System. Closing the vehicle leaves
            an open connection open.
        system: the system id, if there are several vehicles.
        log: a `.tlog` to write.
        signer: signs sent frames and checks received ones.
        retry_policy: the timeouts and retries.
        fast: use ArduPilot's mission file.
        anyway: take the first of several vehicles with this system id.
        reading: accept any vehicle; nothing can be changed on one that is not a multicopter.

    Returns:
        The vehicle; `close` it, or use it with `with`.

    Raises:
        BadInput, LinkDown: the link cannot be opened.
        NoAnswer: there is no vehicle.
        SignsOtherwise: the signatures of a heard vehicle are not accepted.
        NotFlown: it is not a multicopter of ArduPilot or PX4; only our heartbeat was sent to it.
        MissionError: there are several, and `system` does not choose one.
        Contested: two vehicles use this system id.

    Example:
        >>> from ipoa_mission import connect
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     print(vehicle.system, vehicle.autopilot)
        1 px4
    """
    if hasattr(link, "get_system_id"):
        from ipoa_mission.link.mavsdk_backend import borrow

        return borrow(link, log)
    connection = open_connection(link, log, signer)
    try:
        return meet(connection, system, ConnectionOptions(retry_policy, fast, anyway, reading))
    except NoAnswer as silence:
        connection.close()
        written = Path(log or "")
        if written.is_file() and all(numbered(record.frame)[0][0] == STATION_SYSTEM for record in read_tlog(written)):
            written.unlink()
        hint = "is the autopilot running, and does it send to this address?"
        place = link if isinstance(link, str) else "connect"
        raise NoAnswer(f"{silence}", hint=hint, code="not-heard", place=place) from None
    except BaseException:
        connection.close()
        raise


def open_connection(link: Any, log: str | Path | None = None, signer: Signer | None = None) -> Connection:
    codec = Codec(STATION_SYSTEM, STATION_COMPONENT, signer)
    if not isinstance(link, str):
        return Connection(MavutilChannel(link), codec, log)
    again = partial(open_channel, link)
    return Connection(again(), codec, log, again)


def meet(connection: Connection, system: int | None = None, options: ConnectionOptions | None = None) -> Vehicle:
    """Raise as `connect` does; pings meanwhile fit the first timers to the round trip."""
    options = options or ConnectionOptions()
    autopilots, trips_s = _listen(connection, system, options)
    vehicle = _choose(autopilots, system, connection.rejected(system))
    if not (options.reading or vehicle.kind.is_flown):
        raise NotFlown(vehicle.kind, f"vehicle {vehicle.system}")
    if not options.anyway:
        connection.expect_alone(vehicle.system)
    return Vehicle(connection, vehicle, options, trips_s.get(vehicle.system))


def _listen(
    connection: Connection, system: int | None, options: ConnectionOptions
) -> tuple[dict[int, FoundVehicle], dict[int, float]]:
    autopilots: dict[int, FoundVehicle] = {}
    trips_s: dict[int, float] = {}
    until = connection.now() + min(PRESENCE_S, options.retry_policy.total_s)
    is_met = is_rejected = False
    while connection.now() < until:
        heard = connection.receive(until)
        if not is_rejected and connection.rejected(system):
            is_rejected = True
            until = min(until, connection.now() + 3.0)
        autopilots |= autopilots_in(heard)
        trips_s |= round_trips_in(heard, connection.now())
        if not is_met and (autopilots if system is None else system in autopilots):
            is_met = True
            until = connection.now() + OTHER_HEARTBEATS_S
            if options.reading or all(vehicle.kind.is_flown for vehicle in autopilots.values()):
                connection.send(Ping(round(connection.now() * 1e6), 0))
    return autopilots, trips_s


def _choose(vehicles: Mapping[int, FoundVehicle], system: int | None, rejected: SignsOtherwise | None) -> FoundVehicle:
    if system is not None and system in vehicles:
        return vehicles[system]
    if rejected is not None and (system is not None or not vehicles):
        raise rejected
    if system is not None:
        heard = f"; heard: {', '.join(map(str, sorted(vehicles)))}" if vehicles else ""
        raise NoAnswer(f"no autopilot with system id {system} is heard{heard}", code="not-heard")
    if not vehicles:
        raise NoAnswer("no autopilot is heard", code="not-heard")
    if len(vehicles) > 1:
        names = ", ".join(f"{number} ({vehicle.kind})" for number, vehicle in sorted(vehicles.items()))
        words = f"several vehicles are heard: {names}"
        raise MissionError(words, hint="choose one by its system id", code="several-vehicles")
    return next(iter(vehicles.values()))
