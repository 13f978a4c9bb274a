from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission import BadInput, DeviationLaw, Forecast, Mission, MissionError, read_mission, write_mission
from ipoa_mission.geodesy import LocalFrame, apart
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.wind import Wind

Indices: TypeAlias = NDArray[np.intp]
STEP_S = 0.25  # between samples


@dataclass(frozen=True, eq=False)
class TimedFlight:
    """The expected flight in the frame of all: `places` (n, 3) each `STEP_S` from arming to disarming [m].

    It is in the air from sample `lifts` to `lands`. `time_deviations` (n,): standard deviations of time [s].
    """

    name: str
    places: Points
    lifts: int
    lands: int
    time_deviations: Vector
    law: DeviationLaw
    departure_deviation_s: float = 1.0

    @cached_property
    def longest_step(self) -> float:
        return float(np.linalg.norm(np.diff(self.places, axis=0), axis=1).max(initial=0.0))

    def on_ground(self, samples: Indices) -> NDArray[np.bool_]:
        return np.asarray((samples <= self.lifts) | (samples >= self.lands))

    def uses_pad(self, pad: Vector) -> bool:
        return bool(np.any(within_pad(self.places[[0, -1]] - pad)))


def within_pad(away: Points) -> NDArray[np.bool_]:
    """Return whether places `away` (..., 3) [m] from each other are one pad."""
    width = 2.0  # [m]
    return np.asarray(np.linalg.norm(away, axis=-1) < width)


def timed_flight(name: str, forecast: Forecast, frame: LocalFrame) -> TimedFlight:
    """Sample an expected flight; raise MissionError if nothing is flown, or end, path or time is unknown."""
    forecast.expect_known_path()
    prediction = forecast.expected
    track = prediction.track.local()
    seconds = np.arange(0.0, track.times[-1] + STEP_S, STEP_S)
    sampled = track.without_repeated_times().at(seconds)
    moving = np.flatnonzero(np.linalg.norm(np.diff(sampled, axis=0), axis=1) > 1e-3)
    if len(moving) == 0:
        raise MissionError("the vehicle stays where it is", code="nothing-flown")
    deviations = (prediction.high - prediction.low) / (2 * 1.645)  # of normal times, in 90 % of flights
    return TimedFlight(
        name=name,
        places=frame.moved(sampled, forecast.frame),
        lifts=int(moving[0]),
        lands=int(moving[-1]) + 1,
        time_deviations=np.interp(seconds, prediction.done, deviations, left=0.0),
        law=forecast.deviation_law,
    )


@dataclass(frozen=True, eq=False)
class FleetVehicle:
    """`change`: of the mission in `file`; `contents`: of the changed mission's files, by suffix."""

    file: Path
    forecast: Forecast
    flight: TimedFlight
    change: str = ""
    contents: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def mission(self) -> Mission:
        return self.forecast.mission

    def flying(self, mission: Mission, frame: LocalFrame, change: str) -> "FleetVehicle":
        """Return the vehicle with a mission as read from its `.plan`; raises as `timed_flight`."""
        with TemporaryDirectory() as folder:
            file = Path(folder, "mission.plan")
            write_mission(mission, file)
            read = read_mission(file)
            contents = {each.suffix: each.read_bytes() for each in Path(folder).iterdir()}
        flown = replace(mission, home=read.home, items=read.items, parameters=read.parameters)
        forecast = Forecast(flown, wind=self.forecast.wind)
        return FleetVehicle(self.file, forecast, timed_flight(self.flight.name, forecast, frame), change, contents)


def read_fleet(files: Sequence[Path], wind: Wind | None = None) -> list[FleetVehicle]:
    """Return the vehicles in the frame of the first one's home, in calm air or a `wind`.

    Raises:
        BadInput: a mission has no home or flight, is of another kind or place, or named twice.
    """
    missions = dict[Path, Mission]()
    for file in files:
        if any(file.resolve() == other.resolve() for other in missions):
            hint = "copy the mission for a second vehicle"
            raise BadInput("expected each vehicle once, not twice", hint, code="option-conflict", place=file)
        missions[file] = read_mission(file)
    first = missions[files[0]]
    farthest = 50_000.0  # where a plane frame still serves [m]
    for file, mission in missions.items():
        away = apart(first.home, mission.home)
        if away > farthest:
            words = f"expected a home within {farthest / 1000:g} km of {files[0]}'s, not {away / 1000:.0f} km away"
            raise BadInput(words, code="far-from-home", place=file)
        if mission.home.altitude == 0.0 and any(other.home != mission.home for other in missions.values()):
            words = "expected the altitude of home, not 0 m AMSL, as homes differ"
            raise BadInput(words, hint="set the planned home position", code="home-missing", place=file)
    stems = [file.stem for file in files]
    names = {file: file.stem if stems.count(file.stem) == 1 else str(file) for file in files}
    return [
        _vehicle(names[file], file, Forecast(mission, wind=wind), first.frame) for file, mission in missions.items()
    ]


def _vehicle(name: str, file: Path, forecast: Forecast, frame: LocalFrame) -> FleetVehicle:
    mission = forecast.mission_as_read
    if mission.other_vehicle:
        words = f"expected a mission of a multicopter, not of {mission.other_vehicle}"
        raise BadInput(words, code="other-vehicle", place=file)
    try:
        return FleetVehicle(file, forecast, timed_flight(name, forecast, frame))
    except MissionError as error:
        raise BadInput(error.args[0], error.hint, code=error.code, place=error.at(file).place) from None
