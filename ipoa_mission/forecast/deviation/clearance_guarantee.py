from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import ipoa_mission.forecast.deviation.kept_limits as kept_limits
from ipoa_mission.autopilot.commands import FLOWN_TO, LANDINGS, TAKEOFFS, Command
from ipoa_mission.centimeters import ceil_cm, falls_short, floor_cm, goes_beyond
from ipoa_mission.forecast.deviation.law import DeviationLaw
from ipoa_mission.forecast.deviation.proximity import proximity_risks
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.flight_model import Prediction
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE, Pieces, Track, pieces_of, thinned
from ipoa_mission.geometry import Points, as_place
from ipoa_mission.planning.proof import TOUCHING, Check
from ipoa_mission.world.airspace import Airspace, Clearance

TAKEOFF_PART, LANDING_PART = "the take-off", "the ending"


class KeptLimit(NamedTuple):
    """One limit in one part of the flight: predicted (`nominal`) and `guaranteed` distances [m], of a ceiling heights.

    `to` is the nearest thing. `part` is empty on the way, else "the take-off", "the ending", or a tight place, as
    "via[2]"; the guarantee of the flight excludes these.
    """

    limit: str
    required: float
    nominal: float
    guaranteed: float
    to: str
    item: int
    place: tuple[float, float, float]
    part: str = ""

    @property
    def in_cruise(self) -> bool:
        return not self.part

    @property
    def forbids(self) -> bool:
        """Return whether the limit forbids the flight: too little on the way, or at a tight place as predicted."""
        if self.part in (TAKEOFF_PART, LANDING_PART):
            return False
        beyond = self.nominal - self.required if self.limit == "ceiling" else self.required - self.nominal
        return self.falls_short and (self.in_cruise or beyond > TOUCHING)

    @property
    def slack(self) -> float:
        return self.required - self.guaranteed if self.limit == "ceiling" else self.guaranteed - self.required

    @property
    def falls_short(self) -> bool:
        return _breaks(self.guaranteed, self.required, self.limit == "ceiling")

    def words(self, confidence: float | None) -> str:
        is_ceiling = self.limit == "ceiling"
        round_kept = ceil_cm if is_ceiling else floor_cm
        round_required = floor_cm if is_ceiling else ceil_cm
        bound = "at most " if is_ceiling else ""
        nominal = round_kept(self.nominal)
        required = f"{bound}{round_required(self.required):.2f} m required"
        predicted = f"{abs(nominal):.2f} m{' inside' if nominal < 0 else ''}"
        if confidence is None:
            return f"predicted {predicted}; {required}"
        kept = f"{100 * confidence:g} % of flights keep {bound}{round_kept(self.guaranteed):.2f} m"
        if self.guaranteed < 0:
            kept = f"{100 * confidence:g} % of flights cannot be guaranteed any distance"
        return f"{kept} (predicted {predicted}); {required}"


@dataclass(frozen=True)
class ClearanceGuarantee:
    confidence: float | None
    limits: tuple[KeptLimit, ...]
    flight: "PredictedFlight" = field(repr=False, compare=False)

    @property
    def broken(self) -> tuple[KeptLimit, ...]:
        return tuple(limit for limit in self.limits if limit.falls_short)

    @property
    def forbidding(self) -> tuple[KeptLimit, ...]:
        return tuple(limit for limit in self.limits if limit.forbids)

    @property
    def clearance(self) -> KeptLimit | None:
        solid = [limit for limit in self.limits if limit.in_cruise and limit.limit in ("obstacles", "ground")]
        finite = [limit for limit in solid if np.isfinite(limit.guaranteed)]
        return min(finite, key=lambda limit: (not limit.falls_short, limit.guaranteed), default=None)

    @property
    def elsewhere(self) -> tuple[KeptLimit, ...]:
        return tuple(limit for limit in self.broken if not limit.in_cruise)


def deviation_bound_holds(flown: Pieces, task: kept_limits.ClearanceTask) -> bool:
    required = ceil_cm(task.path.limits.obstacle_distance)
    airspace = task.path.airspace
    if airspace.obstacles:
        free = kept_limits.round_places(flown.points, _tight(task)) < 0
        for stretch in kept_limits.runs(flown.points, free):
            nearest = airspace.obstacle_clearance(thinned(stretch), within=required + 2 * THINNING_TOLERANCE)
            if nearest.distance - THINNING_TOLERANCE < required:
                return False
        for stretch in kept_limits.runs(flown.points, ~free):
            if _least_clearance(airspace, [stretch], required).distance < required - TOUCHING:
                return False
        if task.chance is not None:
            pairs = proximity_risks(flown, airspace, task.law, required)
            if pairs.subset(free[pairs.piece]).chance(required) > task.chance:
                return False
    return not limits_broken_by_deviation(flown.points, task)


def limits_broken_by_deviation(path: Points, task: kept_limits.ClearanceTask) -> list[Check]:
    """Return the limits of height and place that flights along the path (n, 3) break, each at its worst place."""
    checks = kept_limits.limits_kept(thinned(path), task.path, _bound(task.law, task.chance))
    return [check for check in checks if _breaks(check.nearest.distance, check.required, check.at_most)]


def _breaks(distance: float, required: float, at_most: bool) -> bool:
    return goes_beyond(distance, required) if at_most else falls_short(distance, required)


def _least_clearance(airspace: Airspace, stretches: list[Points], required: float) -> Clearance:
    """Return a lower bound; exact if that decides whether the required distance is kept."""
    bounds = (airspace.obstacle_clearance(thinned(stretch)).minus(THINNING_TOLERANCE) for stretch in stretches)
    least = min(bounds, key=lambda clearance: clearance.distance)
    if not required - 2 * THINNING_TOLERANCE <= least.distance < required:
        return least
    return min(map(airspace.obstacle_clearance, stretches), key=lambda clearance: clearance.distance)


def _bound(law: DeviationLaw, chance: float | None) -> kept_limits.DeviationBound:
    bound = kept_limits.NO_DEVIATION if chance is None else kept_limits.deviation_bound_of(law, chance)
    return bound.wider(THINNING_TOLERANCE)


def _worst_checks(part: Pieces, task: kept_limits.ClearanceTask, bound: kept_limits.DeviationBound) -> Iterable[Check]:
    """Return each limit's check at its worst stretch, by bounds of all others."""
    stretches = list(_stretches(part, bound))
    known = dict[int, list[Check]]()
    for limit, slacks in kept_limits.least_slacks(stretches, task.path).items():
        least = np.inf
        for n in np.argsort(slacks, kind="stable").tolist():
            if slacks[n] >= least:
                break
            if n not in known:
                path, wider = stretches[n]
                known[n] = list(kept_limits.limits_kept(thinned(path), task.path, wider))
            least = min([least, *(check.slack for check in known[n] if check.limit == limit)])
    worst = dict[str, Check]()
    for n in sorted(known):
        for check in known[n]:
            if check.slack < worst.setdefault(check.limit, check).slack:
                worst[check.limit] = check
    return worst.values()


def _stretches(part: Pieces, bound: kept_limits.DeviationBound) -> Iterator[kept_limits.Stretch]:
    """Yield the lowest and highest path of each 2 s; where they do not differ, one."""
    upwards = np.array([[0.0, 0.0, 1.0]])
    length = 16 if part.excess.any() else len(part.excess)  # pieces
    for first in range(0, len(part.excess), length):
        points = part.points[first : first + length + 1]
        excess = part.excess[first : first + length]
        aside, below, above = np.vstack([excess, excess[-1:]]).T[..., None]  # of each point
        wider = replace(bound, lateral=bound.lateral + float(aside.max()))
        if excess.any():
            yield points - below * upwards, wider
        yield points + above * upwards, wider


def _tight(task: kept_limits.ClearanceTask) -> tuple[kept_limits.TightPlace, ...]:
    lateral = 0.0 if task.chance is None else task.law.lateral_bound(task.chance)
    return kept_limits.tight_places(task.path, 2 * THINNING_TOLERANCE + lateral)


def clearance_guarantee_of(flight: "PredictedFlight") -> ClearanceGuarantee:
    chance = flight.task.chance
    return ClearanceGuarantee(None if chance is None else 1.0 - chance, tuple(flight.limits(chance)), flight)


@dataclass(frozen=True, eq=False)
class PredictedFlight:
    itinerary: Itinerary
    prediction: Prediction
    track: Track
    task: kept_limits.ClearanceTask
    excess: Points | None = None

    @cached_property
    def pieces(self) -> Pieces:
        return pieces_of(self.track, self.excess)

    def drop_pieces(self) -> None:
        self.__dict__.pop("pieces", None)

    @cached_property
    def cruise_span(self) -> tuple[float, float]:
        """Return the end of the take-off and of the last waypoint [s]."""
        commands = [visit.item.command for visit in self.itinerary.visits]
        timed = list(zip(commands, map(float, self.prediction.done), strict=True))
        begin = min((at for command, at in timed if command in TAKEOFFS), default=0.0)
        ends = [at for command, at in timed if command in FLOWN_TO - TAKEOFFS - LANDINGS]
        return begin, max(ends[-1] if ends else begin, begin)

    def limits(self, chance: float | None) -> Iterator[KeptLimit]:
        begin, end = self.cruise_span
        last = float(self.pieces.times[-1])
        law = self.task.law
        if self.task.path.airspace.obstacles:
            parts = (0.0, begin, law, TAKEOFF_PART), (end, last, law.after_cruise(), LANDING_PART)
            for first, then, its_law, name in parts:
                if then > first:
                    part = self.pieces.part(first, then)
                    yield self._obstacle_limit(part, its_law, chance, np.full(len(part.points) - 1, True), name)
            if end > begin:
                part = self.pieces.part(begin, end)
                tight = _tight(self.task)
                at = kept_limits.round_places(part.points, tight)
                for n in np.unique(at).tolist():
                    yield self._obstacle_limit(part, law, chance, at == n, "" if n < 0 else tight[n].name)
        for first, then in self._airborne_spans(begin, end):
            yield from self._other_limits(self.pieces.part(first, then), _bound(law, chance))

    def _airborne_spans(self, begin: float, end: float) -> list[tuple[float, float]]:
        track = self.prediction.track
        parts = list[tuple[float, float]]()
        for done, visit in zip(self.prediction.done, self.itinerary.visits, strict=True):
            if visit.item.command == Command.NAV_PAYLOAD_PLACE and begin < done <= end:
                over = track.at(np.array([done]))[0, :2]
                is_away = np.hypot(*(track.points[:, :2] - over).T) > 0.5  # [m]
                sinks = max(track.times[is_away & (track.times < done)].max(initial=begin), begin)
                parts += [(begin, float(sinks))] if sinks > begin else []
                begin = float(done)
        return [*parts, (begin, end)] if end > begin or not parts else parts

    def _obstacle_limit(
        self, part: Pieces, law: DeviationLaw, chance: float | None, chosen: NDArray[np.bool_], name: str
    ) -> KeptLimit:
        """`chosen`: pieces (n-1,) of the part. `name`: empty on the way."""
        airspace = self.task.path.airspace
        required = self.task.path.limits.obstacle_distance
        decisive = required if name else -np.inf  # on the way a lower bound is enough
        predicted = _least_clearance(airspace, [*kept_limits.runs(part.points, chosen)], decisive)
        kept = predicted
        if chance is not None:
            pairs = proximity_risks(part, airspace, law, predicted.distance)
            pairs = pairs.subset(chosen[pairs.piece])
            kept = replace(predicted, distance=min(pairs.clearance_at(chance), predicted.distance))
            if len(pairs.piece):
                piece, body = pairs.likeliest(kept.distance)
                place = as_place(part.points[piece])
                kept = replace(kept, place=place, what=airspace.obstacles[body].name)
        item = self._item_at(part, kept.place)
        return KeptLimit("obstacles", required, predicted.distance, kept.distance, kept.what, item, kept.place, name)

    def _other_limits(self, part: Pieces, bound: kept_limits.DeviationBound) -> Iterator[KeptLimit]:
        path = thinned(part.points)
        checks = kept_limits.limits_kept(path, self.task.path, kept_limits.NO_DEVIATION.wider(THINNING_TOLERANCE))
        nominal = {(check.limit, check.required): check.nearest.distance for check in checks}
        for check in _worst_checks(part, self.task, bound):
            near = check.nearest
            expected = nominal.get((check.limit, check.required), near.distance)
            item = self._item_at(part, near.place)
            yield KeptLimit(check.limit, check.required, expected, near.distance, near.what, item, near.place)

    def _item_at(self, part: Pieces, place: tuple[float, float, float]) -> int:
        at = part.times[np.argmin(np.linalg.norm(part.points - np.array(place), axis=1))]
        seqs = [visit.seq for visit in self.itinerary.visits] or [0]
        return seqs[min(int(np.searchsorted(self.prediction.done, at - 1e-6)), len(seqs) - 1)]
