"""What the planner's process hands to the pilot's: a mission, its forecast, and a digest by which a start names it."""

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

UNKNOWN = "no scenario says what stands there: no clearance was looked at, and none of the ways in which it can end"


@dataclass(frozen=True)
class HandedOver:
    """A mission that may be flown. `remarks` are for the user, who starts it by its `proof`."""

    name: str
    forecast: Forecast
    proof: str
    remarks: tuple[str, ...] = ()

    def write(self, file: Path) -> None:
        """Into a file in a folder of this user's alone."""
        file.write_bytes(pickle.dumps(self))

    @classmethod
    def take(cls, file: Path) -> "HandedOver":
        """Out of such a file, which is gone then."""
        handed = pickle.loads(file.read_bytes())
        file.unlink()
        assert isinstance(handed, cls)
        return handed


def planned_over(flight: Flight) -> HandedOver:
    """A flight that was planned and proved."""
    return HandedOver(flight.name, flight.forecast, proof_digest(flight))


def survey_over(survey: Survey, n: int) -> HandedOver:
    """One flight of a survey; its digest is also of what was proved of all."""
    forecast = survey.flights[n]
    return HandedOver(survey.names[n], forecast, _digest(forecast.mission, [n, survey.summary()]))


def mission_over(name: str, forecast: Forecast, warnings: Sequence[Finding]) -> HandedOver:
    """A mission of a file in which the check found no error, with the parameters by which it was judged."""
    mission, scenario = forecast.mission, forecast.scenario
    told = tuple(finding.message for finding in warnings)
    about = [None if scenario is None else scenario.name, *told, forecast.estimate.total_s]
    known = Forecast(replace(forecast.given, parameters=mission.parameters), scenario, forecast.wind)
    return HandedOver(name, known, _digest(mission, about), (*told, *([UNKNOWN] if scenario is None else [])))


def proof_digest(flight: Flight) -> str:
    """Ten hexadecimal digits of the mission and of what was proved and promised about it."""
    return _digest(flight.mission, flight.summary())


def _digest(mission: Mission, about: object) -> str:
    written = repr((mission.home, mission.items, mission.fence, mission.rally, sorted(mission.parameters.items())))
    known = f"{mission.autopilot} {written} {json.dumps(about, sort_keys=True)}"
    return hashlib.sha256(known.encode()).hexdigest()[:10]
