"""What each firmware says to one item that is handed to it, and to a whole mission after it has stored it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ipoa_mission.autopilots.firmware import FIRMWARE
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters
from ipoa_mission.commands import Command, Frame
from ipoa_mission.items import Item
from ipoa_mission.link.messages import MissionType, Result
from ipoa_mission.world.frame import Geodetic, LocalFrame

Judge = Callable[[Item, int, int], Result]

_PARAM_RESULTS = (Result.INVALID_PARAM1, Result.INVALID_PARAM2, Result.INVALID_PARAM3, Result.INVALID_PARAM4)
_FENCE_OR_RALLY = frozenset({5000, 5001, 5002, 5003, 5004, 5100})


def judge_ardupilot(item: Item, kind: int, count: int) -> Result:
    """ArduCopter's result for an item of a list of `count`; the order of its checks matters."""
    facts = FIRMWARE[Autopilot.ARDUPILOT]
    if kind != MissionType.MISSION:
        commands = facts.fence if kind == MissionType.FENCE else facts.rally
        return _position(item) if item.command in commands else Result.UNSUPPORTED
    if item.command in (0, 1):
        return Result.INVALID
    if item.command not in facts.placed and item.command not in facts.plain:
        return Result.UNSUPPORTED
    takes_nan = 3 if item.command in (facts.takes_nan_param4 or ()) else None
    for n, (value, result) in enumerate(zip(item.params, _PARAM_RESULTS, strict=True)):
        if math.isinf(value) or (math.isnan(value) and n != takes_nan):
            return result
    if item.command == Command.DO_JUMP and not 0 < item.params[0] < count:
        return Result.ERROR
    if item.command not in facts.placed:
        return Result.ACCEPTED
    if item.frame not in facts.frames:
        return Result.UNSUPPORTED_FRAME
    return _position(item)


def _position(item: Item) -> Result:
    if not abs(item.latitude_deg) <= 90.0:
        return Result.INVALID_PARAM5_X
    if not abs(item.longitude_deg) <= 180.0:
        return Result.INVALID_PARAM6_Y
    return Result.ACCEPTED if item.altitude < FIRMWARE[Autopilot.ARDUPILOT].highest_altitude else Result.INVALID_PARAM7


def judge_px4(item: Item, kind: int, count: int) -> Result:
    """PX4's result for an item: commands and frames only, no position is ever looked at."""
    facts = FIRMWARE[Autopilot.PX4]
    if kind != MissionType.MISSION:
        commands = facts.fence if kind == MissionType.FENCE else facts.rally
        return Result.ACCEPTED if item.command in commands else Result.ERROR
    if item.frame not in facts.frames:
        return Result.UNSUPPORTED_FRAME
    if item.command in _FENCE_OR_RALLY:
        return Result.ERROR
    table = facts.plain if item.frame == Frame.MISSION else facts.placed
    return Result.ACCEPTED if item.command in table else Result.UNSUPPORTED


JUDGES: Mapping[Autopilot, Judge] = {Autopilot.ARDUPILOT: judge_ardupilot, Autopilot.PX4: judge_px4}

#: Commands that PX4 stores but that its mission check then finds no vehicle able to fly.
_STORED_BUT_NOT_FLOWN = frozenset({400, 187, 112, 114, 241, 534, 2510})


@dataclass(frozen=True)
class Infeasible:
    """Why PX4 will not fly a mission: its words, and the event's name behind `navigator_mis_` with its arguments."""

    words: str
    event: str
    values: tuple[float, ...] = ()


def infeasibility(items: Sequence[Item], home: Geodetic, parameters: Parameters) -> Infeasible | None:
    """PX4's verdict after the Ack; None where the mission can be flown."""
    radius = parameters["NAV_ACC_RAD"]
    needs_takeoff = int(parameters.get("MIS_TKO_LAND_REQ", 0.0)) in (1, 3)
    first_limit = parameters.get("MIS_DIST_1WP", 10_000.0)
    has_position = has_takeoff = False
    for seq, item in enumerate(items):
        if item.command in _STORED_BUT_NOT_FLOWN:
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
            if not (distance := math.hypot(east, north)) < first_limit:
                values = (int(min(distance, 4e9)), int(first_limit))
                words = f"First waypoint too far away: {values[0]}m, {values[1]} max"
                return Infeasible(words, "first_wp_too_far", values)
        has_position = has_position or item.frame != Frame.MISSION
    if needs_takeoff and not has_takeoff:
        return Infeasible("Mission rejected: Takeoff waypoint required.", "takeoff_missing")
    return None
