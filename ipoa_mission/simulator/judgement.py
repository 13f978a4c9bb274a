"""A firmware's results for items and missions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.firmware_tables import Firmware
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.messages import MissionType, Result
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import values_of


def judge(autopilot: Autopilot, firmware: Firmware, item: Item, kind: int, count: int) -> Result:
    refusals = autopilot.refusals
    about = (firmware, item.command, item.frame, values_of(item))
    if kind == MissionType.MISSION:
        refusal = refusals.mission(*about, count)
    else:
        refusal = (refusals.fence if kind == MissionType.FENCE else refusals.rally)(*about)
    return Result.ACCEPTED if refusal is None else Result[refusal.result]


@dataclass(frozen=True)
class Infeasible:
    """`event`: without `navigator_mis_`."""

    words: str
    event: str
    values: tuple[float, ...] = ()


def infeasibility(
    firmware: Firmware, items: Sequence[Item], home: Geodetic, parameters: Parameters
) -> Infeasible | None:
    """Return PX4's verdict; None if it can be flown."""
    radius = parameters["NAV_MC_ALT_RAD"]
    needs_takeoff = int(parameters.get("MIS_TKO_LAND_REQ", 0.0)) in (1, 3)
    first_limit = parameters.get("MIS_DIST_1WP", 10_000.0)
    has_position = has_takeoff = False
    for seq, item in enumerate(items):
        if item.command in firmware.never_flown:
            words = f"Mission rejected: item {seq + 1}: unsupported cmd: {item.command}"
            return Infeasible(words, "unsup_cmd", (seq + 1, item.command))
        if seq == 0 and item.command == Command.NAV_LAND:
            return Infeasible("Mission rejected: starts with landing", "starts_w_landing")
        if item.command == Command.NAV_TAKEOFF:
            if item.height(home) - 1.0 < radius:
                return Infeasible("Mission rejected: Takeoff altitude too low!", "takeoff_too_low", (radius + 1.0,))
            if has_position:
                return Infeasible("Mission rejected: takeoff not first waypoint item", "takeoff_not_first")
            has_takeoff = True
        if item.has_position and not has_position:
            place = Geodetic(item.latitude_deg, item.longitude_deg, home.altitude)
            east, north, _ = LocalFrame(home).local(place)
            distance = math.hypot(east, north)
            if not distance < first_limit:
                values = (int(min(distance, 4e9)), int(first_limit))
                words = f"First waypoint too far away: {values[0]}m, {values[1]} max"
                return Infeasible(words, "first_wp_too_far", values)
        has_position = has_position or item.frame != Frame.MISSION
    if needs_takeoff and not has_takeoff:
        return Infeasible("Mission rejected: Takeoff waypoint required.", "takeoff_missing")
    return None
