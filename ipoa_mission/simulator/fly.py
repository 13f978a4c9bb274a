"""Fly a mission over MAVLink bytes, on a virtual clock."""

from pathlib import Path

from ipoa_mission.autopilot.known_parameters import expect_known
from ipoa_mission.autopilot.parameters import NO_PARAMETERS, Parameters
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.line import Line
from ipoa_mission.link.loopback import Loopback
from ipoa_mission.link.messages import STATION_COMPONENT, STATION_SYSTEM
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.progress import Progress, silent
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.faults import BadPipe, Faults
from ipoa_mission.simulator.mock_server import PERFECT
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Station
from ipoa_mission.wind import CALM, Wind


def fly(
    mission: Mission,
    parameters: Parameters = NO_PARAMETERS,
    wind: Wind = CALM,
    *,
    seed: int = 0,
    faults: Faults = PERFECT,
    log: str | Path | None = None,
    uploading: Progress = silent,
    flying: Progress = silent,
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
        uploading: receives the progress of the upload.
        flying: receives the progress of the flight.

    Returns:
        The record of the flight.

    Raises:
        BadInput: the autopilot has no such parameter.
        MissionRefused, Unflyable, NoAnswer: as with a real vehicle.

    Example:
        >>> from ipoa_mission import fly, read_mission
        >>> fly(read_mission("missions/sitl.plan")).completed
        True
    """
    expect_known(parameters, mission.autopilot)
    forecast = Forecast(mission.with_parameters(parameters), wind=wind)
    with board(forecast, seed, faults, log) as vehicle:
        return _fly(vehicle, forecast.mission, uploading, flying)


def fly_forecast(
    forecast: Forecast,
    seed: int = 0,
    faults: Faults = PERFECT,
    log: str | Path | None = None,
    flying: Progress = silent,
) -> FlightRecord:
    """Fly in the forecast's wind and over its ground."""
    with board(forecast, seed, faults, log) as vehicle:
        return _fly(vehicle, forecast.mission, silent, flying)


def _fly(vehicle: Vehicle, mission: Mission, uploading: Progress, flying: Progress) -> FlightRecord:
    vehicle.upload(mission, uploading, checked=False)
    vehicle.prepare()
    vehicle.start()
    return vehicle.watch(flying)


def board(forecast: Forecast, seed: int = 0, faults: Faults = PERFECT, log: str | Path | None = None) -> Vehicle:
    mission = forecast.mission
    autopilot = BuiltInAutopilot(
        mission.autopilot,
        mission.home,
        mission.parameters,
        nak_at=faults.nak_at,
        conditions=Conditions(forecast.wind, forecast.ground, mission.vehicle, mission.firmware_version, seed),
    )
    station = Station(autopilot)
    pipes = (None, None) if faults.is_none else (BadPipe(faults, 2 * seed), BadPipe(faults, 2 * seed + 1))
    line = Line(Loopback(station, *pipes), Codec(STATION_SYSTEM, STATION_COMPONENT), log)
    return meet(line)
