"""A mission that the planner hands to the flight worker."""

import hashlib
import json
import pickle
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ipoa_mission import Finding, Flight, Forecast, Mission, Survey


@dataclass(frozen=True)
class HandedOver:
    name: str
    forecast: Forecast
    proof: str
    remarks: tuple[str, ...] = ()

    def write(self, file: Path) -> None:
        file.write_bytes(pickle.dumps(self))

    @classmethod
    def take(cls, file: Path) -> "HandedOver":
        handed = pickle.loads(file.read_bytes())
        file.unlink()
        assert isinstance(handed, cls)
        return handed


def planned_over(flight: Flight) -> HandedOver:
    return HandedOver(flight.name, flight.forecast, _digest(flight.mission, flight.summary()))


def survey_over(survey: Survey) -> list[HandedOver]:
    """Return its flights; each digest covers all of them."""
    flights, summary = zip(survey.names, survey.flights, strict=True), survey.summary()
    return [HandedOver(name, each, _digest(each.mission, [n, summary])) for n, (name, each) in enumerate(flights)]


def mission_over(name: str, forecast: Forecast, warnings: Sequence[Finding]) -> HandedOver:
    mission, scenario = forecast.mission, forecast.scenario
    remarks = [finding.message for finding in warnings]
    about = [None if scenario is None else scenario.name, *remarks, forecast.estimate.total_s]
    if scenario is None:
        remarks.append("no scenario gives the obstacles: neither clearance nor contingencies were checked")
    known = Forecast(replace(forecast.mission_as_read, parameters=mission.parameters), scenario, forecast.wind)
    return HandedOver(name, known, _digest(mission, about), tuple(remarks))


def _digest(mission: Mission, about: object) -> str:
    written = repr((mission.home, mission.items, mission.fence, mission.rally, sorted(mission.parameters.items())))
    known = f"{mission.autopilot} {written} {json.dumps(about, sort_keys=True)}"
    return hashlib.sha256(known.encode()).hexdigest()[:10]
