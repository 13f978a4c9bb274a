"""PX4's body in wind, and its sensor errors: drift of the speed, and noisy corrections of home's height.

From 1.17 on (pull request 25003), for two minutes after take-off, home and waypoints move if the measured height
differs by 1 m. The navigator knows at once, the guidance later.
"""

import math

from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    NOT_YET,
    ZERO,
    Body,
    Enu,
    Errors,
    Level,
    SimulationConstants,
    State,
)

CORRECTED_BEYOND, CORRECTED_FOR = 1.0, 120.0  # [m, s]
NOTICED_S = 0.075  # half the navigator's cycle, and the setpoint's latency [s]
#: Two congruences (L'Ecuyer, 1988) with products exact in floating point.
FACTOR, MODULUS = 40014.0, 2147483563.0
FACTOR_2, MODULUS_2 = 40692.0, 2147483399.0


def normal(first: float, second: float) -> tuple[float, float, float, float]:
    """Return the next seeds, and two normal deviates (Box and Muller)."""
    first, second = rest(first * FACTOR, MODULUS), rest(second * FACTOR_2, MODULUS_2)
    size, angle = math.sqrt(-2.0 * math.log(first / MODULUS)), 2.0 * math.pi * second / MODULUS_2
    return first, second, size * math.cos(angle), size * math.sin(angle)


def rest(value: float, modulus: float) -> float:
    """Return `value % modulus` for a small quotient: exact, and faster compiled."""
    return value - math.floor(value / modulus) * modulus


def no_errors(seed_1: float, seed_2: float) -> Errors:
    return Errors(seed_1, seed_2, 0.0, 0.0, 0.0, NOT_YET, ZERO)


def add_sensor_errors(state: State, constants: SimulationConstants) -> Errors:
    was, time = state.errors, state.time + constants.dt
    if not constants.noisy:
        return was
    told, told_at = was.told, was.told_at
    if told_at >= 0.0 and time >= told_at:
        told, told_at = was.home, NOT_YET
    if was.next_in > constants.dt:
        return Errors(was.seed_1, was.seed_2, was.next_in - constants.dt, was.home, told, told_at, was.drift)
    senses = constants.senses
    seed_1, seed_2, n_east, n_north = normal(was.seed_1, was.seed_2)
    seed_1, seed_2, n_up, n_height = normal(seed_1, seed_2)
    kept = math.exp(-senses.every / senses.drift_lasts)
    fresh = math.sqrt(1.0 - kept * kept)
    drift = Enu(
        kept * was.drift.east + fresh * senses.drift * n_east,
        kept * was.drift.north + fresh * senses.drift * n_north,
        kept * was.drift.up + fresh * senses.drift_up * n_up,
    )
    home, measured, flown = was.home, senses.height_noise * n_height, time - state.body.airborne_since
    if flown < CORRECTED_FOR and abs(measured - home) > CORRECTED_BEYOND:
        home = measured
        told_at = time + NOTICED_S if told_at < 0.0 else told_at
    return Errors(seed_1, seed_2, was.next_in - constants.dt + senses.every, home, told, told_at, drift)


def wind_at(height: float, constants: SimulationConstants) -> tuple[float, float]:
    levels = constants.wind_levels
    if levels[0].height == levels[7].height:
        blows = 1.0
        if height < constants.gradient_height and constants.gradient_height > 0.0:
            blows = (max(height, 0.0) / constants.gradient_height) ** constants.wind_exponent
        return blows * constants.wind_east, blows * constants.wind_north
    above = 0
    while above < 7 and levels[above].height < height:
        above += 1
    low, high = levels[max(above - 1, 0)], levels[above]
    share = 1.0
    if high.height > low.height:
        share = min(max((height - low.height) / (high.height - low.height), 0.0), 1.0)
    return low.east + share * (high.east - low.east), low.north + share * (high.north - low.north)


def integrate(state: State, asked: Enu, constants: SimulationConstants, stands: bool) -> Body:
    body, drift, dt, drag = state.body, state.errors.drift, constants.dt, constants.airframe.drag
    asked_east = body.asked.east + (asked.east - body.asked.east) * constants.leaning
    asked_north = body.asked.north + (asked.north - body.asked.north) * constants.leaning
    thrust = Enu(
        body.thrust.east + (asked_east - body.thrust.east) * constants.turning,
        body.thrust.north + (asked_north - body.thrust.north) * constants.turning,
        body.thrust.up + (asked.up - body.thrust.up) * constants.turning,
    )
    lift, place, speed, since = 1.0 + thrust.up / GRAVITY, body.place, body.speed, body.airborne_since
    blows_east, blows_north = wind_at(place.up, constants)
    felt_east = thrust.east * lift - drag * (speed.east - blows_east)
    felt_north = thrust.north * lift - drag * (speed.north - blows_north)
    on_ground = stands or (body.on_ground and thrust.up <= 0.0)
    if stands:
        speed = Enu(-drift.east, -drift.north, -drift.up)
    elif on_ground:
        since = state.time
    else:
        rise = speed.up + (thrust.up - drag * speed.up) * dt
        speed = Enu(speed.east + felt_east * dt, speed.north + felt_north * dt, rise)
        place = Enu(
            place.east + (speed.east + drift.east) * dt,
            place.north + (speed.north + drift.north) * dt,
            place.up + (speed.up + drift.up) * dt,
        )
    return Body(place, speed, Level(felt_east, felt_north), Level(asked_east, asked_north), thrust, on_ground, since)
