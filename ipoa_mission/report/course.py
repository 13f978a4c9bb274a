"""The flight as the report tells it: the predicted path with all that is asked of each of its points, and its stops."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Command, Item, Mission, command_name
from ipoa_mission.planning.limits import limits_of
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.estimate import Estimate, ItemTime
from ipoa_mission.timing.prediction import Track
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.frame import Geodetic, LocalFrame

SAMPLES = 800
HERE = 0.5  # a leg shorter than this over ground has no heading [m]
STILL = 1.0  # nearer than this to where the flight ends it is coming down [m]
MOVING = frozenset({Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_TAKEOFF})


@dataclass(frozen=True)
class Course:
    """Samples of a path, each (n,) but `points` (n, 3): time [s], ground distance so far [m], speed [m/s], and so on.

    `ground` is the height of the ground below [m], `apart` the distance to the nearest obstacle [m] (infinite: none).
    """

    times: Vector
    along: Vector
    points: Points
    speeds: Vector
    ground: Vector
    apart: Vector

    def at(self, time: float) -> int:
        """The sample nearest to a time."""
        return int(np.argmin(np.abs(self.times - time)))


def follow(track: Track, airspace: Airspace, samples: int = SAMPLES) -> Course:
    """Look at a path, predicted or flown, at `samples` places: close together where it is slow and where it is fast.

    A landing ends on the ground, of which the time models know nothing.
    """
    gone = _ground_distance(track.points)
    share = track.times / max(float(track.times[-1]), 1e-9) + gone / max(float(gone[-1]), 1e-9)
    wanted = np.linspace(share[0], share[-1], samples)
    times = np.interp(wanted, share, track.times)
    points = np.column_stack([np.interp(times, track.times, axis) for axis in track.points.T])
    ground = airspace.ground(points)
    landing = np.hypot(*(points[:, :2] - points[-1, :2]).T) < STILL
    points[landing, 2] = np.maximum(points[landing, 2], ground[landing])
    return Course(
        times=times,
        along=_ground_distance(points),
        points=points,
        speeds=np.interp(times, track.times, track.speeds),
        ground=ground,
        apart=airspace.obstacle_distance(points),
    )


@dataclass(frozen=True)
class Stop:
    """One item as it is flown, for the table and the map: `place` is where it lies (None: nowhere), and the leg to it.

    `heading` is in radians clockwise from north (NaN: straight up); `proof` tells what the leg keeps of the limits
    (None: it is not flown straight between two waypoints).
    """

    item: Item
    time: ItemTime
    name: str
    place: Vector | None
    above_ground: float
    length: float
    heading: float
    climb: float
    proof: Proof | None


def stops(mission: Mission, estimate: Estimate, scenario: Scenario) -> tuple[Stop, ...]:
    """Every item in the order flown, with the leg that leads to it."""
    found, airspace = [], scenario.airspace
    before, flying = np.zeros(3), False
    for time in estimate.items:
        item = mission.items[time.seq - 1]
        place = item_place(item, mission, scenario)
        leg = (place if place is not None else before) - before
        run = float(np.hypot(*leg[:2]))
        straight = place is not None and flying and item.command in MOVING
        found.append(
            Stop(
                item=item,
                time=time,
                name=_words(item),
                place=place,
                above_ground=math.nan if place is None else float(place[2] - airspace.ground(place[None, :])[0]),
                length=float(np.linalg.norm(leg)),
                heading=math.atan2(leg[0], leg[1]) % (2 * math.pi) if run > HERE else math.nan,
                climb=float(leg[2]),
                proof=prove(np.array([before, place]), scenario) if straight and np.linalg.norm(leg) > 0 else None,
            )
        )
        if place is not None:
            before, flying = place, True
    return tuple(found)


def route(found: tuple[Stop, ...]) -> Points:
    """The waypoints, take-off included, between which the mission flies straight, (n, 3)."""
    places = [stop.place for stop in found if stop.place is not None and stop.item.command in MOVING]
    return np.array(places).reshape(-1, 3)


def item_place(item: Item, mission: Mission, scenario: Scenario) -> Vector | None:
    """Where an item lies in the local frame, (3,) [m]; None where it names no place. A landing is on the ground."""
    if not item.has_position:
        return None
    height = mission.altitude_above_home(item)
    amsl = mission.home.altitude + (0.0 if math.isnan(height) else height)
    place = LocalFrame(mission.home).local(Geodetic(item.latitude_deg, item.longitude_deg, amsl))
    if item.command == Command.NAV_LAND or math.isnan(height):
        ground = float(scenario.airspace.ground(place[None, :])[0])
        place[2] = ground if item.command == Command.NAV_LAND else ground + item.altitude
    return place


@dataclass(frozen=True)
class Danger:
    """What the path as predicted comes too close to, in words; `touching`: the hull itself would meet it."""

    words: str
    touching: bool


def dangers(course: Course, scenario: Scenario) -> list[Danger]:
    """What the path as predicted comes too close to: corners that are cut, and the way home, are in it.

    The ground counts only where the path goes into it, since every flight begins and ends there.
    """
    found, required = [], limits_of(scenario).obstacle_distance
    nearest = scenario.airspace.obstacle_clearance(course.points)
    if nearest.distance < required:
        how = "runs into" if nearest.distance < 0 else f"comes within {nearest.distance:.2f} m of"
        where = _where(course.times[nearest.leg], nearest.place)
        words = f"the path as predicted {how} {nearest.what} {where}; {required:.2f} m are required"
        found.append(Danger(words, nearest.distance < scenario.vehicle.radius))
    height = course.points[:, 2] - course.ground
    away = np.hypot(*(course.points[:, :2] - course.points[0, :2]).T) > STILL
    lowest = int(np.argmin(np.where(away, height, np.inf)))
    if away[lowest] and height[lowest] < 0:
        where = _where(course.times[lowest], course.points[lowest])
        found.append(Danger(f"the path as predicted runs into the ground {where}", True))
    return found


def _where(time: float, place: Sequence[float] | Vector) -> str:
    east, north, up = place
    return f"after {time:.0f} s, at east {east:.0f}, north {north:.0f}, up {up:.0f} m"


def _ground_distance(points: Points) -> Vector:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))])


def _words(item: Item) -> str:
    hold = f", hold {item.params[0]:g} s" if item.params[0] > 0 else ""
    match item.command:
        case Command.NAV_TAKEOFF:
            return "take off"
        case Command.NAV_WAYPOINT:
            return f"waypoint{hold}"
        case Command.NAV_SPLINE_WAYPOINT:
            return f"spline waypoint{hold}"
        case Command.NAV_RETURN_TO_LAUNCH:
            return "return to launch"
        case Command.NAV_LAND:
            return "land"
        case Command.DO_CHANGE_SPEED:
            return f"speed {item.params[1]:g} m/s"
    return command_name(item.command).removeprefix("NAV_").removeprefix("DO_").replace("_", " ").lower()
