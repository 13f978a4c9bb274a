"""What no path can promise: walls through all heights that leave no gap as wide as the tube of a straight flight."""

from dataclasses import dataclass
from itertools import pairwise

from ipoa_mission.centimeters import down, up
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.deviation.approach import TYPICAL_CHANCE
from ipoa_mission.forecast.deviation.law import DeviationLaw
from ipoa_mission.forecast.deviation.measured_law import law_of
from ipoa_mission.forecast.deviation.tight_places import tight_places
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE
from ipoa_mission.planning.plan_view import CLOSE, Closure, closure
from ipoa_mission.planning.problem import prepare
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.path_limits import place_names


@dataclass(frozen=True)
class Narrow:
    """The widest gap between two places that are named, and that it is narrower than any flight's tube."""

    gap: Closure
    leg: str

    def words(self) -> str:
        """The gap, its width, what it needs and where it is, without a full stop."""
        east, north = self.gap.place
        width, needed = f"{down(self.gap.width):.2f} m wide", f"{up(self.gap.needed):.2f} m"
        where = f"at east {east:.1f}, north {north:.1f} m{self.leg}"
        return f"the gap between {' and '.join(self.gap.names)} is {width}, and it needs {needed} at least, {where}"


class TooNarrow(MissionError):
    """Not a search but geometry says that too few flights would keep the limits; `narrow` is where."""

    def __init__(self, narrow: Narrow) -> None:
        super().__init__(narrow.words())
        self.narrow = narrow


def expect_wide(scenario: Scenario) -> None:
    """Complain where every way leads through a gap that is too narrow for the least tube.

    A gap that is even narrower than the required distance on both sides is not looked for: `plan_path` names it.

    Raises:
        TooNarrow: on some leg between given places.
    """
    chance, law = scenario.safety.chance, law_of(scenario.vehicle.autopilot, scenario.wind.strongest)
    if chance is None or not scenario.airspace.obstacles:
        return
    if tight_places(scenario, 2 * THINNING_TOLERANCE + law.lateral(chance)):
        return  # round these less is promised
    more = least_reach(law, chance)
    wider = scenario.model_copy(update={"safety_distance": scenario.safety_distance + more})
    names = place_names(scenario.places)
    problem = prepare(wider)
    for places, (a, b) in zip(pairwise(names), pairwise(scenario.places), strict=True):
        gap = closure(problem, a, b)
        if gap is not None and gap.needed - 2 * more < gap.width < gap.needed - CLOSE:
            raise TooNarrow(Narrow(gap, f", on the leg from {places[0]} to {places[1]}" if len(names) > 2 else ""))


def least_reach(law: DeviationLaw, chance: float) -> float:
    """What a flight must have at least beside what is required, wherever it passes anything [m].

    No promise of one pass asks for less: it is short of a limit as often as the likeliest of its ways to be. Above and
    below a body what leads to its side may count for less.
    """
    usual = [spread.distance(TYPICAL_CHANCE) for spread in (law.down, law.up)]
    facing = min(1.0, min(usual) / law.level.distance(TYPICAL_CHANCE))
    reach = [spread.distance(chance) for spread in (law.down, law.up, law.lowest, law.highest)]
    reach.append(facing * law.level.distance(chance))
    if law.farthest is not None:
        reach.append(facing * law.farthest.distance(chance / 2))
    return max(min(reach), 0.0)
