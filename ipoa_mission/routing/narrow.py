"""Find walls with gaps narrower than the deviation bound."""

from dataclasses import dataclass
from itertools import pairwise

from ipoa_mission.centimeters import down, up
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.deviation.approach import TYPICAL_CHANCE
from ipoa_mission.forecast.deviation.kept_limits import tight_places
from ipoa_mission.forecast.deviation.law import DeviationLaw, law_of
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE
from ipoa_mission.planning.plan_view import DISTANCE_TOLERANCE, Closure, closure
from ipoa_mission.planning.problem import prepare
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.path_limits import place_names


@dataclass(frozen=True)
class Narrow:
    gap: Closure
    leg: str

    def words(self) -> str:
        east, north = self.gap.place
        width, needed = f"{down(self.gap.width):.2f} m wide", f"{up(self.gap.needed):.2f} m"
        where = f"at east {east:.1f}, north {north:.1f} m{self.leg}"
        return f"the gap between {' and '.join(self.gap.names)} is {width}, and it needs {needed} at least, {where}"


class TooNarrow(MissionError):
    """Geometry alone shows that too few flights would keep the limits."""

    def __init__(self, narrow: Narrow) -> None:
        super().__init__(narrow.words())
        self.narrow = narrow


def expect_wide(scenario: Scenario) -> None:
    """Raise if every way leads through a gap narrower than the least deviation bound.

    Raises:
        TooNarrow: on a leg between given places.
    """
    chance, law = scenario.safety.chance, law_of(scenario.vehicle.autopilot, scenario.wind.strongest)
    if chance is None or not scenario.airspace.obstacles:
        return
    if tight_places(scenario, 2 * THINNING_TOLERANCE + law.lateral(chance)):
        return  # less clearance is required there
    more = least_reach(law, chance)
    wider = scenario.model_copy(update={"safety_distance": scenario.safety_distance + more})
    names = place_names(scenario.places)
    problem = prepare(wider)
    for places, (a, b) in zip(pairwise(names), pairwise(scenario.places), strict=True):
        gap = closure(problem, a, b)
        if gap is not None and gap.needed - 2 * more < gap.width < gap.needed - DISTANCE_TOLERANCE:
            raise TooNarrow(Narrow(gap, f", on the leg from {places[0]} to {places[1]}" if len(names) > 2 else ""))


def least_reach(law: DeviationLaw, chance: float) -> float:
    """Return the least extra distance next to an obstacle [m]; less above and below it."""
    usual = [spread.distance(TYPICAL_CHANCE) for spread in (law.down, law.up)]
    facing = min(1.0, min(usual) / law.level.distance(TYPICAL_CHANCE))
    reach = [spread.distance(chance) for spread in (law.down, law.up, law.lowest, law.highest)]
    reach.append(facing * law.level.distance(chance))
    if law.farthest is not None:
        reach.append(facing * law.farthest.distance(chance / 2))
    return max(min(reach), 0.0)
