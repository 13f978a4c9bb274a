import math
import re
from collections.abc import Container, Mapping, Sequence, Set
from enum import IntEnum
from pathlib import Path
from typing import ClassVar

import numpy as np

from ipoa_mission.autopilot import guidance_profile as profile
from ipoa_mission.autopilot import returning
from ipoa_mission.autopilot.autopilot import MULTICOPTERS, Autopilot
from ipoa_mission.autopilot.commands import FLOWN_TO, Command, Frame
from ipoa_mission.autopilot.failsafe import IN_PLACE, Contingency, FenceLimit, OwnFence
from ipoa_mission.autopilot.firmware_tables import POLYGON, Firmware, FirmwareTables, Refusals, Refused, rows
from ipoa_mission.autopilot.guidance_profile import mode_number
from ipoa_mission.autopilot.parameters import Parameters, whole
from ipoa_mission.autopilot.returning import HOME, ReturnBy, ReturnOrder, ReturnRoute
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.vehicles.px4_multicopter.failsafes import FAILSAFES
from ipoa_mission.vehicles.px4_multicopter.limits import (
    BRAKES_LATE,
    DECOUPLED_DEFAULTS,
    DECOUPLED_SINCE,
    LEAST_HOLD,
    MEASURED,
    PARAMETER_TABLE,
    Px4Limits,
    Px4Return,
    px4_limits,
)


def refused(firmware: Firmware, command: int, frame: int, values: Sequence[float], _count: int) -> Refused | None:
    if wrong := _refused_anywhere(firmware, command, frame, values):
        return wrong
    where, table = ("plain", firmware.plain) if frame == Frame.MISSION else ("placed", firmware.placed)
    if command in table:
        modes = firmware.roi_modes[where]
        is_roi = command in {Command.NAV_ROI, Command.DO_SET_ROI}
        if is_roi and not (math.isfinite(values[0]) and int(values[0]) in modes):
            listed = " or ".join(map(str, sorted(modes)))
            return Refused("INVALID_PARAM1", 1, f"expected a mode of {listed}, not {values[0]:g}")
        return None
    if command in firmware.fence or command in firmware.rally:
        return Refused("ERROR" if frame != Frame.MISSION else "UNSUPPORTED")
    return Refused("UNSUPPORTED")


def refused_in_fence(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    if command in POLYGON and not values[0] + 0.5 >= 3:
        return Refused("ERROR", 1, "expected 3 vertices or more")
    return _of_a_list(firmware, firmware.fence, command, frame, values)


def refused_in_rally(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    return _of_a_list(firmware, firmware.rally, command, frame, values)


def _of_a_list(
    firmware: Firmware, commands: Container[int], command: int, frame: int, values: Sequence[float]
) -> Refused | None:
    if wrong := _refused_anywhere(firmware, command, frame, values):
        return wrong
    if frame == Frame.MISSION:
        return Refused("UNSUPPORTED")
    return None if command in commands else Refused("ERROR")


def _refused_anywhere(firmware: Firmware, command: int, frame: int, values: Sequence[float]) -> Refused | None:
    """Return the refusal of a frame, or of an unused param other than 0 or NaN."""
    if frame not in firmware.frames:
        return Refused("UNSUPPORTED_FRAME")
    used = None if firmware.used is None else firmware.used.get(command)
    if used is None:
        return None
    places = {5: "INVALID_PARAM5_X", 6: "INVALID_PARAM6_Y"}
    for n, value in enumerate(values, start=1):
        is_integer = n in places and frame != Frame.MISSION
        if n not in used and not (math.isnan(value) or (value == 0.0 and not is_integer)):
            expected = "NaN" if is_integer else "0 or NaN"
            words = f"expected {expected}, as {firmware} does not use this param here, not {value:g}"
            return Refused(places.get(n, f"INVALID_PARAM{n}"), n, words)
    return None


def _refused_ends(commands: Set[int], parameters: Mapping[str, float]) -> Refused | None:
    """RTL counts as no landing."""
    takes_off = Command.NAV_TAKEOFF in commands
    lands = Command.NAV_LAND in commands
    match whole(parameters, "MIS_TKO_LAND_REQ"), takes_off, lands:
        case (1, False, _):
            return Refused("takeoff_missing", words="the mission needs a take-off item")
        case (3, False, _) | (3, _, False):
            return Refused("takeoff_or_land_missing", words="the mission lacks a take-off or a landing item")
        case (4 | 5, True, False):
            return Refused("add_land_or_rm_to", words="the mission has a take-off but no landing")
        case (2 | 5, _, False):
            return Refused("land_missing", words="the mission needs a landing item")
        case (4, False, True):
            return Refused("add_to_or_rm_land", words="the mission has a landing but no take-off")
    return None


class ReturnType(IntEnum):
    """Values of RTL_TYPE; unknown ones are as 0."""

    HOME_OR_RALLY = 0
    HOME_LAST = 1
    LANDING_OR_BACK = 2
    NEAREST = 3
    SHORTER_WAY = 4
    RALLY_ONLY = 5  # since 1.18


class Px4Mode(IntEnum):
    """HEARTBEAT.custom_mode."""

    MANUAL = mode_number(1)
    ALTCTL = mode_number(2)
    POSCTL = mode_number(3)
    AUTO_TAKEOFF = mode_number(4, 2)
    AUTO_LOITER = mode_number(4, 3)
    AUTO_MISSION = mode_number(4, 4)
    AUTO_RTL = mode_number(4, 5)
    AUTO_LAND = mode_number(4, 6)
    OFFBOARD = mode_number(6)
    STABILIZED = mode_number(7)


class Px4Multicopter(Autopilot):
    name = "px4"
    rank = 0
    model = "PX4"
    mav_autopilot = 12
    mav_types = MULTICOPTERS
    measured = MEASURED
    modes = profile.Modes(
        mission=Px4Mode.AUTO_MISSION,
        arming=Px4Mode.AUTO_MISSION,  # takes off once armed
        hold=Px4Mode.AUTO_LOITER,
        returning=Px4Mode.AUTO_RTL,
        returns=frozenset({Px4Mode.AUTO_RTL}),  # of an RTL item
        landing=Px4Mode.AUTO_LAND,
        names={int(mode): mode.name.replace("_", ".") for mode in Px4Mode},
        has_sub_modes=True,
    )
    parameter_table = PARAMETER_TABLE
    tables = FirmwareTables(
        Firmware(
            autopilot="px4",
            name="PX4",
            home_is_item_0=False,
            keeps_autocontinue=True,
            fence=rows(
                {
                    "w---dd.": "NAV_FENCE_POLYGON_VERTEX_INCLUSION NAV_FENCE_POLYGON_VERTEX_EXCLUSION",
                    ".---dd.": "NAV_FENCE_CIRCLE_INCLUSION NAV_FENCE_CIRCLE_EXCLUSION",
                    "----dd.": "NAV_FENCE_RETURN_POINT",
                }
            ),
            rally=rows({"----dd.": "NAV_RALLY_POINT"}),
            max_items=10_000,
            max_fence_items=64,
            max_rally_points=32,
            highest_altitude=math.inf,
            nan_holds=True,
            photo_looks_s=0.05,  # camera_trigger
            jumps=profile.JumpProfile(at_once=9),
        ),
        Path(__file__).with_name("firmware_tables.json"),
    )
    guidance = profile.GuidanceProfile(
        passes_before=FLOWN_TO - {Command.NAV_LOITER_TURNS, Command.NAV_PAYLOAD_PLACE},
        bars_takeoff=frozenset({
            Command.DO_SET_ACTUATOR, Command.DO_GRIPPER, Command.DO_AUTOTUNE_ENABLE, Command.COMPONENT_ARM_DISARM,
            Command.CONDITION_GATE, Command.DO_WINCH,
        }),
        takeoff_done_within="NAV_MC_ALT_RAD",
        turns_at_acceptance_radius=True,
        small_acceptance_radius=2.5,
        first_item=0,
        current_after_end=-1,
        climbs_coming_back=True,
        holds_at_order=True,
        brakes_after=BRAKES_LATE,
    )  # fmt: skip
    command_effects = profile.CommandEffects(
        flown=profile.SIMPLE - {Command.NAV_LAND, Command.DO_CHANGE_SPEED},
        replays_speed=True,  # MissionBase::on_activation
        flies_on=lambda command, *_: command != Command.NAV_RETURN_TO_LAUNCH,  # it changes to the mode RTL
        why={
            Command.NAV_LOITER_TO_ALT: "it continues within NAV_LOITER_RAD of the place, and changes its height there",
            Command.NAV_VTOL_TAKEOFF: "it is for a VTOL vehicle",
            Command.NAV_VTOL_LAND: "it is for a VTOL vehicle",
            Command.DO_VTOL_TRANSITION: "a multicopter waits forever for a transition to fixed wing",
            Command.DO_SET_HOME: "home changes: heights and returns refer to the new home",
            Command.COMPONENT_ARM_DISARM: "it may stop the motors",
            Command.CONDITION_DELAY: "PX4 from 1.18 on waits there, which is not modeled",
            Command.CONDITION_GATE: "it continues as the vehicle passes the gate, which is not modeled",
            Command.DO_CHANGE_SPEED: "PX4 flies its way at a speed of any kind (param1), also of a climb or descent",
            Command.NAV_LAND: "with param2 = 2 it searches a landing target, at PLD_SRCH_ALT above home",
        },
        unless={
            Command.DO_CHANGE_SPEED: lambda params: params[0] in (0.0, 1.0),
            Command.NAV_LAND: lambda params: params[1] != 2.0,
        },
    )
    protocol_profile = profile.ProtocolProfile(
        judges_later=True,
        arming_words=profile.ArmingWords(  # the commander's checks in 1.17
            re.compile(r"Arming denied: |Preflight Fail: "),
            re.compile(
                r"Resolve system health|^calibrating|No valid data|missing data|(Accel|Gyro|Compass) Sensor \d+ missing"
                r"|barometer \d+ missing|unstable|not stable|estimate required|Home position required"
                r"|requires valid home|GPS(?! signal spoofed)|High (Gyro|Accelerometer) Bias|CPU"
                r"|No connection to the GCS|system power unavailable"
            ),
        ),
        keeps_types=True,
        widen_fence="give the vehicle a wider fence (0: no limit); --anyway sends it all the same",
    )
    refusals = Refusals(refused, refused_in_fence, refused_in_rally, _refused_ends)
    slowed_by = returning.SlowedBy(
        names=("MPC_LAND_ALT1", "MPC_LAND_ALT2"),
        most=122.0,
        decided_by=("MPC_LAND_ALT1", "MPC_LAND_ALT2", "MPC_LAND_SPEED", "MPC_Z_V_AUTO_DN", "MPC_Z_VEL_MAX_DN"),
    )
    parts: ClassVar[Mapping[str, str]] = {
        "FlightModel": "ipoa_mission.vehicles.px4_multicopter.flight_model:MODEL",
        "LogFormat": "ipoa_mission.vehicles.px4_multicopter.log:FORMAT",
        "DeviationLaw": "ipoa_mission.vehicles.px4_multicopter.flight_model:LAW",
        "MockProfile": "ipoa_mission.vehicles.px4_multicopter.flight_controller:MOCK_PROFILE",
    }
    overshoots_s = 0.5  # as flown
    own_fence_by = ("GF_ACTION", "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST")
    failsafe_profile = FAILSAFES

    def braking_distance(self, parameters: Parameters, speed: Vector, accel: Vector) -> Vector:
        limits = px4_limits(parameters)
        return _braking_distance(speed, accel, limits.accel, limits.jerk)

    def stopping_displacement(
        self, parameters: Parameters, velocity: Points, accel: Points, contingency: Contingency
    ) -> Points:
        """Return the displacement; LAND and hold stop at preproject_stop_point, and hold comes back to it.

        >>> import numpy as np
        >>> still = np.zeros((1, 3))
        >>> Px4Multicopter().stopping_displacement({}, np.array([[6.0, 0.0, 0.0]]), still, Contingency.HOLD).round(1)
        array([[12.6,  0. ,  0. ]])
        """
        limits = px4_limits(parameters)
        displacement = super().stopping_displacement(parameters, velocity, accel, contingency)
        horizontal_speed = np.hypot(*velocity[:, :2].T)
        climb = velocity[:, 2]
        speed = np.abs(climb)
        brakes = np.where(climb > 0.0, limits.accel_down, limits.accel_up)
        run_on = _braking_distance(speed, accel[:, 2] * np.sign(climb), brakes, limits.jerk)
        noticed_s = 0.15 - self.braking_delay_s(contingency)  # by the navigator, the setpoint and the rotors
        if contingency in IN_PLACE:
            overshoots_s = self.overshoots_s if contingency is Contingency.HOLD else 0.0
            stops_s = limits.stopping_time(horizontal_speed) + overshoots_s
            displacement[:, :2] = velocity[:, :2] * stops_s[:, None]
            run_on += noticed_s * speed
        else:
            turns_home = _vertical_run_on(limits, horizontal_speed, climb, run_on)
            run_on = np.maximum(run_on, turns_home + noticed_s * speed)
        displacement[:, 2] = np.copysign(np.maximum(run_on, np.abs(displacement[:, 2])), climb)
        return displacement

    def sinking_brake(self, parameters: Parameters) -> returning.SinkingBrake:
        limits = px4_limits(parameters)
        return returning.SinkingBrake(limits.accel, limits.sinks_from, 0.8, 2.3, self.overshoots_s)

    def slow_stretch(self, parameters: Parameters) -> returning.SlowStretch | None:
        """Return MPC_LAND_ALT1 to MPC_LAND_ALT2.

        >>> Px4Multicopter().slowed({}, 12.0)
        {'MPC_LAND_ALT1': 22.0, 'MPC_LAND_ALT2': 17.0}
        """
        p = PARAMETER_TABLE.complete(parameters)
        descent = min(p["MPC_Z_V_AUTO_DN"], p["MPC_Z_VEL_MAX_DN"])
        low = p["MPC_LAND_ALT2"]
        return returning.SlowStretch(
            max(p["MPC_LAND_SPEED"], returning.SLOWEST), descent, max(p["MPC_LAND_ALT1"], low), low
        )

    def own_fence(self, parameters: Parameters) -> OwnFence | None:
        """Return the limits above 0, unless GF_ACTION is 0 or warns (1)."""
        p = {**PARAMETER_TABLE.others, **parameters}
        if p["GF_ACTION"] <= 1.0:
            return None

        def limit(name: str) -> FenceLimit:
            return FenceLimit(name, p[name] if p[name] > 0.0 else math.inf)

        return OwnFence(limit("GF_MAX_HOR_DIST"), limit("GF_MAX_VER_DIST"), FenceLimit("", -math.inf))

    def return_route(self, parameters: Parameters, order: ReturnOrder) -> ReturnRoute:
        """Return RTL_TYPE's route, to the nearest of home, rally points and the mission's landing.

        A rally point must be over 10 m from home, and it or a landing 2 m nearer than home.

        >>> str(Px4Multicopter().return_route({"RTL_TYPE": 2.0}, ReturnOrder((100.0, 0.0, 20.0))).by)
        'back along the mission'
        """
        here = order.here
        landing = order.landing
        kind = PARAMETER_TABLE.complete(parameters)["RTL_TYPE"]
        if kind in {ReturnType.LANDING_OR_BACK, ReturnType.SHORTER_WAY}:
            ahead = landing is not None and (kind == ReturnType.LANDING_OR_BACK or landing.ahead < landing.behind)
            return ReturnRoute(ReturnBy.MISSION_FORWARD if ahead else ReturnBy.MISSION_REVERSED)
        rally_only = kind == ReturnType.RALLY_ONLY and (order.version or self.newest).series >= (1, 18)
        best = ReturnRoute(ReturnBy.LAND_IN_PLACE if rally_only else ReturnBy.DIRECT)
        nearest = math.inf if rally_only or kind == ReturnType.HOME_LAST else math.dist(here[:2], HOME[:2])
        advantage = 2.0  # [m]
        if landing is not None and kind in {ReturnType.HOME_LAST, ReturnType.NEAREST}:
            distance = math.dist(here[:2], landing.place[:2])
            if distance + advantage < nearest:
                best, nearest = ReturnRoute(ReturnBy.LANDING), distance
        for n, place in enumerate(order.rally):
            distance = math.dist(here[:2], place[:2])
            if (rally_only or math.dist(HOME[:2], place[:2]) > 10.0) and distance + advantage < nearest:
                best, nearest = ReturnRoute(ReturnBy.DIRECT, n), distance
        return best

    def defaults_of(self, version: Version | None = None) -> Parameters:
        return DECOUPLED_DEFAULTS if (version or self.newest).series >= DECOUPLED_SINCE else {}

    def waypoint_defaults(self, version: Version | None = None) -> profile.WaypointDefaults:
        """Return a hold and 2 m from 1.18 on, whose own radius is 10 m.

        >>> Px4Multicopter().waypoint_defaults(Version(1, 18))
        WaypointDefaults(hold=0.1, radius=2.0)
        """
        if (version or self.newest).series < DECOUPLED_SINCE:
            return profile.WaypointDefaults()
        return profile.WaypointDefaults(LEAST_HOLD, PARAMETER_TABLE.moving["NAV_ACC_RAD"])

    def return_height(self, parameters: Parameters, height: float, distance: float, goal_up: float = 0.0) -> float:
        return goal_up + Px4Return.of(parameters).height(height - goal_up, distance)

    def fence_margin(self, parameters: Parameters, version: Version | None = None) -> float | None:
        """Return the distance, from 1.19 on (40e61d2429), except on the smallest boards; not modeled."""
        if (version or self.newest).series < (1, 19):
            return None
        return 2.0 * self.complete(parameters, version)["NAV_ACC_RAD"]


def _braking_distance(speed: Vector, accel: Vector, brakes: Vector | float, jerk: float) -> Vector:
    """Return the distance to a stop (n,) [m] of VelocitySmoothing, from `accel` to a deceleration `brakes`."""
    begin_accel = np.clip(accel, 0.0, brakes)
    jerk_s = (begin_accel + brakes) / jerk
    after_jerk = np.maximum(speed + (begin_accel - brakes) * jerk_s / 2, 0.0)
    jerk_s = np.minimum(jerk_s, (begin_accel + np.sqrt(begin_accel**2 + 2 * jerk * speed)) / jerk)
    distance = jerk_s * (speed + jerk_s * (begin_accel / 2 - jerk * jerk_s / 6))
    return np.asarray(distance + after_jerk**2 / (2 * brakes))


def _vertical_run_on(limits: Px4Limits, horizontal_speed: Vector, climb: Vector, braked: Vector) -> Vector:
    """Return how far (n,) [m] a climb or descent runs on while it turns home; `braked`: alone [m]."""
    # All axes change speed in the same time T, the vertical one from v to -r; r can stop within `braked`.
    speed = np.abs(climb)
    brakes = np.where(climb > 0.0, limits.accel_down, limits.accel_up)
    half = 2.0 * brakes**2 / limits.jerk  # as in `speed_to`
    fastest = np.where(climb > 0.0, limits.descent, limits.climb)
    rate = np.minimum(np.sqrt(half**2 + 2.0 * brakes * braked) - half, fastest)
    # The way home alone is limited by jerk. It runs on by v T / 2 for r = 0, and by v T / 3 for r = v.
    leaves_s = limits.cruise / limits.accel + limits.accel / limits.jerk
    limited_by_jerk = speed**2 * leaves_s / np.maximum(2.0 * speed + rate, 1e-9)
    # After level braking, evenly: for v T / (v + r), at half the speed.
    turns_s = leaves_s + horizontal_speed / limits.accel
    even = speed**2 * turns_s / np.maximum(2.0 * (speed + rate), 1e-9)
    return np.maximum(limited_by_jerk, even)


PX4_MULTICOPTER = Px4Multicopter()
