"""The vehicle itself: lean and thrust follow what is asked with their lags, drag is linear, the ground holds."""

from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Body, Enu, Law, Level, State


def carried(state: State, asked: Enu, law: Law, stands: bool) -> Body:
    """The vehicle a step later, `asked` for a lean and a thrust.

    Where it has come to stand after a flight its place stays, and what is believed of its speed is wrong.
    """
    body, drift, dt, drag = state.body, state.errors.drift, law.dt, law.airframe.drag
    asked_east = body.asked.east + (asked.east - body.asked.east) * law.leaning
    asked_north = body.asked.north + (asked.north - body.asked.north) * law.leaning
    thrust = Enu(
        body.thrust.east + (asked_east - body.thrust.east) * law.turning,
        body.thrust.north + (asked_north - body.thrust.north) * law.turning,
        body.thrust.up + (asked.up - body.thrust.up) * law.turning,
    )
    lift, place, speed, since = 1.0 + thrust.up / GRAVITY, body.place, body.speed, body.airborne_since
    blows = 1.0
    if place.up < law.gradient_height and law.gradient_height > 0.0:
        blows = (max(place.up, 0.0) / law.gradient_height) ** law.wind_exponent
    felt_east = thrust.east * lift - drag * (speed.east - blows * law.wind_east)
    felt_north = thrust.north * lift - drag * (speed.north - blows * law.wind_north)
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
