"""Changes of a scenario that may plan what is refused, each looked at once at most."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

from ipoa_mission.errors import Remedy
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.scenario import Scenario

SLOWER = (0.5, 0.25)  # shares of the cruise speed that are tried
SLOWEST = 0.5  # [m/s]
LESS_SURE = (0.9,)  # confidences that are tried


@dataclass(frozen=True, eq=False)
class Looks:
    """What becomes of a scenario with each change; `planned` is a first look at one, None where nothing holds."""

    scenario: Scenario
    planned: Callable[[Scenario], Attempt | None]
    _seen: dict[Remedy, Attempt | None] = field(default_factory=dict)

    @cached_property
    def changes(self) -> dict[Remedy, Scenario]:
        """The changes, the harmless first: as a file has them, and the scenario with each."""
        return dict(slower(self.scenario)) | dict(_otherwise(self.scenario))

    def at(self, change: Remedy) -> Attempt | None:
        """What a change comes to."""
        if change not in self._seen:
            self._seen[change] = self.planned(self.changes[change])
        return self._seen[change]


def slower(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    """The scenario at lower cruise speeds."""
    for share in SLOWER:
        speed = max(round(share * scenario.vehicle.cruise_speed, 1), SLOWEST)
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": speed})
        yield Remedy(("vehicle", "cruise_speed"), speed), scenario.model_copy(update={"vehicle": vehicle})


def _otherwise(scenario: Scenario) -> Iterator[tuple[Remedy, Scenario]]:
    if scenario.route.mode != "fastest":
        route = scenario.route.model_copy(update={"mode": "fastest"})
        yield Remedy(("route", "mode"), "fastest"), scenario.model_copy(update={"route": route})
    for confidence in LESS_SURE:
        if scenario.safety.confidence != "nominal" and scenario.safety.confidence > confidence:
            safety = scenario.safety.model_copy(update={"confidence": confidence})
            yield Remedy(("safety", "confidence"), confidence), scenario.model_copy(update={"safety": safety})
