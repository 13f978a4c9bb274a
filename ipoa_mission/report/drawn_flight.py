"""Sample a flight for maps and charts: track, deviation bound, dangers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.centimeters import ceil_cm, falls_short, floor_cm
from ipoa_mission.forecast.deviation.kept_limits import NO_DEVIATION, DeviationBound, deviation_bound_of
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import item_places, join
from ipoa_mission.forecast.timing.estimate import ItemTime
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Matrix, Plane, Points, Vector, arc_lengths
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import as_flown
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.report.table import Row, rows_of
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle

LANDING_RADIUS = 1.0  # [m]


@dataclass(frozen=True, eq=False)
class SampledTrack(Track):
    """Samples (n,): distance over ground `along`, height of the `ground`, `apart` from obstacles, or infinite [m]."""

    along: Vector
    ground: Vector
    apart: Vector


@dataclass(frozen=True)
class ItemLeg:
    """One item as flown, and its leg; `proof`: between two waypoints."""

    item: Item
    time: ItemTime
    row: Row
    name: str
    place: Vector | None
    path: Points
    proof: Proof | None


@dataclass(frozen=True)
class DrawnFlight:
    scenario: Scenario
    predicted: SampledTrack
    legs: tuple[ItemLeg, ...]
    flown: SampledTrack | None
    deviation_bound: DeviationBound


@dataclass(frozen=True)
class Danger:
    """`touching`: the hull would collide."""

    words: str
    touching: bool


def sample_track(track: Track, airspace: Airspace, samples: int = 800) -> SampledTrack:
    """Sample densely where a path is slow or fast; a landing ends on the ground."""
    gone = arc_lengths(track.points[:, :2])
    share = track.times / max(float(track.times[-1]), 1e-9) + gone / max(float(gone[-1]), 1e-9)
    times = np.interp(np.linspace(share[0], share[-1], samples), share, track.times)
    points = track.at(times)
    ground = airspace.ground(points)
    landing = np.hypot(*(points[:, :2] - points[-1, :2]).T) < LANDING_RADIUS
    points[landing, 2] = np.maximum(points[landing, 2], ground[landing])
    return SampledTrack(
        times=times,
        along=arc_lengths(points[:, :2]),
        points=points,
        speeds=np.interp(times, track.times, track.speeds),
        ground=ground,
        apart=airspace.obstacle_distance(points),
    )


def shown_deviation_bound(forecast: Forecast) -> DeviationBound:
    scenario = forecast.world
    if scenario.safety.chance is None:
        return NO_DEVIATION
    return deviation_bound_of(law_of(forecast.mission.autopilot, scenario.wind.strongest), scenario.safety.chance)


def outline_around(points: Points, distance: float) -> list[Plane]:
    """Return closed rings, the outer one first, (n, 2) [m]."""
    if distance <= 0.0:
        return []
    outline = shapely.LineString(points[:, :2]).simplify(distance / 10).buffer(distance, quad_segs=4)
    return [shapely.get_coordinates(ring) for ring in (outline.exterior, *outline.interiors)]


def find_dangers(predicted: SampledTrack, scenario: Scenario) -> list[Danger]:
    """Return where the path, a cut corner or the return comes too close to obstacles or meets the ground."""
    dangers = []
    required = scenario.limits.obstacle_distance
    nearest = scenario.airspace.obstacle_clearance(predicted.points)
    if falls_short(nearest.distance, required):
        verb = "runs into" if nearest.distance < 0 else f"comes within {floor_cm(nearest.distance):.2f} m of"
        where = _where(predicted.times[nearest.leg], nearest.place)
        words = f"the path as predicted {verb} {nearest.what} {where}; {ceil_cm(required):.2f} m are required"
        dangers.append(Danger(words, nearest.distance < scenario.vehicle.radius))

    height = predicted.points[:, 2] - predicted.ground
    en_route = np.hypot(*(predicted.points[:, :2] - predicted.points[0, :2]).T) > LANDING_RADIUS
    lowest = int(np.argmin(np.where(en_route, height, np.inf)))
    if en_route[lowest] and height[lowest] < 0:
        where = _where(predicted.times[lowest], predicted.points[lowest])
        dangers.append(Danger(f"the path as predicted runs into the ground {where}", True))
    return dangers


def _where(time: float, place: Sequence[float] | Vector) -> str:
    east, north, up = place
    return f"after {time:.0f} s, at east {east:z.0f}, north {north:z.0f}, up {up:z.0f} m"


def placed_items(forecast: Forecast) -> list[tuple[Item, Vector | None]]:
    """Return each item as flown, and its place, east, north, up [m]; a landing is on the ground."""
    flown = as_flown(forecast.mission)
    scenario = forecast.scenario
    ground = forecast.ground if scenario is None else scenario.airspace.ground
    places = item_places(flown, forecast.frame, ground)
    for item, place in zip(flown.items, places, strict=True):
        if place is not None and item.command == Command.NAV_LAND:
            place[2] = ground(place[None, :])[0]
    return list(zip(flown.items, places, strict=True))


def item_legs(forecast: Forecast) -> tuple[ItemLeg, ...]:
    legs = []
    items = placed_items(forecast)
    rows = rows_of(forecast)
    bent = {leg.seq for leg in forecast.cruise if leg.chord_error > 0}
    curves = {seq: join([leg for leg in forecast.cruise if leg.seq == seq]) for seq in bent}
    before = forecast.home
    is_flying = False
    for time in forecast.estimate.items:
        item, place = items[time.seq - 1]
        leg = (place if place is not None else before) - before
        path, chord_error = curves.get(time.seq, (before + np.array([[0.0], [1.0]]) * leg, 0.0))
        moves = item.command in {*WAYPOINTS, Command.NAV_TAKEOFF} and np.linalg.norm(leg) > 0
        is_proved = place is not None and is_flying and moves and not forecast.unknown
        proof = prove(path, forecast.world, chord_error) if is_proved else None
        legs.append(ItemLeg(item, time, rows[time.seq], item_words(item), place, path, proof))
        if place is not None:
            before = place
            is_flying = True
    return tuple(legs)


@dataclass(frozen=True)
class Extent:
    """Corners (east, north) [m]."""

    lower: tuple[float, float]
    upper: tuple[float, float]

    def obstacles(self, airspace: Airspace) -> tuple[Obstacle, ...]:
        return tuple(
            body
            for body in airspace.obstacles
            if (body.bounds[1, :2] > self.lower).all() and (body.bounds[0, :2] < self.upper).all()
        )

    def buildings(self, airspace: Airspace) -> tuple[Obstacle, ...]:
        """Leave zones out."""
        return tuple(body for body in self.obstacles(airspace) if body.solid)


def extent_of(*paths: Plane) -> Extent:
    """Add 18 % of the longer side, at least 15 m; widen the shorter side to 0.62 of the longer."""
    points = np.vstack(paths)
    sides = np.ptp(points, axis=0)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = sides / 2 + max(15.0, 0.18 * float(sides.max()))
    half = np.maximum(half, 0.62 * half.max())
    west, south = (middle - half).tolist()
    east, north = (middle + half).tolist()
    return Extent((west, south), (east, north))


def ground_mesh(airspace: Airspace, across: int, extent: Extent | None = None) -> tuple[Matrix, Matrix, Matrix]:
    """Return east, north, height of square cells, `across` on the longer side, over an extent or the bounds [m]."""
    box = Extent(airspace.bounds.lower[:2], airspace.bounds.upper[:2]) if extent is None else extent
    sides = np.subtract(box.upper, box.lower)
    counts = np.maximum(np.rint(sides / sides.max() * across), 1).astype(int) + 1
    east, north = np.meshgrid(*(np.linspace(a, b, n) for a, b, n in zip(box.lower, box.upper, counts, strict=True)))
    up = airspace.ground(np.column_stack([east.ravel(), north.ravel()]))
    return east, north, up.reshape(east.shape)
