"""ArduCopter's procedures of several legs; each yields when a leg is ready."""

import math
from collections.abc import Iterator

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.autopilot.returning import HOME
from ipoa_mission.forecast.itinerary.copter_curves import NEAR_CIRCLE, circle_entry, circle_radius, circle_turn
from ipoa_mission.forecast.itinerary.itinerary import NO_PLACE
from ipoa_mission.geometry import Place
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import Program
from ipoa_mission.vehicles.arducopter.dynamics.copter import SAME_PLACE, Copter, stop_at
from ipoa_mission.vehicles.arducopter.dynamics.legs import Stop, straight_leg
from ipoa_mission.vehicles.arducopter.dynamics.motion import MotionLimits
from ipoa_mission.vehicles.arducopter.limits import CENTIMETER

#: LAND flies to its place at the present height truncated to centimeters, for 0 s or 1 to 1.8 s. 0.8 s are assumed:
#: this share of a 1 cm leg.
LAND_BELOW = 0.75
#: RTL's leg to the stopping point is truncated likewise: its mean length [m].
RETURN_ROUNDING = 0.7 * CENTIMETER
PLACED = 0.65  # PAYLOAD_PLACE on the ground [s]
FLOWN_AS_WAYPOINTS = WAYPOINTS | {Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TIME}


def legs_of(copter: Copter, program: Program, n: int) -> Iterator[None] | None:
    """Return the legs of item n, except RTL; None if it is not flown."""
    item = program.items[n]
    here = copter.here if program.leaves_open(n) else NO_PLACE
    match item.command:
        case Command.NAV_TAKEOFF | Command.NAV_VTOL_TAKEOFF:
            return take_off(copter, program.place(n, here)[2])
        case Command.NAV_DELAY:
            return delay(copter, item)
        case Command.NAV_LOITER_TURNS:
            return circle(copter, program.place(n, here), item)
        case Command.NAV_LOITER_TO_ALT:
            return loiter_to_alt(copter, program.place(n, here))
        case Command.NAV_PAYLOAD_PLACE:
            return payload_place(copter, program.place(n, here) if item.has_position else None, item)
        case Command.NAV_LAND | Command.NAV_VTOL_LAND:
            is_in_place = (item.latitude_deg, item.longitude_deg) == (0.0, 0.0)
            return land(copter, None if is_in_place else program.place_of(item))
        case command if command in FLOWN_AS_WAYPOINTS:
            return waypoint(copter, program, n, here)
    return None


def waypoint(copter: Copter, program: Program, n: int, here: Place) -> Iterator[None]:
    """Fly to item n and hold, or pass it if the program does; `here` replaces open coordinates."""
    stop = stop_at(program, n, here)
    onward = program.onward(n)
    copter.fly_to(stop, None if onward is None else stop_at(program, onward, stop.place))
    yield
    seconds = copter.wait_at(program.items[n])
    if seconds > 0.0:
        copter.hold(seconds)
        yield


def delay(copter: Copter, item: Item) -> Iterator[None]:
    copter.hold(copter.wait_at(item))
    yield


def take_off(copter: Copter, height: float) -> Iterator[None]:
    if height > copter.here[2]:
        copter.take_off(height)
        yield


def land(copter: Copter, place: Place | None) -> Iterator[None]:
    """Since 4.7 LAND_ALT_LOW counts from the altitude of the place."""
    x, y, z = here = copter.here
    if place is not None and math.hypot(place[0] - x, place[1] - y) > SAME_PLACE:
        copter.fly_to(Stop((*place[:2], z)))
        yield
    elif place is not None:
        leg = straight_leg(here, (x, y, z - CENTIMETER), copter.speeds, copter.limits)
        copter.hold(LAND_BELOW * leg.profile.lasts)
        yield
    copter.descend(0.0 if place is None else place[2])
    yield


def return_home(copter: Copter, goal: Place = HOME) -> Iterator[None]:
    limits = copter.limits
    z = copter.place[2]
    (x, y, _) = copter.brake()
    (east, north, _) = goal
    far = math.hypot(x - east, y - north)
    height = limits.returning.height(z, far, goal[2])
    copter.speeds = MotionLimits(limits.rtl_speed, limits.climb, limits.descent)
    height = max(z + RETURN_ROUNDING, height)
    top = Stop((x, y, height))
    home = Stop((east, north, height) if far > SAME_PLACE else (x, y, height - RETURN_ROUNDING))
    copter.fly_to(top, home, limits.rtl_turns)
    yield
    copter.fly_to(home, None, limits.rtl_turns)
    yield
    copter.hold(limits.rtl_loiter)
    yield
    if limits.rtl_final > 0:
        copter.fly_to(Stop((east, north, limits.rtl_final)), None, limits.rtl_turns)
    else:
        copter.descend()
    yield


def circle(copter: Copter, center: Place, item: Item) -> Iterator[None]:
    """LOITER_TURNS: at the height of the circle's nearest point."""
    radius = circle_radius(item)
    edge, apart = circle_entry(copter.stopping_place(), center, radius, copter.state.yaw)
    if apart > NEAR_CIRCLE:
        copter.fly_to(Stop(edge))
        yield
    copter.orbit(center, radius, circle_turn(item, copter.limits.circle_sense))
    yield


def loiter_to_alt(copter: Copter, place: Place) -> Iterator[None]:
    copter.fly_to(Stop(place), ends_near=True)
    yield
    copter.level_off(place[2])
    yield


def payload_place(copter: Copter, place: Place | None, item: Item) -> Iterator[None]:
    """PAYLOAD_PLACE: fly there, at the item's height if planned, descend to ground or by param1, climb back."""
    if place is not None:
        is_planned = copter.following.target == place
        copter.fly_to(Stop(place if is_planned else (*place[:2], copter.here[2])))
        yield
    top = copter.here[2]
    if copter.sink(max(math.trunc(100.0 * item.params[0]), 0) * CENTIMETER):
        yield
        copter.hold(PLACED)
    yield
    copter.rise(top)
    yield
