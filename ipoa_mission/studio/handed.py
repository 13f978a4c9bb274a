"""Hand a mission, its forecast and a digest from the planner process to the pilot process."""

import hashlib
import json
import pickle
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ipoa_mission.finding import Finding
from ipoa_mission.flight.flight import Flight
from ipoa_mission.flight.survey_flight import Survey
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission

UNKNOWN = "no scenario gives the obstacles: neither clearance nor contingencies were checked"


@dataclass(frozen=True)
class HandedOver:
    """A mission that may be flown. `remarks` are for the user, who starts it by its `proof`."""

    name: str
    forecast: Forecast
    proof: str
    remarks: tuple[str, ...] = ()

    def write(self, file: Path) -> None:
        """Write to a file in a folder of this user only."""
        file.write_bytes(pickle.dumps(self))

    @classmethod
    def take(cls, file: Path) -> "HandedOver":
        handed = pickle.loads(file.read_bytes())
        file.unlink()
        assert isinstance(handed, cls)
        return handed


def planned_over(flight: Flight) -> HandedOver:
    return HandedOver(flight.name, flight.forecast, proof_digest(flight))


def survey_over(survey: Survey, n: int) -> HandedOver:
    """Return flight `n` of a survey; its digest covers the proof of all flights."""
    forecast = survey.flights[n]
    return HandedOver(survey.names[n], forecast, _digest(forecast.mission, [n, survey.summary()]))


def mission_over(name: str, forecast: Forecast, warnings: Sequence[Finding]) -> HandedOver:
    """Return a mission of a file without errors, with the parameters that were checked."""
    mission, scenario = forecast.mission, forecast.scenario
    told = tuple(finding.message for finding in warnings)
    about = [None if scenario is None else scenario.name, *told, forecast.estimate.total_s]
    known = Forecast(replace(forecast.given, parameters=mission.parameters), scenario, forecast.wind)
    return HandedOver(name, known, _digest(mission, about), (*told, *([UNKNOWN] if scenario is None else [])))


def proof_digest(flight: Flight) -> str:
    """Return ten hexadecimal digits of the mission, its proof and its promise."""
    return _digest(flight.mission, flight.summary())


def _digest(mission: Mission, about: object) -> str:
    written = repr((mission.home, mission.items, mission.fence, mission.rally, sorted(mission.parameters.items())))
    known = f"{mission.autopilot} {written} {json.dumps(about, sort_keys=True)}"
    return hashlib.sha256(known.encode()).hexdigest()[:10]
