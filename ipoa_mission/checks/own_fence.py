"""Whether a mission keeps within the fence that the vehicle has by its own parameters."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.commands import command_name
from ipoa_mission.geometry import Vector
from ipoa_mission.items import Mission
from ipoa_mission.itinerary.legs import Leg, Phase, flown_legs
from ipoa_mission.vehicles.own_fence import Limit, OwnFence
from ipoa_mission.world.frame import Geodetic, LocalFrame


def breaches(mission: Mission, fence: OwnFence, there: Geodetic) -> tuple[str, ...]:
    """Each limit that a flight from home `there` would come to or pass, in words that name the furthest place.

    The legs are those that will be flown, the way home among them.
    """
    frame = LocalFrame(mission.home)
    center = frame.local(there)[:2]
    legs = flown_legs(mission, frame, mission.ground)

    def apart(leg: Leg) -> Vector:
        return np.asarray(np.hypot(*(leg.points[:, :2] - center).T))

    def heights(leg: Leg) -> Vector:
        return np.asarray(frame.to_geodetic(leg.points)[2] - mission.home.altitude)

    def found() -> Iterator[str]:
        yield from _beyond(mission, fence.radius, [(leg, float(apart(leg).max())) for leg in legs], "away from home")
        yield from _beyond(mission, fence.ceiling, [(leg, float(heights(leg).max())) for leg in legs], "above home")
        between = [(leg, float(heights(leg).min())) for leg in legs if leg.phase is Phase.CRUISE]
        yield from _beyond(mission, fence.floor, between, "above home", sign=-1.0)

    return tuple(found())


def _beyond(
    mission: Mission, limit: Limit, reached: list[tuple[Leg, float]], where: str, sign: float = 1.0
) -> Iterator[str]:
    """What is said where some leg comes to a limit; `sign` -1: the limit is a least one."""
    leg, value = max(reached, key=lambda one: sign * one[1], default=(None, 0.0))
    if leg is None or sign * (value - limit.value) < 0.0:
        return
    item = f"item {leg.seq} ({command_name(mission.items[leg.seq - 1].command)})"
    allowed = f"{limit.value:.1f} m at {'least' if sign < 0.0 else 'most'} ({limit.name})"
    yield f"{item}: {value:.1f} m {where}, and the vehicle's own fence allows {allowed}"
