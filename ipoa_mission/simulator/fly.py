from pathlib import Path

from ipoa_mission.autopilot.known_parameters import expect_known
from ipoa_mission.autopilot.parameters import NO_PARAMETERS, Parameters
from ipoa_mission.ground import Ground
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.messages import STATION_COMPONENT, STATION_SYSTEM
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.landing_ground import known_ground
from ipoa_mission.progress import Progress, silent
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import PERFECT, Faults, Loopback, Station
from ipoa_mission.wind import CALM, Wind


def fly_built_in(
    mission: Mission,
    parameters: Parameters = NO_PARAMETERS,
    wind: Wind = CALM,
    *,
    seed: int = 0,
    faults: Faults = PERFECT,
    log: str | Path | None = None,
) -> FlightRecord:
    """Upload a mission to the built-in autopilot, and fly it on a virtual clock.

    The mission is not checked before. The same arguments give the same bytes.

    Args:
        mission: to fly.
        parameters: override those of the mission.
        wind: during the flight.
        seed: of the random numbers.
        faults: of the link.
        log: path of a `.tlog`.

    Returns:
        The record of the flight.

    Raises:
        BadInput: the autopilot has no such parameter.
        MissionRefused, Unflyable, NoAnswer: as with a real vehicle.

    Example:
        >>> from ipoa_mission import fly_built_in, read_mission
        >>> fly_built_in(read_mission("missions/sitl.plan")).completed
        True
    """
    expect_known(parameters, mission.autopilot)
    mission = mission.with_parameters(parameters)
    with board(mission, conditions_for(mission, wind, seed=seed), faults, log) as vehicle:
        return fly_aboard(vehicle, mission)


def fly_aboard(vehicle: Vehicle, mission: Mission, flying: Progress = silent) -> FlightRecord:
    vehicle.upload(mission, checked=False)
    vehicle.prepare()
    vehicle.start()
    return vehicle.watch(flying)


def conditions_for(mission: Mission, wind: Wind = CALM, ground: Ground | None = None, seed: int = 0) -> Conditions:
    """`ground`: by default as the mission's landing knows it."""
    ground = known_ground(mission) if ground is None else ground
    return Conditions(wind, ground, mission.vehicle, mission.firmware_version, seed)


def board(
    mission: Mission, conditions: Conditions | None = None, faults: Faults = PERFECT, log: str | Path | None = None
) -> Vehicle:
    conditions = conditions or conditions_for(mission)
    autopilot = BuiltInAutopilot(mission.autopilot, mission.home, mission.parameters, conditions)
    station = Station(autopilot)
    channel = Loopback(station, faults, conditions.seed)
    return meet(Connection(channel, Codec(STATION_SYSTEM, STATION_COMPONENT), log))
