"""Turn mission items, RTL and LAND into orders, as PX4's navigator."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ipoa_mission.autopilot.commands import HOLDING, LAST_NAV, Command, Frame, plain_frame
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.errors import EndlessFlight
from ipoa_mission.forecast.itinerary.itinerary import UNTIMED, Itinerary
from ipoa_mission.geometry import GRAVITY, Enu, Vector
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    GO,
    LAND,
    SIH,
    TAKE_OFF,
    Airframe,
    EastNorth,
    Order,
    SensorModel,
    SimulationConstants,
)
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import Wind, wind_table

HELD_OR_REACHED = HOLDING | {Command.NAV_LOITER_TO_ALT}
ANY_RADIUS = 1e9  # without effect [m]


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return the learned airframe, or SIH's.

    >>> airframe_of(None) is SIH
    True
    """
    if vehicle is None:
        return SIH
    return Airframe(
        SIH.drag * vehicle.value("drag", 1.0),
        vehicle.value("lag", SIH.lag),
        vehicle.value("lift_delay", 0.0),
        vehicle.value("landing_delay", 0.0),
    )


def simulation_constants(
    limits: Px4Limits, airframe: Airframe, senses: SensorModel, wind: Wind, dt: float
) -> SimulationConstants:
    tilt_gain, rotor_gain = (-math.expm1(-dt / lag) for lag in (limits.lean_lag, airframe.lag))
    senses = senses._replace(sees_ground=senses.sees_ground and limits.has_range_finder)
    steps = (dt, GRAVITY * math.tan(limits.lean), tilt_gain, rotor_gain)
    return SimulationConstants(limits, airframe, senses, wind_table(wind), *steps, turns=True, noisy=True)


def leg(limits: Px4Limits, start: Enu, goal: Enu, *, beyond: Enu | None = None, cruise: float | None = None) -> Order:
    """Return a leg on to `beyond`, or with a stop; `cruise` [m/s] is by default MPC_XY_CRUISE."""
    fastest = min(limits.cruise if cruise is None else cruise, limits.max_speed)
    return Order(
        GO, start, goal, beyond or goal, radius=limits.radius, height_radius=limits.height_radius, cruise=fastest
    )


def take_off(top: Enu, limits: Px4Limits) -> Order:
    """Return a climb above home at that time."""
    return leg(limits, top, top)._replace(kind=TAKE_OFF, follows_home=False)


def waypoint(item: Item, order: Order, limits: Px4Limits) -> Order:
    """Return the order of a leg with the item's hold, radius and heading."""
    hold_s = max(0.0, item.params[0]) if item.command in HOLDING else 0.0  # NaN: no hold
    has_radius = item.command == Command.NAV_WAYPOINT and item.params[1] > 0.001
    return order._replace(
        beyond=order.goal if hold_s > 0 else order.beyond,
        radius=item.params[1] if has_radius else limits.radius,
        hold_s=hold_s,
        heading=math.radians(item.params[3]),
        may_turn_first=True,
        follows_home=plain_frame(item.frame) != Frame.GLOBAL,
    )


def stay(place: Enu, limits: Px4Limits, seconds: float) -> list[Order]:
    order = leg(limits, place, place)
    return [order._replace(radius=ANY_RADIUS, height_radius=ANY_RADIUS, hold_s=seconds)] if seconds > 0 else []


def landing_orders(start: Enu, ground: Enu, limits: Px4Limits, cruise: float, hold_s: float) -> list[Order]:
    """Return a landing's orders, first to over the place if beyond the acceptance radius; `hold_s`: on the ground."""
    over = ground._replace(up=start.up)
    legs = [leg(limits, start, over, cruise=cruise)] if math.dist(start, over) > limits.radius else []
    ground = ground if legs else start._replace(up=ground.up)
    return [*legs, leg(limits, ground, ground, cruise=cruise)._replace(kind=LAND, hold_s=hold_s)]


def stopping_place(place: Enu, speed: EastNorth, limits: Px4Limits) -> Enu:
    """Return the stopping place of LAND and hold."""
    time = limits.stopping_time(math.hypot(speed.east, speed.north))
    return place._replace(east=place.east + speed.east * time, north=place.north + speed.north * time)


def return_orders(here: Enu, limits: Px4Limits, goal_ground: Enu, goal_height: float = 0.0) -> list[Order]:
    """Return the orders of RTL: climb by `Px4Return`, fly at MPC_XY_CRUISE, wait, land.

    The goal is home or a rally point; heights count from `goal_height`. While it climbs it flies back to `here`, until
    within NAV_LOITER_RAD.
    """
    far = math.hypot(here.east - goal_ground.east, here.north - goal_ground.north)
    height = goal_height + limits.returning.height(here.up - goal_height, far)
    top = here._replace(up=height) if height > here.up + limits.height_radius else here
    climb = [leg(limits, top, top)._replace(radius=ANY_RADIUS)] if top != here else []
    *legs, down = landing_orders(top, goal_ground, limits, limits.cruise, limits.disarm_delay)
    # PX4's return has no previous waypoint: from wherever it turns home it flies straight, and keeps to no line.
    legs = [order._replace(start=order.goal) for order in legs]
    over = down.goal._replace(up=top.up)
    low = over._replace(up=max(min(top.up, goal_height + limits.land_delay_height), goal_ground.up))
    waits = [leg(limits, over, low), *stay(low, limits, limits.land_delay)] if limits.land_delay else []
    return [*climb, *legs, *waits, down]


def contingency_orders(contingency: Contingency, row: Vector, itinerary: Itinerary, limits: Px4Limits) -> list[Order]:
    here = Enu(*map(float, row[1:4]))
    speed = EastNorth(float(row[4]), float(row[5]))
    ground = itinerary.ground
    if contingency is Contingency.RTL:
        goal = Enu(*itinerary.goal_of_return(here))
        return return_orders(here, limits, goal._replace(up=ground.at(goal.east, goal.north)), goal.up)
    stop = stopping_place(here, speed, limits)
    down = stop._replace(up=ground.at(stop.east, stop.north))
    return landing_orders(stop, down, limits, limits.cruise, limits.disarm_delay)


def orders_along(start: Enu, places: Sequence[Enu], limits: Px4Limits, ground: Enu) -> list[Order]:
    legs = list[Order]()
    leg_start = start
    for n, place in enumerate(places):
        beyond = places[n + 1] if n + 1 < len(places) else None
        if math.dist(leg_start, place) > limits.radius:
            legs.append(leg(limits, leg_start, place, beyond=beyond))
            leg_start = place
    return [*legs, leg(limits, ground, ground)._replace(kind=LAND, hold_s=limits.disarm_delay)]


class Planned(NamedTuple):
    orders: tuple[Order, ...]
    done: tuple[int, ...]  # number of orders done after each visit
    remarks: tuple[str, ...]


def orders_of_itinerary(itinerary: Itinerary, limits: Px4Limits, landing_delay: float = 0.0) -> Planned:
    """Return the orders of an itinerary, from the ground, or from over home.

    It disarms `landing_delay` s later.

    Raises:
        BadInput: an item never ends.
    """
    navigator = _Navigator(itinerary, limits)
    orders = list[Order]()
    done = list[int]()
    for n in range(len(itinerary.visits)):
        begins = orders[-1].goal if orders else navigator.here
        orders += with_patience(navigator.visit(n), begins, limits, landing_delay)
        done.append(len(orders))
    return Planned(tuple(orders), tuple(done), tuple(navigator.remarks))


def with_patience(orders: Sequence[Order], start: Enu, limits: Px4Limits, landing_delay: float) -> Iterator[Order]:
    """Yield orders flown from `start`, with the time after which each has failed."""
    slowest = min(limits.climb, limits.descent, limits.takeoff_speed, limits.land_speed, limits.crawl_speed)
    for order in orders:
        distance = math.dist(start[:2], order.goal[:2])
        rise = abs(order.goal.up - start.up)
        lasts = (300 if order.kind == LAND else 120) + 6 * distance * max(1.0, 1 / order.cruise) + 4 * rise / slowest
        late = landing_delay if order.kind == LAND else 0.0
        yield order._replace(hold_s=order.hold_s + late, patience=lasts * max(1.0, 1 / order.radius))
        start = order.goal


class _Navigator:
    def __init__(self, itinerary: Itinerary, limits: Px4Limits) -> None:
        self.itinerary = itinerary
        self.limits = limits
        self.cruise = limits.cruise
        height = itinerary.start_height
        self.here = Enu(0.0, 0.0, height or 0.0)
        self.airborne = height is not None
        self.remarks: list[str] = []

    def visit(self, n: int) -> list[Order]:
        visit = self.itinerary.visits[n]
        command = visit.item.command
        params = visit.item.params
        if command in HELD_OR_REACHED:
            start = self.here
            self.here = self.target(n)
            if command == Command.NAV_SPLINE_WAYPOINT:
                self.remarks.append(f"item {visit.seq}: PX4 knows no splines, flown straight")
            order = leg(self.limits, start, self.here, beyond=self.onward(n), cruise=self.cruise)
            return [waypoint(visit.item, order, self.limits)]
        if command == Command.NAV_TAKEOFF:
            top = self.here._replace(up=self.target(n).up)
            climb = [] if self.airborne else [take_off(top, self.limits)]
            self.airborne = True
            self.here = self.target(n)
            return [*climb, leg(self.limits, top, self.here, beyond=self.onward(n), cruise=self.cruise)]
        if command == Command.NAV_LOITER_UNLIM:
            raise EndlessFlight("loiters without end, so the flight has no time", place=f"item {visit.seq}")
        if command == Command.NAV_DELAY:
            return stay(self.here, self.limits, params[0])
        if command == Command.NAV_RETURN_TO_LAUNCH:
            if self.limits.land_delay < 0.0:
                raise EndlessFlight("with an RTL_LAND_DELAY below 0 RTL never lands", place=f"item {visit.seq}")
            self.cruise = self.limits.cruise
            places = self.itinerary.places_of_return(n, self.here)
            if places is not None:
                self.remarks.append(f"item {visit.seq}: it returns back along the mission, timed to a sixth only")
                back = [Enu(*place) for place in places]
                return self.down(orders_along(self.here, back, self.limits, self.ground(back[-1])))
            goal = Enu(*self.itinerary.goal_of_return(self.here))
            return self.down(return_orders(self.here, self.limits, self.ground(goal), goal.up))
        if command == Command.NAV_LAND:
            return self.down(landing_orders(self.here, self.ground(self.target(n)), self.limits, self.cruise, 0.0))
        if command == Command.DO_CHANGE_SPEED and params[0] < 2:
            self.cruise = params[1] if params[1] > 0 else self.limits.cruise
        elif command <= LAST_NAV or command in UNTIMED:
            self.remarks.append(f"item {visit.seq}: command {command} is not modeled and counts as no time")
        return []

    def down(self, orders: list[Order]) -> list[Order]:
        self.here = orders[-1].goal
        self.airborne = False
        return orders

    def ground(self, place: Enu) -> Enu:
        return place._replace(up=self.itinerary.ground.at(place.east, place.north))

    def target(self, n: int) -> Enu:
        """Return the place of visit n; open coordinates are those last commanded."""
        return Enu(*self.itinerary.program.place(n, self.here))

    def onward(self, n: int) -> Enu | None:
        onward = self.itinerary.program.onward(n)
        return None if onward is None else self.target(onward)
