import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np

from ipoa_mission.autopilot import guidance_profile as profile
from ipoa_mission.autopilot import returning
from ipoa_mission.autopilot.autopilot import MULTICOPTERS, Autopilot
from ipoa_mission.autopilot.commands import LANDINGS, WAYPOINTS, Command, Frame
from ipoa_mission.autopilot.failsafe import IN_PLACE, Contingency, OwnFence
from ipoa_mission.autopilot.firmware_tables import POLYGON, Firmware, FirmwareTables, Refusals, Refused, rows
from ipoa_mission.autopilot.parameters import Parameters, whole
from ipoa_mission.autopilot.returning import HOME, ReturnBy, ReturnOrder, ReturnRoute
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import Place, Points, Vector
from ipoa_mission.vehicles.arducopter.braking import braking_displacement, flown_circle
from ipoa_mission.vehicles.arducopter.failsafes import FAILSAFES
from ipoa_mission.vehicles.arducopter.limits import (
    FENCE_SWITCHES,
    PARAMETER_TABLE,
    CopterReturn,
    copter_limits,
    fence_limits,
)


def refused(firmware: Firmware, command: int, frame: int, values: Sequence[float], count: int) -> Refused | None:
    """`count`: items on the wire."""
    may_be_nan = (firmware.takes_nan or {}).get(command, frozenset())
    for n, value in enumerate(values[:4], start=1):
        if math.isinf(value) or (math.isnan(value) and n not in may_be_nan):
            return Refused(f"INVALID_PARAM{n}", n, f"expected a number, not {value:g}")
    if command in (0, 1):
        return Refused("INVALID")
    if not firmware.takes(command):
        return Refused("UNSUPPORTED")
    if command in firmware.placed:
        if wrong := _no_place(values, frame):
            return wrong
        if not abs(values[6]) < firmware.highest_altitude:
            return Refused("INVALID_PARAM7", 7, f"expected an altitude within {firmware.highest_altitude:g} m")
        if frame not in firmware.frames:
            return Refused("UNSUPPORTED_FRAME")
    if command in firmware.sixteen_bits and not 0 <= values[0] <= 65535:
        return Refused("INVALID_PARAM1", 1, f"expected 0 to 65535, not {values[0]:g}")
    if command == Command.DO_JUMP and not 0 < int(values[0]) < count:
        return Refused("ERROR", 1, "expected the number of an item")
    return None


def refused_in_fence(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if frame not in firmware.frames - {Frame.MISSION}:
        return Refused("UNSUPPORTED_FRAME")
    if command not in firmware.fence:
        return Refused("UNSUPPORTED")
    if command in POLYGON and values[0] > 255:
        return Refused("INVALID_PARAM1", 1, "expected 255 vertices at most")
    return None


def refused_in_rally(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if command not in firmware.rally:
        return Refused("UNSUPPORTED")
    if wrong := _no_place(values, frame):
        return wrong
    if values[6] < -32768 or values[6] > 32767:
        return Refused("INVALID_PARAM7", 7, "expected an altitude from -32768 to 32767 m")
    return None if frame in firmware.frames - {Frame.MISSION} else Refused("UNSUPPORTED_FRAME")


def _flies_on(command: int, takes_off: bool, parameters: Mapping[str, float]) -> bool:
    """Bit 2 of MIS_OPTIONS flies on from LAND to a take-off; without it the vehicle disarms."""
    lands_only = command != Command.NAV_RETURN_TO_LAUNCH and not whole(parameters, "MIS_OPTIONS") & 4
    return command not in LANDINGS or (takes_off and not lands_only)


def _no_place(values: Sequence[float], frame: int) -> Refused | None:
    """Frame 2 sends steps of 1e-7 degrees."""
    unit = 1e-7 if frame == Frame.MISSION else 1.0
    if not abs(values[4]) * unit <= 90.0:
        return Refused("INVALID_PARAM5_X", 5, f"expected a latitude, not {values[4]:g}")
    if not abs(values[5]) * unit <= 180.0:
        return Refused("INVALID_PARAM6_Y", 6, f"expected a longitude, not {values[5]:g}")
    return None


def _is_inside(fence: OwnFence, place: Place) -> bool:
    is_near = math.dist(place[:2], HOME[:2]) <= fence.radius.value
    return is_near and fence.floor.value <= place[2] <= fence.ceiling.value


#: Cameras, mounts, relays, lights and similar (RC_Channel::AUX_FUNC).
QUIET_FUNCTIONS = frozenset({
    0, 9, 15, 19, 27, 28, 29, 30, 34, 35, 36, 44, 45, 66, 67, 78, 79, 94, 102, 113, 163, 164, 166, 167, 168, 169, 172,
    174, 175, 177, 185, 186, 212, 213, 214, 215, 216, 217,
})  # fmt: skip


class ArduCopter(Autopilot):
    name = "ardupilot"
    rank = 1
    model = "ArduCopter"
    mav_autopilot = 3
    mav_types = MULTICOPTERS
    measured = (Version(4, 7, 0, "dev"), Version(4, 8, 0, "dev"))  # docs/lab/flown.md
    modes = profile.Modes(
        mission=3,
        arming=4,  # AUTO refuses arming (AUTO_OPTIONS 0)
        hold=17,  # LOITER follows the throttle stick
        returning=6,
        returns=frozenset({6, 21, 27}),
        landing=9,
        names={
            0: "STABILIZE", 1: "ACRO", 2: "ALT_HOLD", 3: "AUTO", 4: "GUIDED", 5: "LOITER", 6: "RTL", 7: "CIRCLE",
            9: "LAND", 16: "POSHOLD", 17: "BRAKE", 21: "SMART_RTL", 27: "AUTO_RTL",
        },
    )  # fmt: skip
    parameter_table = PARAMETER_TABLE
    tables = FirmwareTables(
        Firmware(
            autopilot="ardupilot",
            name="ArduPilot",
            home_is_item_0=True,
            keeps_autocontinue=False,
            fence=rows(
                {
                    "w---dd-": "NAV_FENCE_POLYGON_VERTEX_INCLUSION NAV_FENCE_POLYGON_VERTEX_EXCLUSION",
                    ".---dd-": "NAV_FENCE_CIRCLE_INCLUSION NAV_FENCE_CIRCLE_EXCLUSION",
                    "----dd-": "NAV_FENCE_RETURN_POINT",
                }
            ),
            rally=rows({"----ddm": "NAV_RALLY_POINT"}),
            fence_union_by=("FENCE_OPTIONS", 1),
            max_items=650,
            max_fence_items=70,
            max_rally_points=46,
            highest_altitude=83_000.0,
            longest_hold=65_535.0,
            holds_whole_seconds=True,
            frame_2_is_amsl=True,
            jumps=profile.JumpProfile(
                most=100,
                most_small=15,  # below 500 kB of memory
                at_once=64,
                most_repeats=32_767,
                repeats_without_end=True,
                kept_by=("MIS_OPTIONS", 3),
                looks_past_jumps=True,
                queues_actions=True,
            ),
        ),
        Path(__file__).with_name("firmware_tables.json"),
    )
    guidance = profile.GuidanceProfile(
        passes_before=frozenset(
            {*WAYPOINTS, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TIME, Command.NAV_PAYLOAD_PLACE}
        ),
        flies_vtol_items=True,
        zero_is_here=True,
        stops_to_hold=True,
        stops_at_terrain=True,
        flies_splines=True,
        climbs_where_it_stands=True,
        needs_takeoff=True,
        own_takeoff=1.0,
        waits_armed="DISARM_DELAY",
        waits_until_clock=True,
        terrain_by="RNGFND1_TYPE",
        lands_below_item=True,
        home_is_where_armed=True,
        brakes_after=0.1,
    )
    command_effects = profile.CommandEffects(
        flown=profile.SIMPLE | {
            Command.NAV_SPLINE_WAYPOINT, Command.NAV_ARC_WAYPOINT, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TO_ALT,
            Command.NAV_PAYLOAD_PLACE, Command.NAV_VTOL_LAND, Command.NAV_VTOL_TAKEOFF,
        },
        still=profile.EQUIPMENT | {
            Command.NAV_CONTINUE_AND_CHANGE_ALT, Command.NAV_ALTITUDE_WAIT, Command.NAV_SET_YAW_SPEED,  # skipped
            Command.CONDITION_DELAY, Command.CONDITION_DISTANCE, Command.CONDITION_YAW, Command.DO_FENCE_ENABLE,
            Command.DO_GUIDED_LIMITS, Command.DO_SET_RESUME_REPEAT_DIST, Command.DO_GO_AROUND, Command.DO_SET_REVERSE,
            Command.DO_PAUSE_CONTINUE, Command.DO_INVERTED_FLIGHT, Command.DO_AUTOTUNE_ENABLE,
            Command.DO_ENGINE_CONTROL, Command.DO_VTOL_TRANSITION,
        },
        why={
            Command.NAV_GUIDED_ENABLE: "another computer controls the vehicle from here on",
            Command.NAV_SCRIPT_TIME: "a script controls the vehicle from here on",
            Command.NAV_ATTITUDE_TIME: "it holds an attitude for a time, which is not modeled",
            Command.DO_SET_HOME: "home changes: heights and returns refer to the new home",
            Command.DO_PARACHUTE: "a parachute may be released",
            Command.DO_AUX_FUNCTION: "a switch may change the mode or stop the motors",
        },
        unless={
            Command.NAV_GUIDED_ENABLE: lambda params: params[0] == 0.0,
            Command.DO_PARACHUTE: lambda params: math.isfinite(params[0]) and int(params[0]) != 2,  # release
            Command.DO_AUX_FUNCTION: lambda params: math.isfinite(params[0]) and int(params[0]) in QUIET_FUNCTIONS,
        },
        flies_on=_flies_on,
    )  # fmt: skip
    protocol_profile = profile.ProtocolProfile(
        forgets_at_count=True,
        starts_by_command=True,
        pauses_in_mission=True,
        takes_mission_file=True,
        boots_slowly=True,
        tells_items=True,
        arming_words=profile.ArmingWords(  # AP_Arming, AP_Arming_Copter, AP_AHRS, NavEKF3 and AC_Fence in 4.7
            re.compile(r"(Pre)?Arm: "),
            re.compile(
                r"initialis|waiting|starting|not started|unhealthy|not healthy|not calibrated$|inconsistent \d"
                r"|(Gyros|Accels) inconsistent|(calibration|cal) running|heater temp|(position|alt) estimate"
                r"|(without|requires) position|attitude is bad|variance|vel error|yaw error|not using configured AHRS"
                r"|Altitude disparity|no terrain data|Main loop slow|GCS failsafe|HDOP|GPS \d+: Bad fix"
                r"|yaw not available"
                r"|GPS (glitching|drift|numsats|\w+ (error|speed)|speed error|and AHRS differ|positions differ)",
                re.IGNORECASE,
            ),
        ),
        parameters_by_name=True,
        limits_are_bits="FENCE_TYPE",
        widen_fence="give the vehicle a wider fence, or remove that limit from its FENCE_TYPE (4: only the mission's "
        "fence); --anyway sends it all the same",
    )
    refusals = Refusals(refused, refused_in_fence, refused_in_rally)
    slowed_by = returning.SlowedBy(
        names=("LAND_ALT_LOW",),
        most=100.0,
        decided_by=("LAND_ALT_LOW", "LAND_SPEED", "LAND_SPEED_HIGH", "WPNAV_SPEED_DN", "RNGFND1_TYPE"),
        spared_by="RNGFND1_TYPE",
    )
    parts: ClassVar[Mapping[str, str]] = {
        "FlightModel": "ipoa_mission.vehicles.arducopter.flight_model:MODEL",
        "LogFormat": "ipoa_mission.vehicles.arducopter.log:FORMAT",
        "DeviationLaw": "ipoa_mission.vehicles.arducopter.flight_model:LAW",
        "MockProfile": "ipoa_mission.vehicles.arducopter.flight_controller:MOCK_PROFILE",
    }
    own_fence_by = (
        *FENCE_SWITCHES, "FENCE_TYPE", "FENCE_ACTION", "FENCE_RADIUS", "FENCE_ALT_MAX", "FENCE_ALT_MIN",
    )  # fmt: skip
    failsafe_profile = FAILSAFES

    def braking_distance(self, parameters: Parameters, speed: Vector, accel: Vector) -> Vector:
        """
        >>> import numpy as np
        >>> ArduCopter().braking_distance({"WPNAV_ACCEL": 250.0}, np.array([10.0]), np.zeros(1)).round(2)
        array([21.25])
        """
        return copter_limits(parameters).stopping_distance(speed)

    def stopping_displacement(
        self, parameters: Parameters, velocity: Points, accel: Points, contingency: Contingency
    ) -> Points:
        """Return the displacement: shaped to land or hold, else horizontally to the stopping point.

        >>> import numpy as np
        >>> still = np.zeros((1, 3))
        >>> ArduCopter().stopping_displacement({}, np.array([[6.0, 0.0, 0.0]]), still, Contingency.HOLD).round(1)
        array([[11.,  0.,  0.]])
        """
        from ipoa_mission.compiled import compiled

        lead_s = 0.1  # of the target's vertical speed, as flown
        climb = velocity[:, 2] + lead_s * accel[:, 2]
        if contingency not in IN_PLACE:
            displacement = super().stopping_displacement(parameters, velocity, accel, contingency)
            run_on_s = 0.95  # as flown; it then comes back
            displacement[:, 2] = run_on_s * climb
            return displacement
        p = PARAMETER_TABLE.si(parameters)
        level = velocity[:, :2] @ (1.0, 1.0j)
        level_accel = accel[:, :2] @ (1.0, 1.0j)
        braking = p["WPNAV_ACCEL"]
        braking_z = p["WPNAV_ACCEL_Z"]
        if contingency is Contingency.HOLD:
            level_accel = 0.0 * level_accel
            braking = braking_z = 7.5  # BRAKE_MODE_DECEL_RATE [m/s^2]
        level_lead_s = 0.25  # of the target's horizontal speed, as flown
        stop = compiled(braking_displacement)
        offset = stop(level + level_lead_s * level_accel, level_accel, braking, p["PSC_JERK_XY"])
        lag_s = 0.08  # as flown
        rise = stop(climb + 0j, 0j * climb, braking_z, p["PSC_JERK_Z"]).real + lag_s * climb
        return np.column_stack([offset.real, offset.imag, rise])

    def sinking_brake(self, parameters: Parameters) -> returning.SinkingBrake:
        limits = copter_limits(parameters)
        return returning.SinkingBrake(limits.accel, max(limits.land_speed_high, limits.land_speed), 0.8, 0.35, 0.06)

    def circle(
        self, parameters: Parameters, radius: float, turn: float, speed: float | None, version: Version | None
    ) -> profile.FlownCircle | None:
        """Return the circle of pursuit.

        >>> flown = ArduCopter().circle({}, 60.0, 6.28, None, None)
        >>> round(flown.radius, 1), round(flown.runs_on, 1)
        (58.4, 15.5)
        """
        limits = copter_limits(parameters, version)
        return flown_circle(limits, radius, speed or limits.speed, turn)

    def slow_stretch(self, parameters: Parameters) -> returning.SlowStretch | None:
        """Return LAND_SPEED below LAND_ALT_LOW.

        >>> ArduCopter().slow_stretch({}).touchdown(12.0)
        1.5
        """
        p = PARAMETER_TABLE.si(parameters)
        if p["RNGFND1_TYPE"] > 0:
            return None
        low = max(p["LAND_ALT_LOW"], 1.0)
        fast = p["LAND_SPEED_HIGH"] or p["WPNAV_SPEED_DN"]
        return returning.SlowStretch(max(p["LAND_SPEED"], returning.SLOWEST), fast, low, low)

    def own_fence(self, parameters: Parameters) -> OwnFence | None:
        """Return FENCE_TYPE's limits if FENCE_ACTION does more than report (AC_Fence)."""
        action = {**PARAMETER_TABLE.others, **parameters}["FENCE_ACTION"]
        return None if action <= 0.0 else fence_limits(parameters)

    def return_route(self, parameters: Parameters, order: ReturnOrder) -> ReturnRoute:
        """Return the way to RTL's rally point: the nearest inside the own fence.

        Home counts if nearer and RALLY_INCL_HOME, or if all are beyond RALLY_LIMIT_KM. Not modeled: polygon fences, and
        OA_TYPE.
        """
        fence = fence_limits(parameters)
        home = ReturnRoute(ReturnBy.DIRECT)
        inside = [n for n, place in enumerate(order.rally) if fence is None or _is_inside(fence, place)]
        distances = {n: math.dist(order.here[:2], order.rally[n][:2]) for n in inside}
        if not distances:
            return home
        nearest = min(distances, key=distances.__getitem__)
        p = PARAMETER_TABLE.complete(parameters)
        limit = 1000.0 * p["RALLY_LIMIT_KM"]
        if limit > 0.0 and distances[nearest] > limit:
            return home
        if p["RALLY_INCL_HOME"] != 0.0 and distances[nearest] >= math.dist(order.here[:2], HOME[:2]):
            return home
        return ReturnRoute(ReturnBy.DIRECT, nearest)

    def return_height(self, parameters: Parameters, height: float, distance: float, goal_up: float = 0.0) -> float:
        """Return RTL_ALT, lowered by the cone and the fence.

        >>> ArduCopter().return_height({"RTL_ALT": 6000.0, "FENCE_ENABLE": 1.0, "FENCE_ALT_MAX": 50.0}, 20.0, 400.0)
        48.0
        """
        return CopterReturn.of(parameters).height(height, distance, goal_up)

    def over_terrain(self, parameters: Parameters) -> returning.OverTerrain | None:
        """Return the effect of RTL_ALT_TYPE 1, which needs a range finder or terrain data.

        While a range finder sees no ground, it acts as RTL_ALT_TYPE 0.

        >>> ArduCopter().over_terrain({"RTL_ALT_TYPE": 1.0, "WPNAV_TER_MARGIN": 6.0})
        OverTerrain(margin=6.0, always_over_terrain=True)
        """
        p = PARAMETER_TABLE.complete(parameters)
        sees_ground = p["RNGFND1_TYPE"] > 0.0 and p.get("WPNAV_RFND_USE", 1.0) > 0.0
        follows = math.isclose(p["RTL_ALT_TYPE"], 1.0)
        if not (follows and (sees_ground or p.get("TERRAIN_ENABLE", 1.0) > 0.0)):
            return None
        return returning.OverTerrain(max(p.get("WPNAV_TER_MARGIN", 10.0), 0.1), not sees_ground)


ARDUCOPTER = ArduCopter()
