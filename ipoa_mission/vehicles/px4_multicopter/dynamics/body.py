from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Body, Enu, Law, Level, State


def wind_at(height: float, law: Law) -> tuple[float, float]:
    levels = law.wind_levels
    if levels[0].height == levels[7].height:
        blows = 1.0
        if height < law.gradient_height and law.gradient_height > 0.0:
            blows = (max(height, 0.0) / law.gradient_height) ** law.wind_exponent
        return blows * law.wind_east, blows * law.wind_north
    above = 0
    while above < 7 and levels[above].height < height:
        above += 1
    low, high = levels[max(above - 1, 0)], levels[above]
    share = 1.0
    if high.height > low.height:
        share = min(max((height - low.height) / (high.height - low.height), 0.0), 1.0)
    return low.east + share * (high.east - low.east), low.north + share * (high.north - low.north)


def integrate(state: State, asked: Enu, law: Law, stands: bool) -> Body:
    body, drift, dt, drag = state.body, state.errors.drift, law.dt, law.airframe.drag
    asked_east = body.asked.east + (asked.east - body.asked.east) * law.leaning
    asked_north = body.asked.north + (asked.north - body.asked.north) * law.leaning
    thrust = Enu(
        body.thrust.east + (asked_east - body.thrust.east) * law.turning,
        body.thrust.north + (asked_north - body.thrust.north) * law.turning,
        body.thrust.up + (asked.up - body.thrust.up) * law.turning,
    )
    lift, place, speed, since = 1.0 + thrust.up / GRAVITY, body.place, body.speed, body.airborne_since
    blows_east, blows_north = wind_at(place.up, law)
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
