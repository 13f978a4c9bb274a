"""Read the missions of several vehicles as flights in one frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from ipoa_mission import BadInput, Forecast, Mission, MissionError, read_mission, write_mission
from ipoa_mission.fleet.timed_flight import TimedFlight, timed_flight
from ipoa_mission.geodesy import LocalFrame, apart

FARTHEST_HOME = 50_000.0  # where a plane frame still serves [m]


@dataclass(frozen=True, eq=False)
class FleetVehicle:
    """A vehicle with its mission, and the forecast of it in the frame of all. `change`: of the mission as read."""

    file: Path
    mission: Mission
    forecast: Forecast
    flight: TimedFlight
    change: str = ""

    @property
    def name(self) -> str:
        return self.flight.name

    def flying(self, mission: Mission, frame: LocalFrame, change: str) -> "FleetVehicle":
        """Return the vehicle with a changed mission; raise MissionError if its path or time is unknown."""
        forecast = Forecast(mission)
        flight = timed_flight(self.name, forecast, frame)
        return replace(self, mission=mission, forecast=forecast, flight=flight, change=change)

    def written(self) -> tuple[Mission, dict[str, bytes]]:
        """Return the mission as a reader of its `.plan` gets it, and the content of its files by suffix."""
        with TemporaryDirectory() as folder:
            file = Path(folder, "mission.plan")
            write_mission(self.mission, file)
            read = read_mission(file)
            contents = {each.suffix: each.read_bytes() for each in Path(folder).iterdir()}
        return replace(self.mission, home=read.home, items=read.items, parameters=read.parameters), contents


@dataclass(frozen=True, eq=False)
class Fleet:
    """Vehicles in the frame of the first one's home."""

    frame: LocalFrame
    vehicles: tuple[FleetVehicle, ...]


def read_fleet(files: Sequence[Path]) -> Fleet:
    """Return the vehicles, named by their files.

    Raises:
        BadInput: a file is no mission, is named twice, has no home, or is of another place than the first.
        MissionError: the path or time of a mission is unknown; it names the file.
    """
    missions = {file: read_mission(file) for file in _once(files)}
    first = missions[files[0]]
    for file, mission in missions.items():
        away = apart(first.home, mission.home)
        if away > FARTHEST_HOME:
            words = f"expected a home within {FARTHEST_HOME / 1000:g} km of {files[0]}'s, not {away / 1000:.0f} km away"
            raise BadInput(words, code="far-from-home", place=file)
        if mission.home.altitude == 0.0 and any(other.home.altitude for other in missions.values()):
            words = "expected the altitude of home, as other missions have, not 0 m AMSL"
            raise BadInput(words, hint="set the planned home position", code="home-missing", place=file)
    stems = [file.stem for file in files]
    names = {file: file.stem if stems.count(file.stem) == 1 else str(file) for file in files}
    vehicles = tuple(_vehicle(names[file], file, mission, first.frame) for file, mission in missions.items())
    return Fleet(first.frame, vehicles)


def _once(files: Sequence[Path]) -> Sequence[Path]:
    seen = set[Path]()
    for file in files:
        if file.resolve() in seen:
            hint = "copy the mission for a second vehicle"
            raise BadInput("expected each vehicle once, not twice", hint=hint, code="option-conflict", place=file)
        seen.add(file.resolve())
    return files


def _vehicle(name: str, file: Path, mission: Mission, frame: LocalFrame) -> FleetVehicle:
    forecast = Forecast(mission)
    try:
        return FleetVehicle(file, mission, forecast, timed_flight(name, forecast, frame))
    except MissionError as error:
        raise error.at(file) from None
