"""Check the fence of the vehicle's own parameters."""

import math
from collections.abc import Iterator

import numpy as np

from ipoa_mission.autopilot.failsafe import FenceLimit, OwnFence
from ipoa_mission.checks.numbered_finding import item_of, leg_name
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg, Phase
from ipoa_mission.geometry import Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.world.frame import Geodetic

EXCEEDING_SHARE = 0.01  # of flights


def breaches(mission: Mission, fence: OwnFence, there: Geodetic) -> tuple[str, ...]:
    """Report each limit that a flight from home `there` would reach, with the furthest place.

    The way home is among the legs. Flights deviate from them by the measured law.
    """
    law = law_of(mission.autopilot)
    lateral, down, up = (
        law.lateral(EXCEEDING_SHARE),
        law.lowest.distance(EXCEEDING_SHARE),
        law.highest.distance(EXCEEDING_SHARE),
    )
    forecast = Forecast(mission)
    frame, legs = forecast.frame, forecast.legs
    center = frame.local(there)[:2]

    def apart(leg: Leg) -> Vector:
        return np.asarray(np.hypot(*(leg.points[:, :2] - center).T))

    def heights(leg: Leg) -> Vector:
        return np.asarray(frame.to_geodetic(leg.points)[2] - mission.home.altitude)

    def found() -> Iterator[str]:
        yield from _beyond(
            mission, fence.radius, [(leg, float(apart(leg).max())) for leg in legs], "away from home", lateral
        )
        yield from _beyond(mission, fence.ceiling, [(leg, float(heights(leg).max())) for leg in legs], "above home", up)
        between = [(leg, float(heights(leg).min())) for leg in legs if leg.phase is Phase.CRUISE]
        yield from _beyond(mission, fence.floor, between, "above home", -down)

    return tuple(found())


def _beyond(
    mission: Mission, limit: FenceLimit, reached: list[tuple[Leg, float]], where: str, stray: float
) -> Iterator[str]:
    sign = math.copysign(1.0, stray)
    leg, value = max(reached, key=lambda one: sign * one[1], default=(None, 0.0))
    if leg is None or sign * (value + stray - limit.value) < 0.0:
        return
    allowed = f"{limit.value:.1f} m at {'least' if sign < 0.0 else 'most'} ({limit.name})"
    flown = f"{value:.1f} m {where} ({value + stray:.1f} m with the deviation of flights)"
    after = f" on {leg_name(leg)}" if leg.jumped_from >= 0 else ""
    yield f"{item_of(mission, leg.seq)}: {flown}{after}, and the vehicle's own fence allows {allowed}"
