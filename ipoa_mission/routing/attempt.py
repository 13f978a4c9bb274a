"""One try of a flight: a plan, a route along it, and what its flights keep."""

from dataclasses import dataclass

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.tube.promise import Promise
from ipoa_mission.planning.plan import Plan
from ipoa_mission.routing.route import Route


@dataclass(frozen=True, eq=False)
class Attempt:
    """A plan, the best route along it that was looked at, and the forecast of its mission."""

    plan: Plan
    route: Route
    forecast: Forecast

    @property
    def promise(self) -> Promise:
        """What its flights keep."""
        return self.forecast.promise

    @property
    def holds(self) -> bool:
        """Whether enough flights keep every limit on the way."""
        return not any(kept.forbids for kept in self.promise.limits)

    @property
    def slack(self) -> float:
        """How much more than required is kept on the way, of all limits the least [m]."""
        return min((kept.slack for kept in self.promise.limits if kept.on_the_way), default=0.0)
