"""What ArduCopter flies in several legs: LAND, RTL, circles, LOITER_TO_ALT, PAYLOAD_PLACE.

Each yields whenever one more leg is to be flown.
"""

import math
from collections.abc import Iterator

from ipoa_mission.forecast.itinerary.copter_circle import NEAR_CIRCLE, circle_entry, circle_turn, radius_of
from ipoa_mission.forecast.itinerary.program import Place, Program
from ipoa_mission.mission.commands import Command
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.arducopter.dynamics.copter import SAME_PLACE, Copter, Stop
from ipoa_mission.vehicles.arducopter.dynamics.legs import straight_leg
from ipoa_mission.vehicles.arducopter.dynamics.motion import MotionLimits
from ipoa_mission.vehicles.arducopter.limits import CENTIMETRE
from ipoa_mission.vehicles.returning import HOME

#: LAND flies to its place at the height where the vehicle is, cut to whole centimetres: that is the waypoint's, or some
#: centimetres off. The leg takes no time, or 1 to 1.8 s. Before a flight nothing tells which: 0.8 s are counted, this
#: share of a leg of one centimetre.
LAND_BELOW = 0.75
#: RTL begins with a leg to where the vehicle would stop, its height and place cut likewise: by so much on average [m].
RETURN_ROUNDING = 0.7 * CENTIMETRE
PLACED = 0.65  # for so long PAYLOAD_PLACE stands on the ground [s]
LANDINGS = frozenset({Command.NAV_LAND, Command.NAV_VTOL_LAND})


def landing_place(program: Program, item: Item) -> Place | None:
    """Where it lands, and the height that its item names; None: where it is."""
    return None if (item.latitude_deg, item.longitude_deg) == (0.0, 0.0) else program.place_of(item)


def land(copter: Copter, place: Place | None) -> Iterator[None]:
    """LAND: fly over its place, or the centimetre that rounding leaves to it, and come down; None: come down.

    Since 4.7 the altitude of the place is where LAND_ALT_LOW counts from.
    """
    x, y, z = here = copter.here
    if place is not None and math.hypot(place[0] - x, place[1] - y) > SAME_PLACE:
        copter.fly_to(Stop((*place[:2], z)))
        yield
    elif place is not None:
        leg = straight_leg(here, (x, y, z - CENTIMETRE), copter.speeds, copter.limits)
        copter.hold(LAND_BELOW * leg.profile.lasts)
        yield
    copter.descend(0.0 if place is None else place[2])
    yield


def return_home(copter: Copter, goal: Place = HOME) -> Iterator[None]:
    """RTL: climb if below its height (no higher than a cone over home asks for), fly home, loiter, come down.

    `goal`: home, or the rally point that it returns to instead, with that one's height.
    """
    limits, (x, y, z), (east, north, _) = copter.limits, copter.brake(), goal
    far = math.hypot(x - east, y - north)
    height = limits.returning.height(z, far, goal[2])
    copter.speeds = MotionLimits(limits.rtl_speed, limits.climb, limits.descent)
    height = max(z + RETURN_ROUNDING, height)
    top, home = Stop((x, y, height)), Stop((east, north, height))
    away = far > SAME_PLACE
    copter.fly_to(top, home if away else None, limits.rtl_turns)
    yield
    if away:
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
    """LOITER_TURNS: fly to the nearest point of the circle, unless it is near; then circle as high as that is."""
    radius = radius_of(item)
    edge, apart = circle_entry(copter.stopping_place(), center, radius, copter.state.yaw)
    if apart > NEAR_CIRCLE:
        copter.fly_to(Stop(edge))
        yield
    copter.orbit(center, radius, circle_turn(item, copter.limits.circle_sense))
    yield


def loiter_to_alt(copter: Copter, place: Place) -> Iterator[None]:
    """LOITER_TO_ALT: fly to the place, and from within the acceptance radius of it brake and go to its height."""
    copter.fly_to(Stop(place), ends_near=True)
    yield
    copter.level_off(place[2])
    yield


def payload_place(copter: Copter, place: Place | None, item: Item) -> Iterator[None]:
    """PAYLOAD_PLACE: fly to its place, sink to the ground, or by param1 at most, and climb back; None: it is there.

    It flies there as high as it is, but to the height that the item names where that leg was planned before.
    """
    if place is not None:
        is_planned = copter.following.target == place
        copter.fly_to(Stop(place if is_planned else (*place[:2], copter.here[2])))
        yield
    top = copter.here[2]
    if copter.sink(max(math.trunc(100.0 * item.params[0]), 0) * CENTIMETRE):
        yield
        copter.hold(PLACED)
    yield
    copter.rise(top)
    yield
