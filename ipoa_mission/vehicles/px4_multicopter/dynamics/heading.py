import math

from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Order, State, Yaw
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits


def heading_wanted(state: State, order: Order) -> float:
    if not math.isnan(order.heading):
        return order.heading
    east, north = order.goal.east - state.body.place.east, order.goal.north - state.body.place.north
    if east * east + north * north <= order.radius * order.radius:
        return state.nose.yaw
    return math.atan2(east, north)


def heading_error(state: State, order: Order) -> float:
    error = heading_wanted(state, order) - state.nose.yaw
    return 0.0 if math.isnan(error) else error - 2.0 * math.pi * math.floor(error / (2.0 * math.pi) + 0.5)


def turned(state: State, order: Order, limits: Px4Limits, dt: float) -> Yaw:
    nose = state.nose
    if math.isnan(nose.yaw):
        return Yaw(heading_wanted(state, order), 0.0)
    error, accel = heading_error(state, order), limits.yaw_accel
    most = min(limits.yaw_rate, math.sqrt(2.0 * accel * abs(error)), abs(error) / dt)
    rate = nose.rate + min(max(math.copysign(most, error) - nose.rate, -accel * dt), accel * dt)
    return Yaw(nose.yaw + rate * dt, rate)
