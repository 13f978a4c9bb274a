"""What an autopilot's own log tells, whoever wrote it: where it was, and what happened when."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.link.messages import ARMED_FLAG, CUSTOM_MODE_FLAG, Firmware, Heartbeat, Message, Position
from ipoa_mission.link.modes import MISSION_MODE
from ipoa_mission.vehicle import Autopilot

MAV_TYPE_QUADROTOR = 2


@dataclass(frozen=True)
class Fixes:
    """Positions of a log by the autopilot's clock [s]: degrees, altitude AMSL and height above home [m], each (n,),
    and velocity north, east, down (n, 3) [m/s].
    """

    times: Vector
    latitude_deg: Vector
    longitude_deg: Vector
    altitude: Vector
    height: Vector
    velocity: Points


@dataclass(frozen=True)
class Events:
    """What else a log tells, each at its time [s], in any order."""

    times: tuple[float, ...]
    messages: tuple[Message, ...]


def told(fixes: Fixes, events: Events) -> Iterator[Message]:
    """Positions and events in the order of time; before an event comes the position at its own time."""
    order = np.argsort(np.array(events.times), kind="stable")
    at = 0
    for n in order:
        time = events.times[n]
        while at < len(fixes.times) and fixes.times[at] < time:
            yield _position(fixes, float(fixes.times[at]))
            at += 1
        yield _position(fixes, time)
        yield events.messages[n]
    for time in fixes.times[at:]:
        yield _position(fixes, float(time))


def presence(autopilot: Autopilot, armed: bool, in_mission: bool) -> Heartbeat:
    """The heartbeat of a vehicle in this state."""
    firmware = Firmware.ARDUPILOT if autopilot is Autopilot.ARDUPILOT else Firmware.PX4
    mode = MISSION_MODE[autopilot] if in_mission else 0
    return Heartbeat(MAV_TYPE_QUADROTOR, firmware, CUSTOM_MODE_FLAG | (ARMED_FLAG if armed else 0), mode)


def _position(fixes: Fixes, time: float) -> Position:
    columns = (fixes.latitude_deg, fixes.longitude_deg, fixes.altitude, fixes.height, *fixes.velocity.T)
    latitude, longitude, altitude, height, north, east, down = (
        float(np.interp(time, fixes.times, column)) for column in columns
    )
    return Position(time, latitude, longitude, altitude, height, (north, east, down))
