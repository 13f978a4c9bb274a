"""Turn mission items, RTL and LAND into motions, as PX4's navigator."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ipoa_mission.autopilot.commands import HOLDING, LAST_NAV, Command, Frame, plain_frame
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.errors import EndlessFlight
from ipoa_mission.forecast.itinerary.itinerary import UNTIMED, Itinerary
from ipoa_mission.geometry import GRAVITY, Enu, Place, Vector
from ipoa_mission.ground import Ground
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import Program
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    GO,
    LAND,
    SIH,
    TAKE_OFF,
    Airframe,
    EastNorth,
    Motion,
    SensorModel,
    SimulationConstants,
)
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import Wind

HELD_OR_REACHED = HOLDING | {Command.NAV_LOITER_TO_ALT}
ANY_RADIUS = 1e9  # without effect [m]


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return SIH's airframe with the learned values."""
    if vehicle is None:
        return SIH
    drag = SIH.drag * vehicle.value("drag", 1.0)
    return SIH._replace(drag=drag, **vehicle.values("lag", "lift_delay", "landing_delay"))


def simulation_constants(
    limits: Px4Limits, airframe: Airframe, sensors: SensorModel, wind: Wind, dt: float
) -> SimulationConstants:
    tilt_gain = -math.expm1(-dt / limits.tilt_lag)
    rotor_gain = -math.expm1(-dt / airframe.lag)
    sensors = sensors._replace(sees_ground=sensors.sees_ground and limits.has_range_finder)
    steps = (dt, GRAVITY * math.tan(limits.max_tilt), tilt_gain, rotor_gain)
    return SimulationConstants(limits, airframe, sensors, wind.table, *steps, turns=True, noisy=True)


def leg(limits: Px4Limits, start: Enu, goal: Enu, *, beyond: Enu | None = None, cruise: float | None = None) -> Motion:
    """Return a leg on to `beyond`, or with a stop; `cruise` [m/s] is by default MPC_XY_CRUISE."""
    fastest = min(limits.cruise if cruise is None else cruise, limits.max_speed)
    return Motion(
        GO, start, goal, beyond or goal, radius=limits.radius, height_radius=limits.height_radius, cruise=fastest
    )


def take_off(top: Enu, limits: Px4Limits) -> Motion:
    """Return a climb above home at that time."""
    return leg(limits, top, top)._replace(kind=TAKE_OFF, follows_home=False)


def waypoint(item: Item, motion: Motion, limits: Px4Limits) -> Motion:
    """Return the motion of a leg with the item's hold, radius and heading."""
    hold_s = max(0.0, item.params[0]) if item.command in HOLDING else 0.0  # NaN: no hold
    has_radius = item.command == Command.NAV_WAYPOINT and item.params[1] > 0.001
    return motion._replace(
        beyond=motion.goal if hold_s > 0 else motion.beyond,
        radius=item.params[1] if has_radius else limits.radius,
        hold_s=hold_s,
        heading=math.radians(item.params[3]),
        may_turn_first=True,
        follows_home=plain_frame(item.frame) != Frame.GLOBAL,
    )


def stay(place: Enu, limits: Px4Limits, seconds: float) -> list[Motion]:
    motion = leg(limits, place, place)
    return [motion._replace(radius=ANY_RADIUS, height_radius=ANY_RADIUS, hold_s=seconds)] if seconds > 0 else []


def landing_motions(start: Enu, ground: Enu, limits: Px4Limits, cruise: float, hold_s: float) -> list[Motion]:
    """Return a landing's motions, first to over the place if beyond the acceptance radius; `hold_s`: on the ground."""
    over = ground._replace(up=start.up)
    legs = [leg(limits, start, over, cruise=cruise)] if math.dist(start, over) > limits.radius else []
    ground = ground if legs else start._replace(up=ground.up)
    return [*legs, leg(limits, ground, ground, cruise=cruise)._replace(kind=LAND, hold_s=hold_s)]


def stopping_place(place: Enu, speed: EastNorth, limits: Px4Limits) -> Enu:
    """Return the stopping place of LAND and hold."""
    time = limits.stopping_time(math.hypot(speed.east, speed.north))
    return place._replace(east=place.east + speed.east * time, north=place.north + speed.north * time)


def return_motions(here: Enu, goal: Place, ground: Ground, limits: Px4Limits) -> list[Motion]:
    """Return the motions of RTL to home or a rally point: climb by `Px4Return`, fly at MPC_XY_CRUISE, wait, land.

    Heights count from the goal's. While it climbs it flies back to `here`, until within NAV_LOITER_RAD.
    """
    east, north, goal_height = goal
    on_ground = Enu(east, north, ground.at(east, north))
    far = math.hypot(here.east - east, here.north - north)
    height = goal_height + limits.returning.height(here.up - goal_height, far)
    top = here._replace(up=height) if height > here.up + limits.height_radius else here
    climb = [leg(limits, top, top)._replace(radius=ANY_RADIUS)] if top != here else []
    *legs, down = landing_motions(top, on_ground, limits, limits.cruise, limits.disarm_delay)
    # PX4's return has no previous waypoint: from wherever it turns home it flies straight, and keeps to no line.
    legs = [motion._replace(start=motion.goal) for motion in legs]
    over = down.goal._replace(up=top.up)
    low = over._replace(up=max(min(top.up, goal_height + limits.land_delay_height), on_ground.up))
    waits = [leg(limits, over, low), *stay(low, limits, limits.land_delay)] if limits.land_delay else []
    return [*climb, *legs, *waits, down]


def land_mode_motions(here: Enu, speed: EastNorth, ground: Ground, limits: Px4Limits) -> list[Motion]:
    stop = stopping_place(here, speed, limits)
    on_ground = stop._replace(up=ground.at(stop.east, stop.north))
    return landing_motions(stop, on_ground, limits, limits.cruise, limits.disarm_delay)


def contingency_motions(contingency: Contingency, row: Vector, itinerary: Itinerary, limits: Px4Limits) -> list[Motion]:
    here = Enu(*map(float, row[1:4]))
    if contingency is Contingency.RTL:
        return return_motions(here, itinerary.goal_of_return(here), itinerary.ground, limits)
    return land_mode_motions(here, EastNorth(float(row[4]), float(row[5])), itinerary.ground, limits)


class Navigator:
    """Turn items of a program into motions; `here` is the place commanded last."""

    def __init__(self, program: Program, ground: Ground, limits: Px4Limits, here: Enu) -> None:
        self.program = program
        self.ground = ground
        self.limits = limits
        self.here = here
        self.cruise = limits.cruise

    def change_speed(self, item: Item) -> None:
        """A speed that is not above 0 restores MPC_XY_CRUISE."""
        kind, speed = item.params[:2]
        if kind < 2:
            self.cruise = speed if speed > 0 else self.limits.cruise

    def fly_to(self, n: int, takes_off: bool) -> list[Motion]:
        item = self.program.items[n]
        is_takeoff = item.command == Command.NAV_TAKEOFF
        start = self.here
        self.here = self._target(n)
        if takes_off or is_takeoff:
            start = start._replace(up=self.here.up)
        climb = [take_off(start, self.limits)] if takes_off else []
        onward = self.program.onward(n)
        beyond = None if onward is None else self._target(onward)
        motion = leg(self.limits, start, self.here, beyond=beyond, cruise=self.cruise)
        return [*climb, motion if is_takeoff else waypoint(item, motion, self.limits)]

    def land_at(self, n: int) -> list[Motion]:
        ground = self.ground_under(self._target(n))
        return self._landing(landing_motions(self.here, ground, self.limits, self.cruise, 0.0))

    def return_to(self, goal: Place) -> list[Motion]:
        self.cruise = self.limits.cruise
        return self._landing(return_motions(self.here, goal, self.ground, self.limits))

    def return_along(self, places: Sequence[Place]) -> list[Motion]:
        """`places`: back along the mission, the last over home."""
        self.cruise = self.limits.cruise
        back = [Enu(*place) for place in places]
        legs = list[Motion]()
        start = self.here
        for place, beyond in zip(back, [*back[1:], None], strict=True):
            if math.dist(start, place) > self.limits.radius:
                legs.append(leg(self.limits, start, place, beyond=beyond))
                start = place
        ground = self.ground_under(back[-1])
        down = leg(self.limits, ground, ground)._replace(kind=LAND, hold_s=self.limits.disarm_delay)
        return self._landing([*legs, down])

    def ground_under(self, place: Enu) -> Enu:
        return place._replace(up=self.ground.at(place.east, place.north))

    def _landing(self, motions: list[Motion]) -> list[Motion]:
        self.here = motions[-1].goal
        return motions

    def _target(self, n: int) -> Enu:
        """Open coordinates are those last commanded."""
        return Enu(*self.program.place(n, self.here))


class ItineraryMotions(NamedTuple):
    motions: tuple[Motion, ...]
    done: tuple[int, ...]  # number of motions done after each visit
    remarks: tuple[str, ...]


def motions_of_itinerary(itinerary: Itinerary, limits: Px4Limits, landing_delay: float = 0.0) -> ItineraryMotions:
    """Return the motions of an itinerary, from the ground, or from over home.

    It disarms `landing_delay` s later.

    Raises:
        BadInput: an item never ends.
    """
    height = itinerary.start_height
    navigator = Navigator(itinerary.program, itinerary.ground, limits, Enu(0.0, 0.0, height or 0.0))
    airborne = height is not None
    motions = list[Motion]()
    done = list[int]()
    remarks = list[str]()
    for n, visit in enumerate(itinerary.visits):
        begins = motions[-1].goal if motions else navigator.here
        visited = _visit(itinerary, n, navigator, airborne, remarks)
        motions += with_timeouts(visited, begins, limits, landing_delay)
        done.append(len(motions))
        if visit.item.command == Command.NAV_TAKEOFF:
            airborne = True
        elif visited and visited[-1].kind == LAND:
            airborne = False
    return ItineraryMotions(tuple(motions), tuple(done), tuple(remarks))


def with_timeouts(motions: Sequence[Motion], start: Enu, limits: Px4Limits, landing_delay: float) -> Iterator[Motion]:
    """Yield motions flown from `start`, each with its timeout."""
    # A guard against circling forever, not PX4's: several times the duration of any motion that ends.
    slowest = min(limits.climb, limits.descent, limits.takeoff_speed, limits.land_speed, limits.crawl_speed)
    for motion in motions:
        distance = math.dist(start[:2], motion.goal[:2])
        rise = abs(motion.goal.up - start.up)
        lasts = (300 if motion.kind == LAND else 120) + 6 * distance * max(1.0, 1 / motion.cruise) + 4 * rise / slowest
        late = landing_delay if motion.kind == LAND else 0.0
        yield motion._replace(hold_s=motion.hold_s + late, timeout=lasts * max(1.0, 1 / motion.radius))
        start = motion.goal


def _visit(itinerary: Itinerary, n: int, navigator: Navigator, airborne: bool, remarks: list[str]) -> list[Motion]:
    item = itinerary.visits[n].item
    place = f"item {itinerary.visits[n].seq}"
    match item.command:
        case Command.NAV_TAKEOFF:
            return navigator.fly_to(n, takes_off=not airborne)
        case command if command in HELD_OR_REACHED:
            if command == Command.NAV_SPLINE_WAYPOINT:
                remarks.append(f"{place}: PX4 knows no splines, flown straight")
            return navigator.fly_to(n, takes_off=False)
        case Command.NAV_LOITER_UNLIM:
            raise EndlessFlight("loiters without end, so the flight has no time", place=place)
        case Command.NAV_DELAY:
            return stay(navigator.here, navigator.limits, item.params[0])
        case Command.NAV_LAND:
            return navigator.land_at(n)
        case Command.DO_CHANGE_SPEED:
            navigator.change_speed(item)
        case Command.NAV_RETURN_TO_LAUNCH:
            if navigator.limits.land_delay < 0.0:
                raise EndlessFlight("with an RTL_LAND_DELAY below 0 RTL never lands", place=place)
            back = itinerary.places_of_return(n, navigator.here)
            if back is None:
                return navigator.return_to(itinerary.goal_of_return(navigator.here))
            remarks.append(f"{place}: it returns back along the mission, timed to a sixth only")
            return navigator.return_along(back)
        case command if command <= LAST_NAV or command in UNTIMED:
            remarks.append(f"{place}: command {command} is not modeled and counts as no time")
    return []
