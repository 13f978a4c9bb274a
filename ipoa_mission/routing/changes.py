"""Changes of a scenario that may make it plannable."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

from ipoa_mission.errors import Remedy
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.scenario import Scenario

SPEED_SHARES = (0.5, 0.25)
LEAST_SPEED = 0.5  # [m/s]
LOWER_CONFIDENCES = (0.9,)


@dataclass(frozen=True, eq=False)
class ChangeTrials:
    """`planned` returns None without a valid plan."""

    scenario: Scenario
    planned: Callable[[Scenario], Attempt | None]
    _seen: dict[Remedy, Attempt | None] = field(default_factory=dict)

    @cached_property
    def changes(self) -> dict[Remedy, Scenario]:
        return dict(slower(self.scenario)) | dict(_otherwise(self.scenario))

    def at(self, change: Remedy) -> Attempt | None:
        if change not in self._seen:
            self._seen[change] = self.planned(self.changes[change])
        return self._seen[change]


def slower(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    for share in SPEED_SHARES:
        speed = max(round(share * scenario.vehicle.cruise_speed, 1), LEAST_SPEED)
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": speed})
        yield Remedy(("vehicle", "cruise_speed"), speed), scenario.model_copy(update={"vehicle": vehicle})


def _otherwise(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    if scenario.route.mode != "fastest":
        route = scenario.route.model_copy(update={"mode": "fastest"})
        yield Remedy(("route", "mode"), "fastest"), scenario.model_copy(update={"route": route})
    for confidence in LOWER_CONFIDENCES:
        if scenario.safety.confidence != "nominal" and scenario.safety.confidence > confidence:
            safety = scenario.safety.model_copy(update={"confidence": confidence})
            yield Remedy(("safety", "confidence"), confidence), scenario.model_copy(update={"safety": safety})
