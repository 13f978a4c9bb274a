"""The flight of a mission as it is expected: made once, and handed on to all who judge, draw, time or fly it."""

from functools import cached_property
from typing import TYPE_CHECKING

from ipoa_mission.errors import MissionError
from ipoa_mission.items import Mission
from ipoa_mission.itinerary.legs import Leg, Phase, flown_legs, join
from ipoa_mission.tube.flown_in import flown_in
from ipoa_mission.wind import CALM, Wind
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.ground import Ground

if TYPE_CHECKING:  # what times a flight, or proves it, is imported where it is asked for
    from ipoa_mission.itinerary.itinerary import Itinerary
    from ipoa_mission.planning.proof import Proof
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.timing.estimate import Estimate
    from ipoa_mission.timing.prediction import Prediction
    from ipoa_mission.tube.promise import Promise


class Forecast:
    """One mission's flight, in the world of a scenario if there is one; each answer is worked out when first asked.

    `mission` is then the mission as it is flown there: over the scenario's ground, on a vehicle with those of its
    parameters that the mission does not name itself. `wind`, if given, goes before the scenario's own.

    Raises:
        BadInput: the mission is of another place than the scenario.
    """

    def __init__(self, mission: Mission, scenario: "Scenario | None" = None, wind: Wind | None = None) -> None:
        self.scenario = scenario if scenario is None or wind is None else scenario.in_wind(wind)
        self.mission = mission if scenario is None else flown_in(mission, scenario)
        self.wind = wind or (CALM if scenario is None else scenario.wind.air())

    @cached_property
    def frame(self) -> LocalFrame:
        """East, north and up of home."""
        return LocalFrame(self.mission.home) if self.scenario is None else self.scenario.frame

    @cached_property
    def ground(self) -> Ground | None:
        """The ground below it, where that is known."""
        if self.scenario is not None:
            return self.scenario.airspace.ground
        return None if self.mission.ground.is_level else self.mission.ground

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The legs between its places, from the take-off to the landing, and the ways home to other rally points."""
        return flown_legs(self.mission, self.frame, self.ground)

    @property
    def cruise(self) -> list[Leg]:
        """The legs between waypoints that are flown in any case."""
        return [leg for leg in self.legs if leg.phase is Phase.CRUISE and not leg.alternative]

    @property
    def ways_home(self) -> list[Leg]:
        """The legs on which it returns, to home and to the rally points."""
        return [leg for leg in self.legs if leg.phase is Phase.RETURN]

    @cached_property
    def flight(self) -> "tuple[Itinerary, Prediction]":
        """What the vehicle meets, and when and where, if it knows where it is.

        Raises:
            BadInput: the mission has no end, or a parameter has no sense.
            MissionError: the vehicle does not get on, or it has no model.
        """
        from ipoa_mission.timing.estimate import predict

        return predict(self.mission, self.wind, sure=True)

    def quick(self, sure: bool) -> "tuple[Itinerary, Prediction]":
        """The same by compiled code; not `sure` where it is: in the mean of its flights. Raises as `flight` does."""
        from ipoa_mission.timing.estimate import predict

        return predict(self.mission, self.wind, fast=True, sure=sure)

    @cached_property
    def estimate(self) -> "Estimate":
        """How long it takes, item by item, in the mean of its flights; raises as `flight` does."""
        from ipoa_mission.timing.estimate import estimate

        return estimate(self.mission, wind=self.wind)

    @cached_property
    def promise(self) -> "Promise":
        """What its flights keep of the scenario's limits; raises as `flight` does."""
        from ipoa_mission.tube.promise import PredictedFlight, promise_of

        assert self.scenario is not None, "what is promised depends on a world"
        return promise_of(PredictedFlight(*self.flight, self.mission.autopilot, self.scenario))

    @property
    def promise_if_known(self) -> "Promise | None":
        """The same; None where nobody can say how it will be flown."""
        try:
            return self.promise if self.mission.items else None
        except MissionError:
            return None

    @cached_property
    def proof(self) -> "Proof":
        """What its legs keep from the end of the take-off to the last waypoint."""
        from ipoa_mission.planning.proof import prove

        assert self.scenario is not None, "what is kept depends on a world"
        points, stray = join(self.cruise)
        return prove(points, self.scenario, stray)
