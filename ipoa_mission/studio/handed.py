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
    """Return its flights, each with a digest of all of them."""
    summary = survey.summary()
    return [
        HandedOver(name, forecast, _digest(forecast.mission, [n, summary]))
        for n, (name, forecast) in enumerate(zip(survey.names, survey.flights, strict=True))
    ]


def mission_over(name: str, forecast: Forecast, warnings: Sequence[Finding]) -> HandedOver:
    mission = forecast.mission
    scenario = forecast.scenario
    remarks = [finding.message for finding in warnings]
    judged_by = [None if scenario is None else scenario.name, *remarks, forecast.estimate.total_s]
    if scenario is None:
        remarks.append("no scenario gives the obstacles: neither clearance nor contingencies were checked")
    with_parameters = replace(forecast.mission_as_read, parameters=mission.parameters)
    handed = Forecast(with_parameters, scenario, forecast.wind)
    return HandedOver(name, handed, _digest(mission, judged_by), tuple(remarks))


def _digest(mission: Mission, proof: object) -> str:
    content = repr((mission.home, mission.items, mission.fence, mission.rally, sorted(mission.parameters.items())))
    text = f"{mission.autopilot} {content} {json.dumps(proof, sort_keys=True)}"
    return hashlib.sha256(text.encode()).hexdigest()[:10]
