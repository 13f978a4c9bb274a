"""Reduce a mission to the part that can be checked."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.commands import TAKEOFFS
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.checks.positions import refusals, unsound
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import LEFT_OUT

if TYPE_CHECKING:
    from ipoa_mission.forecast.deviation.promise import Promise


def sound_part(forecast: Forecast, positions: Iterable[Finding]) -> Forecast | None:
    """Return the flight without wrong items; None where home itself is wrong.

    A take-off without a place is one from home.
    """
    mission, wrong = forecast.given, {finding.seq for finding in unsound(positions)}
    if 0 in wrong:
        return None
    if not wrong:
        return forecast
    if None in wrong:  # the fence, or a rally point
        mission = replace(mission, fence=(), rally=())
    left_out: set[int] = set()
    items = list(mission.items)
    for seq in wrong - {None}:
        assert seq is not None
        item = items[seq - 1]
        if item.command in TAKEOFFS and not item.has_position and 0 < mission.altitude_above_home(item) < math.inf:
            home = mission.home
            items[seq - 1] = replace(item, latitude_deg=home.latitude_deg, longitude_deg=home.longitude_deg)
        else:
            items[seq - 1] = LEFT_OUT
            left_out.add(seq)
    return Forecast(replace(mission, items=tuple(items)), forecast.scenario, left_out=frozenset(left_out))


def promise_if_flown(forecast: Forecast) -> "Promise | None":
    """Return the promise; None where it cannot be flown or is unknown."""
    mission = forecast.given
    return None if refusals(mission) or is_too_long(mission) else forecast.promise_if_known
