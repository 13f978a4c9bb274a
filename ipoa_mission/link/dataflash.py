"""ArduPilot's own log (`.bin`): where it was, what it did, which item it turned to. Read by pymavlink's DFReader."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pymavlink import DFReader

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.link.logged import Events, Fixes, presence
from ipoa_mission.link.messages import Current, Message, Text
from ipoa_mission.link.modes import MISSION_MODE
from ipoa_mission.vehicle import Autopilot
from ipoa_mission.world.frame import Geodetic, LocalFrame

ARMED_EVENT, DISARMED_EVENT = 10, 11  # EV.Id, the only word of arming in logs before 4.1
INFO = 6
HEAD = b"\xa3\x95\x80\x80"  # a log begins with the format of the record of formats


def read_dataflash(path: Path) -> tuple[Fixes, Events]:
    """Positions (POS) and events of a log: arming, modes, items begun (MISE; before 4.5 the words in MSG).

    Raises:
        BadInput: the file cannot be read, or holds no positions.
    """
    fixes: list[tuple[float, ...]] = []
    velocities: list[tuple[float, ...]] = []
    times: list[float] = []
    events: list[Message] = []
    armed = in_mission = False
    for record in _records(path):
        kind, time = record.get_type(), getattr(record, "TimeUS", 0) / 1e6
        said: Message | None = None
        match kind:
            case "POS":
                fixes.append((time, record.Lat, record.Lng, record.Alt, record.RelHomeAlt))
            case "XKF1" if record.C == 0:
                velocities.append((time, record.VN, record.VE, record.VD))
            case "MODE":
                in_mission = record.ModeNum == MISSION_MODE[Autopilot.ARDUPILOT]
                said = presence(Autopilot.ARDUPILOT, armed, in_mission)
            case "ARM":
                armed = bool(record.ArmState)
                said = presence(Autopilot.ARDUPILOT, armed, in_mission)
            case "EV" if record.Id in (ARMED_EVENT, DISARMED_EVENT):
                armed = record.Id == ARMED_EVENT
                said = presence(Autopilot.ARDUPILOT, armed, in_mission)
            case "MISE":
                said = Current(record.CNum, record.CTot)
            case "MSG":
                said = _words(record.Message)
        if said is not None:
            times.append(time)
            events.append(said)
    if len(fixes) < 2:
        raise BadInput(f"{path}: expected an ArduPilot log with positions (POS), but there are none")
    return _fixes(np.array(fixes), np.array(velocities)), Events(tuple(times), tuple(events))


def _records(path: Path) -> Iterator[Any]:
    reader = None
    try:
        with path.open("rb") as file:
            if file.read(len(HEAD)) != HEAD:
                raise BadInput(f"{path}: expected an ArduPilot log, but it does not begin as one")
        reader = DFReader.DFReader_binary(str(path), zero_time_base=True)
        while (record := reader.recv_msg()) is not None:
            yield record
    except MissionError:
        raise
    except Exception as error:  # DFReader raises whatever a broken file makes it stumble over
        raise BadInput(f"{path}: cannot be read as an ArduPilot log: {error}") from error
    finally:
        if reader is not None:
            reader.close()


def _words(text: str) -> Message:
    """A text of the log; "Mission: 4 WP" says that item 4 begins."""
    parts = text.split()
    if len(parts) >= 2 and parts[0] == "Mission:" and parts[1].isdigit():
        return Current(int(parts[1]))
    return Text(INFO, text)


def _fixes(rows: Points, velocities: Points) -> Fixes:
    times, latitude, longitude, altitude, height = rows.T
    if len(velocities) > 1:
        velocity = np.column_stack([np.interp(times, velocities[:, 0], axis) for axis in velocities[:, 1:].T])
    else:
        velocity = _differences(times, latitude, longitude, altitude)
    return Fixes(times, latitude, longitude, altitude, height, velocity)


def _differences(times: Vector, latitude: Vector, longitude: Vector, altitude: Vector) -> Points:
    """Velocity north, east, down out of positions, where the log has no estimate of it."""
    start = Geodetic(float(latitude[0]), float(longitude[0]), float(altitude[0]))
    east, north, up = np.gradient(LocalFrame(start).to_local(latitude, longitude, altitude), times, axis=0).T
    return np.column_stack([north, east, -up])
