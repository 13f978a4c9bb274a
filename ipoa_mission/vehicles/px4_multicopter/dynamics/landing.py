from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import LAND, Body, Contact, Law, Order, State
from ipoa_mission.vehicles.px4_multicopter.limits import RANGE_LAG_S, STAGES


def sink_rate(state: State, order: Order, law: Law) -> float:
    """Return MPC_Z_V_AUTO_DN above MPC_LAND_ALT1, MPC_LAND_SPEED at MPC_LAND_ALT2, then a crawl.

    Between them it interpolates from MPC_Z_VEL_MAX_DN. Only a range finder measures over the ground, with a lag, and
    allows the crawl.
    """
    limits, sees = law.limits, law.senses.sees_ground
    height = state.body.place.up - (order.goal.up + RANGE_LAG_S * state.body.speed.up if sees else 0.0)
    if sees and height <= limits.crawl_below and not state.contact.lost:
        return limits.crawl_speed
    share = (height - limits.land_low) / max(limits.land_high - limits.land_low, 1e-6)
    return min(limits.land_speed + min(max(share, 0.0), 1.0) * (limits.sinks_from - limits.land_speed), limits.descent)


def stands(state: State, order: Order) -> bool:
    return order.kind == LAND and (state.contact.stands or state.body.place.up <= order.goal.up)


def detect_contact(state: State, body: Body, thrust: float, law: Law) -> Contact:
    """Return the land detector's state: low thrust and speed for long enough.

    The range finder loses the ground below an estimated height of 0.
    """
    was, touchdown = state.contact, law.limits.touchdown
    sees, stands = law.senses.sees_ground, body.on_ground
    lost = was.lost or (was.stands and (state.errors.drift.up > 0.0 or not sees))
    low = was.stages > 0 or thrust <= GRAVITY * (touchdown.low_thrust - 1.0)
    if not stands or abs(body.speed.up) >= touchdown.most_speed or not low:
        return Contact(stands, lost, 0, state.time + law.dt)
    stage = touchdown.trigger_s * (STAGES if lost and sees else 1) / STAGES
    if state.time + law.dt - was.since >= stage:
        return Contact(stands, lost, was.stages + 1, state.time + law.dt)
    return Contact(stands, lost, was.stages, was.since)
