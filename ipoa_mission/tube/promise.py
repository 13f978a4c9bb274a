"""The promise: what clearance the predicted path of a mission has, and what is left of it in 99 % of flights."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import ENDINGS, FLOWN_TO, TAKEOFFS
from ipoa_mission.geometry import Points
from ipoa_mission.items import Mission
from ipoa_mission.itinerary.itinerary import Itinerary
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.estimate import in_local_frame, predict
from ipoa_mission.timing.prediction import Prediction
from ipoa_mission.tube.approach import approaches
from ipoa_mission.tube.course import Course, course_of
from ipoa_mission.tube.law import Law
from ipoa_mission.tube.limits import NO_TUBE, Rim, limits_kept, rim_of
from ipoa_mission.tube.measured import law_of
from ipoa_mission.tube.thin import STRAY, thinned


@dataclass(frozen=True)
class Kept:
    """One limit in one part of the flight: what the predicted path has of it and what flights keep [m].

    `nominal` and `kept` are distances, of a ceiling heights; `to` is what is near, `item` the item on the way to which
    it is (as in mission files, home is 0), `place` where.
    """

    limit: str
    required: float
    nominal: float
    kept: float
    to: str
    item: int
    place: tuple[float, float, float]
    on_the_way: bool

    @property
    def slack(self) -> float:
        """How much more than required is kept [m]."""
        return self.required - self.kept if self.limit == "ceiling" else self.kept - self.required

    def words(self, confidence: float | None) -> str:
        """Nominal, kept and required in one line without a full stop."""
        nominal, most = f"nominal {self.nominal:.2f} m", "at most " if self.limit == "ceiling" else ""
        if confidence is None:
            return f"{nominal}; {most}{self.required:.2f} m required"
        share = f"{100 * confidence:g} % of flights keep"
        return f"{nominal}; {share} {most}{self.kept:.2f} m; {self.required:.2f} m required"


@dataclass(frozen=True)
class Promise:
    """What a mission keeps of every limit, on the way and in its ending, at the scenario's confidence."""

    confidence: float | None
    limits: tuple[Kept, ...]
    flight: "PredictedFlight" = field(repr=False, compare=False)

    @property
    def broken(self) -> tuple[Kept, ...]:
        """The limits that fewer flights keep than must, by more than rounding."""
        return tuple(kept for kept in self.limits if kept.slack < -2 * STRAY)

    @property
    def clearance(self) -> Kept | None:
        """The least that is kept to anything solid on the way, or to an obstacle before and after it."""
        solid = [kept for kept in self.limits if kept.limit in ("obstacles", "ground") and np.isfinite(kept.kept)]
        return min(solid, key=lambda kept: kept.kept, default=None)


def tube_holds(course: Course, path: Points, autopilot: Autopilot, scenario: Scenario) -> bool:
    """Whether flights keep every limit on a course, as often as the scenario asks; `path` is the same, thinned."""
    chance = scenario.safety.chance
    if chance is None:
        return True
    law, required = law_of(autopilot, scenario.wind.speed), scenario.limits.obstacle_distance
    if approaches(course, scenario.airspace, law, required).chance(required) > chance:
        return False
    return all(check.slack >= -2 * STRAY for check in limits_kept(path, scenario, rim_of(law, chance)))


def promise_of(mission: Mission, scenario: Scenario) -> Promise:
    """What the mission promises in the world of a scenario.

    Raises:
        BadInput: the mission has no end, or a parameter has no sense.
        MissionError: the vehicle does not get on.
    """
    route, prediction = predict(mission, scenario.wind.air(), sure=True)
    flight = PredictedFlight(route, prediction, mission.autopilot, scenario)
    chance = scenario.safety.chance
    return Promise(None if chance is None else 1.0 - chance, tuple(flight.limits(chance)), flight)


@dataclass(frozen=True, eq=False)
class PredictedFlight:
    """A mission as the time model flies it in the world of a scenario."""

    route: Itinerary
    prediction: Prediction
    autopilot: Autopilot
    scenario: Scenario

    @cached_property
    def course(self) -> Course:
        """The whole of it, from the ground to the ground; wider after the last waypoint."""
        return course_of(in_local_frame(self.prediction.track))

    @cached_property
    def way(self) -> tuple[float, float]:
        """When the take-off ends and when the last waypoint is done [s]."""
        done, visits = self.prediction.done, self.route.visits
        begins = [float(at) for at, visit in zip(done, visits, strict=True) if visit.item.command in TAKEOFFS]
        ends = [
            float(at)
            for at, visit in zip(done, visits, strict=True)
            if visit.item.command in FLOWN_TO and visit.item.command not in ENDINGS | TAKEOFFS
        ]
        begin = min(begins, default=0.0)
        return begin, max(ends[-1] if ends else begin, begin)

    def limits(self, chance: float | None) -> Iterator[Kept]:
        """Obstacles before, on and after the way; ground, ceiling and bounds on it."""
        begin, end = self.way
        last = float(self.course.times[-1])
        law = law_of(self.autopilot, self.scenario.wind.speed)
        parts = ((0.0, begin, law), (begin, end, law), (end, last, law.after_the_way()))
        for n, (first, then, its_law) in enumerate(parts):
            if then > first:
                yield from self._obstacles(self.course.part(first, then), its_law, chance, on_the_way=n == 1)
        part = self.course.part(begin, end)
        rim = NO_TUBE if chance is None else rim_of(law, chance)
        yield from self._others(part, rim)

    def _obstacles(self, part: Course, law: Law, chance: float | None, on_the_way: bool) -> Iterator[Kept]:
        airspace = self.scenario.airspace
        if not airspace.obstacles:
            return
        nominal = airspace.obstacle_clearance(thinned(part.points, STRAY))
        required = self.scenario.limits.obstacle_distance
        least, kept, to, place = nominal.distance - STRAY, nominal.distance - STRAY, nominal.what, nominal.place
        if chance is not None:
            near = approaches(part, airspace, law, least)
            kept = min(near.kept(chance), least)
            piece, body = near.likeliest(kept)
            east, north, up = (float(x) for x in part.points[piece])
            to, place = airspace.obstacles[body].name, (east, north, up)
        yield Kept("obstacles", required, least, kept, to, self._item(part, place), place, on_the_way)

    def _others(self, part: Course, rim: Rim) -> Iterator[Kept]:
        path = thinned(part.points, STRAY)
        nominal = {(c.limit, c.required): c for c in limits_kept(path, self.scenario, NO_TUBE)}
        for check in limits_kept(path, self.scenario, rim):
            meant = nominal.get((check.limit, check.required), check)
            place = check.nearest.place
            yield Kept(
                check.limit,
                check.required,
                meant.nearest.distance,
                check.nearest.distance,
                check.nearest.what,
                self._item(part, place),
                place,
                True,
            )

    def _item(self, part: Course, place: tuple[float, float, float]) -> int:
        """The item that is flown to where a part of the course is nearest to a place."""
        nearest = int(np.argmin(np.linalg.norm(part.points - np.array(place), axis=1)))
        at = float(part.times[nearest])
        seqs = [visit.seq for visit in self.route.visits]
        later = np.searchsorted(self.prediction.done, at - 1e-6)
        return seqs[min(int(later), len(seqs) - 1)] if seqs else 0
