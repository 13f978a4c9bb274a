"""One try of a flight: a plan, a route along it, and what its flights keep."""

from dataclasses import dataclass

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.shortfalls import Shortfall
from ipoa_mission.forecast.tube.promise import Promise
from ipoa_mission.planning.plan import Plan
from ipoa_mission.routing.build import build_mission, draft_mission
from ipoa_mission.routing.endings import settled
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Attempt:
    """A plan, the best route along it that was looked at, the forecast of its mission, and what its endings lack."""

    plan: Plan
    route: Route
    forecast: Forecast
    short: tuple[Shortfall, ...] = ()

    @property
    def promise(self) -> Promise:
        """What its flights keep."""
        return self.forecast.promise

    @property
    def holds(self) -> bool:
        """Whether enough flights keep every limit on the way, and every ending that is planned is clear."""
        return not self.short and not any(kept.forbids for kept in self.promise.limits)

    @property
    def slack(self) -> float:
        """How much more than required is kept on the way and by its endings, of all limits the least [m]."""
        kept = min((kept.slack for kept in self.promise.limits if kept.on_the_way), default=0.0)
        return min([kept, *(-one.missing for one in self.short)])


def attempted(plan: Plan, route: Route, scenario: Scenario, quick: bool = False) -> Attempt:
    """What a route promises: as its whole mission is flown, where it can be one; `quick`: of its endings nothing.

    Raises:
        NoRoute, Unsafe, BadInput: as `build_mission`, of a route that may be flown otherwise.
    """
    attempt = Attempt(plan, route, Forecast(draft_mission(route, scenario), scenario))
    if not attempt.holds:
        return attempt
    built = build_mission(route, scenario)
    if built != attempt.forecast.mission:
        attempt = Attempt(plan, route, Forecast(built, scenario))
    if scenario.safety.returns == "planned" and attempt.holds and not quick:
        return Attempt(plan, route, *settled(attempt.forecast))
    return attempt
