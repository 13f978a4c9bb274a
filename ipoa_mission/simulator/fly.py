"""A mission flown on the built-in autopilot over real MAVLink bytes, on a virtual clock: as fast as it goes."""

from pathlib import Path

from ipoa_mission.items import Mission
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.line import Line
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.loopback import Loopback
from ipoa_mission.link.messages import STATION_COMPONENT, STATION_SYSTEM
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.progress import Progress, silent
from ipoa_mission.simulator.autopilot import BuiltInAutopilot
from ipoa_mission.simulator.conditions import Conditions
from ipoa_mission.simulator.faults import BadPipe, Faults
from ipoa_mission.simulator.server import PERFECT
from ipoa_mission.simulator.station import Station
from ipoa_mission.vehicles.known_parameters import expect_known
from ipoa_mission.vehicles.parameters import NO_PARAMETERS, Parameters
from ipoa_mission.wind import CALM, Wind


def fly(
    mission: Mission,
    parameters: Parameters = NO_PARAMETERS,
    seed: int = 0,
    faults: Faults = PERFECT,
    log: str | Path | None = None,
    uploading: Progress = silent,
    flying: Progress = silent,
    wind: Wind = CALM,
) -> FlightRecord:
    """Upload a mission to the built-in autopilot that it was made for, fly it, and return what happened.

    `parameters` of the vehicle go before those that the mission carries; `log` gets every frame. The same arguments
    give the same bytes. The mission is not checked: what happens to a bad one can be seen here.

    Raises:
        BadInput: a parameter is none of this autopilot's.
        MissionRefused, Unflyable, NoAnswer: as with a real vehicle.
    """
    with board(mission, parameters, seed, faults, log, wind) as vehicle:
        vehicle.upload(mission, uploading, checked=False)
        vehicle.prepare()
        vehicle.start()
        return vehicle.watch(flying)


def board(
    mission: Mission,
    parameters: Parameters = NO_PARAMETERS,
    seed: int = 0,
    faults: Faults = PERFECT,
    log: str | Path | None = None,
    wind: Wind = CALM,
) -> Vehicle:
    """A connected simulated vehicle that stands at the mission's home."""
    expect_known(parameters, mission.autopilot)
    values = mission.with_parameters(parameters).parameters
    flown_in = Conditions(wind, mission.ground, mission.vehicle)
    version = mission.firmware_version or mission.autopilot.firmware().version
    autopilot = BuiltInAutopilot(
        mission.autopilot,
        mission.home,
        values,
        nak_at=faults.nak_at,
        seed=seed,
        conditions=flown_in,
        version=version,
    )
    station = Station(autopilot)
    pipes = (None, None) if faults.is_none else (BadPipe(faults, 2 * seed), BadPipe(faults, 2 * seed + 1))
    line = Line(Loopback(station, *pipes), Codec(STATION_SYSTEM, STATION_COMPONENT), log)
    return meet(line)
