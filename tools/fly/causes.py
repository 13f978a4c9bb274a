"""Trigger the failsafes of a simulated vehicle in flight, by the cause's name in `Autopilot.failsafes`."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ipoa_mission.autopilot.autopilot import Autopilot


@dataclass(frozen=True)
class Trigger:
    """Define a cause, parameters `before` the flight, and its trigger: parameters, a command, silence, or sticks.

    `silent`: the ground station stops sending. `sticks`: they are moved by MAVLink until then. `fails`: unit, type and
    number of MAV_CMD_INJECT_FAILURE. `traffic`: reports an aircraft on a collision course. `over_terrain`: waypoint
    heights are above terrain.
    """

    cause: str
    before: Mapping[str, float] = field(default_factory=dict)
    then: Mapping[str, float] = field(default_factory=dict)
    silent: bool = False
    sticks: bool = False
    fails: tuple[int, int, int] | None = None
    traffic: bool = False
    over_terrain: bool = False


RC = {"SIM_RC_FAIL": 1.0}
EMPTY = {"SIM_BATT_VOLTAGE": 10.0}
STATION = {"MAV_GCS_SYSID": 245.0, "FS_GCS_TIMEOUT": 60.0}
FENCED = {"FENCE_TYPE": 1.0, "FENCE_ENABLE": 1.0, "FENCE_ALT_MAX": 300.0, "FENCE_MARGIN": 0.5}
LOW = {"FENCE_ALT_MAX": 5.0}
ROUND = {"FENCE_TYPE": 2.0, "FENCE_ENABLE": 1.0, "FENCE_RADIUS": 2000.0, "FENCE_MARGIN": 0.5}
CRITICAL = {"BATT_CRT_VOLT": 10.2, "BATT_LOW_VOLT": 0.0}
NO_GPS = {"SIM_GPS1_ENABLE": 0.0}
CHARGE = {"BATT_LOW_VOLT": 0.0, "BATT_CRT_VOLT": 0.0}
HIGH = {"FENCE_TYPE": 8.0, "FENCE_ENABLE": 1.0, "FENCE_ALT_MIN": -90.0, "FENCE_MARGIN": 0.5}
SEES = {"ADSB_TYPE": 1, "AVD_ENABLE": 1, "AVD_F_RCVRY": 0}
#: A range finder replaces the terrain data, and then sees no farther than that.
FINDER = {"RNGFND1_TYPE": 100, "RNGFND1_ORIENT": 25, "RNGFND1_MAX": 300.0, "TERRAIN_ENABLE": 0}
CHUTE = {"CHUTE_ENABLED": 1, "CHUTE_TYPE": 10, "SERVO9_FUNCTION": 27, "CHUTE_ALT_MIN": 2, "CHUTE_CRT_SINK": 3.0}
DRAG = {"EK3_DRAG_BCOEF_X": 20.0, "EK3_DRAG_BCOEF_Y": 20.0, "EK3_DRAG_MCOEF": 0.2, "FS_DR_TIMEOUT": 60}

COPTER = (
    Trigger("radio control lost", {"FS_THR_ENABLE": 1}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 3}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 4}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 5}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 7}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 1, "FS_OPTIONS": 1}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 0}, RC),
    Trigger("radio control lost", {"FS_THR_ENABLE": 6}, RC),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 0}, EMPTY),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 1}, EMPTY),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 2}, EMPTY),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 3}, EMPTY),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 4}, EMPTY),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 7}, EMPTY),
    Trigger("critical battery", {**CRITICAL, "BATT_FS_CRT_ACT": 1}, EMPTY),
    Trigger("critical battery", {**CRITICAL, "BATT_FS_CRT_ACT": 2}, EMPTY),
    Trigger("critical battery", {"BATT_CRT_VOLT": 10.2, "BATT_FS_LOW_ACT": 2, "BATT_FS_CRT_ACT": 3}, EMPTY),
    Trigger("ground station lost", {**STATION, "FS_GCS_ENABLE": 1}, silent=True),
    Trigger("ground station lost", {**STATION, "FS_GCS_ENABLE": 3}, silent=True),
    Trigger("ground station lost", {**STATION, "FS_GCS_ENABLE": 5}, silent=True),
    Trigger("ground station lost", {**STATION, "FS_GCS_ENABLE": 7}, silent=True),
    Trigger("ground station lost", {**STATION, "FS_GCS_ENABLE": 1, "FS_OPTIONS": 2}, silent=True),
    Trigger("fence breached", {**FENCED, "FENCE_ACTION": 1}, LOW),
    Trigger("fence breached", {**FENCED, "FENCE_ACTION": 2}, LOW),
    Trigger("fence breached", {**FENCED, "FENCE_ACTION": 3}, LOW),
    Trigger("fence breached", {**FENCED, "FENCE_ACTION": 4}, LOW),
    Trigger("fence breached", {**FENCED, "FENCE_ACTION": 0}, LOW),
    Trigger("fence breached", {**ROUND, "FENCE_ACTION": 1}, {"FENCE_RADIUS": 30.0}),
    Trigger(
        "position lost (EKF)", {"FS_DR_ENABLE": 2, "FS_DR_TIMEOUT": 60}, NO_GPS
    ),  # its EKF does not estimate wind here
    Trigger("position lost (EKF)", {"FS_DR_ENABLE": 1, "FS_DR_TIMEOUT": 60}, NO_GPS),
    Trigger("position lost (EKF)", {"FS_DR_ENABLE": 0, "FS_EKF_ACTION": 1}, NO_GPS),
    Trigger("position lost (EKF)", {"FS_DR_ENABLE": 0, "FS_EKF_ACTION": 3}, NO_GPS),
    Trigger("position lost (EKF)", {"FS_DR_ENABLE": 0, "FS_EKF_ACTION": 2}, NO_GPS),
    Trigger("radio control lost", {"FS_THR_ENABLE": 3}, {"SIM_RC_FAIL": 2.0}),  # low throttle
    Trigger("radio control lost", {"FS_THR_ENABLE": 1}, {"SIM_RC_FAIL": 2.0}),
    Trigger("low battery", {**CHARGE, "BATT_LOW_MAH": 1.0, "BATT_FS_LOW_ACT": 2}, {"BATT_LOW_MAH": 30000.0}),
    Trigger("low battery", {**CHARGE, "BATT_LOW_MAH": 1.0, "BATT_FS_LOW_ACT": 1}, {"BATT_LOW_MAH": 30000.0}),
    Trigger("critical battery", {**CHARGE, "BATT_CRT_MAH": 1.0, "BATT_FS_CRT_ACT": 3}, {"BATT_CRT_MAH": 30000.0}),
    Trigger("critical battery", {**CHARGE, "BATT_CRT_MAH": 1.0, "BATT_FS_CRT_ACT": 1}, {"BATT_CRT_MAH": 30000.0}),
    Trigger("fence breached", {**HIGH, "FENCE_ACTION": 1}, {"FENCE_ALT_MIN": 95.0}),
    Trigger("fence breached", {**HIGH, "FENCE_ACTION": 2}, {"FENCE_ALT_MIN": 95.0}),
    Trigger("position by dead reckoning", {**DRAG, "FS_DR_ENABLE": 2}, NO_GPS),
    Trigger("position by dead reckoning", {**DRAG, "FS_DR_ENABLE": 1}, NO_GPS),
    Trigger("traffic near", {**SEES, "AVD_F_ACTION": 5}, traffic=True),
    Trigger("traffic near", {**SEES, "AVD_F_ACTION": 6}, traffic=True),
    Trigger("traffic near", {**SEES, "AVD_F_ACTION": 1}, traffic=True),
    Trigger("terrain data missing", FINDER, {"RNGFND1_MAX": 0.5}, over_terrain=True),
    Trigger("parachute", CHUTE, {"SIM_ENGINE_FAIL": 15, "SIM_ENGINE_MUL": 0.0}),
    Trigger("thrust lost", {}, {"SIM_ENGINE_FAIL": 15, "SIM_ENGINE_MUL": 0.45}),
    Trigger("vibration", {}, {f"SIM_ACC{n}_BIAS_Z": 1.2 for n in (1, 2, 3)}),
    Trigger("satellite position jumps", {}, {"SIM_GPS1_GLTCH_X": 0.0003}),
    Trigger("compasses lost", {}, {f"SIM_MAG{n}_FAIL": 1 for n in (1, 2, 3)}),
    Trigger("traffic near", {**SEES, "AVD_F_ACTION": 2}, traffic=True),
    Trigger("low battery", {"BATT_FS_LOW_ACT": 6}, EMPTY),
    Trigger("critical battery", {**CRITICAL, "BATT_FS_CRT_ACT": 4}, EMPTY),
    Trigger("critical battery", {**CRITICAL, "BATT_FS_CRT_ACT": 7}, EMPTY),
    Trigger("ground station lost", {**STATION, "FS_GCS_ENABLE": 4}, silent=True),
    Trigger("fence breached", {**FENCED, "FENCE_ACTION": 5}, LOW),
    Trigger("fence breached", {**ROUND, "FENCE_ACTION": 4}, {"FENCE_RADIUS": 30.0}),
    Trigger("radio control lost", {"FS_THR_ENABLE": 4}, {"SIM_RC_FAIL": 2.0}),
    Trigger("critical battery", {**CRITICAL, "BATT_FS_CRT_ACT": 5}, EMPTY),
)

GCS = {"COM_DL_LOSS_T": 60}
JOYSTICK = {"COM_RC_IN_MODE": 1, "COM_RC_LOSS_T": 30.0}
FENCE_UP = {"GF_MAX_VER_DIST": 5.0}
FENCE_ROUND = {"GF_MAX_HOR_DIST": 20.0}
BATTERY = {"SIM_BAT_MIN_PCT": 50.0}
NEARLY = {"BAT_CRIT_THR": 0.95, "BAT_LOW_THR": 0.99}
GONE = {"BAT_EMERGEN_THR": 0.94, "BAT_CRIT_THR": 0.95, "BAT_LOW_THR": 0.99}
BATTERY_OFF = (100, 1, 0)  # FAILURE_UNIT_SYSTEM_BATTERY, FAILURE_TYPE_OFF
MOTOR_OFF = (101, 1, 1)  # FAILURE_UNIT_SYSTEM_MOTOR
SEES_WIND = {"EKF2_DRAG_CTRL": 1, "COM_WIND_MAX": 50.0}

PX4 = (
    Trigger("ground station lost", {**GCS, "NAV_DLL_ACT": 0}, silent=True),
    Trigger("ground station lost", {**GCS, "NAV_DLL_ACT": 1}, silent=True),
    Trigger("ground station lost", {**GCS, "NAV_DLL_ACT": 2}, silent=True),
    Trigger("ground station lost", {**GCS, "NAV_DLL_ACT": 3}, silent=True),
    Trigger("ground station lost", {**GCS, "NAV_DLL_ACT": 2, "COM_DLL_EXCEPT": 1}, silent=True),
    Trigger("radio control lost", {**JOYSTICK, "NAV_RCL_ACT": 1}, sticks=True),
    Trigger("radio control lost", {**JOYSTICK, "NAV_RCL_ACT": 2}, sticks=True),
    Trigger("radio control lost", {**JOYSTICK, "NAV_RCL_ACT": 3}, sticks=True),
    Trigger("radio control lost", {**JOYSTICK, "NAV_RCL_ACT": 2, "COM_RCL_EXCEPT": 1}, sticks=True),
    Trigger("fence breached", {"GF_ACTION": 1}, FENCE_UP),
    Trigger("fence breached", {"GF_ACTION": 2}, FENCE_UP),
    Trigger("fence breached", {"GF_ACTION": 3}, FENCE_UP),
    Trigger("fence breached", {"GF_ACTION": 5}, FENCE_UP),
    Trigger("fence breached", {"GF_ACTION": 3}, FENCE_ROUND),
    Trigger("fence breached", {"GF_ACTION": 2}, FENCE_ROUND),
    Trigger("flown for too long", {"COM_FLT_TIME_MAX": 3000}, {"COM_FLT_TIME_MAX": 1}),
    Trigger("low battery", BATTERY, {"BAT_LOW_THR": 0.99}),
    Trigger("critical battery", {**BATTERY, "COM_LOW_BAT_ACT": 0}, NEARLY),
    Trigger("critical battery", {**BATTERY, "COM_LOW_BAT_ACT": 1}, NEARLY),
    Trigger("critical battery", {**BATTERY, "COM_LOW_BAT_ACT": 2}, NEARLY),
    Trigger("critical battery", {**BATTERY, "COM_LOW_BAT_ACT": 3}, NEARLY),
    Trigger("emergency battery", {**BATTERY, "COM_LOW_BAT_ACT": 3}, GONE),
    Trigger("emergency battery", {**BATTERY, "COM_LOW_BAT_ACT": 1}, GONE),
    Trigger("flown for too long", {"COM_FLT_TIME_MAX": 3000, "COM_FAIL_ACT_T": 0}, {"COM_FLT_TIME_MAX": 1}),
    Trigger("critical battery", {**BATTERY, "COM_LOW_BAT_ACT": 1, "COM_FAIL_ACT_T": 0}, NEARLY),
    Trigger("emergency battery", {**BATTERY, "COM_LOW_BAT_ACT": 2}, GONE),
    Trigger("position inaccurate", {"COM_POS_LOW_EPH": 500.0, "COM_POS_LOW_ACT": 3}, {"COM_POS_LOW_EPH": 0.01}),
    Trigger("position inaccurate", {"COM_POS_LOW_EPH": 500.0, "COM_POS_LOW_ACT": 2}, {"COM_POS_LOW_EPH": 0.01}),
    Trigger("position inaccurate", {"COM_POS_LOW_EPH": 500.0, "COM_POS_LOW_ACT": 5}, {"COM_POS_LOW_EPH": 0.01}),
    Trigger("position lost (EKF)", {}, {"SIM_GPS_USED": 0}),
    Trigger("attitude or motor failure", {"CBRK_FLIGHTTERM": 0}, {"FD_FAIL_R": 1, "FD_FAIL_P": 1}),
    Trigger("emergency battery", {"SYS_FAILURE_EN": 1, "COM_LOW_BAT_ACT": 2}, fails=BATTERY_OFF),
    Trigger("emergency battery", {"SYS_FAILURE_EN": 1, "COM_LOW_BAT_ACT": 1}, fails=BATTERY_OFF),
    Trigger("traffic near", {"NAV_TRAFF_AVOID": 2}, traffic=True),
    Trigger("traffic near", {"NAV_TRAFF_AVOID": 3}, traffic=True),
    Trigger("traffic near", {"NAV_TRAFF_AVOID": 4}, traffic=True),
    Trigger("traffic near", {"NAV_TRAFF_AVOID": 1}, traffic=True),
    Trigger("wind too strong", {**SEES_WIND, "COM_WIND_MAX_ACT": 3}, {"COM_WIND_MAX": 0.01}),
    Trigger("wind too strong", {**SEES_WIND, "COM_WIND_MAX_ACT": 5}, {"COM_WIND_MAX": 0.01}),
    Trigger("wind too strong", {**SEES_WIND, "COM_WIND_MAX_ACT": 2}, {"COM_WIND_MAX": 0.01}),
    Trigger("propeller out of balance", {"COM_IMB_PROP_ACT": 1}, {"FD_IMB_PROP_THR": 1}),
    Trigger("propeller out of balance", {"COM_IMB_PROP_ACT": 2}, {"FD_IMB_PROP_THR": 1}),
    Trigger("flight time left is short", {"COM_FLTT_LOW_ACT": 3, "BAT1_CAPACITY": 9000.0}, {"BAT1_CAPACITY": 40.0}),
    Trigger("attitude or motor failure", {"SYS_FAILURE_EN": 1, "CBRK_FLIGHTTERM": 0}, fails=MOTOR_OFF),
    Trigger("fence breached", {"GF_ACTION": 4}, FENCE_UP),
    Trigger("fence breached", {"GF_ACTION": 5}, FENCE_ROUND),
    Trigger("radio control lost", {**JOYSTICK, "NAV_RCL_ACT": 5}, sticks=True),
    Trigger("position inaccurate", {"COM_POS_LOW_EPH": 500.0, "COM_POS_LOW_ACT": 4}, {"COM_POS_LOW_EPH": 0.01}),
    Trigger("wind too strong", {**SEES_WIND, "COM_WIND_MAX_ACT": 4}, {"COM_WIND_MAX": 0.01}),
    Trigger("ground station lost", {**GCS, "NAV_DLL_ACT": 6}, silent=True),
    Trigger("radio control lost", {**JOYSTICK, "NAV_RCL_ACT": 6}, sticks=True),
    Trigger("fence breached", {"GF_ACTION": 4}, FENCE_ROUND),
    Trigger("fence breached", {"GF_ACTION": 1}, FENCE_ROUND),
    Trigger("wind too strong", {**SEES_WIND, "COM_WIND_MAX_ACT": 1}, {"COM_WIND_MAX": 0.01}),
    Trigger("position inaccurate", {"COM_POS_LOW_EPH": 500.0, "COM_POS_LOW_ACT": 1}, {"COM_POS_LOW_EPH": 0.01}),
    Trigger("critical battery", {**BATTERY, "COM_LOW_BAT_ACT": 3, "COM_FAIL_ACT_T": 0}, NEARLY),
    Trigger("flight time left is short", {"COM_FLTT_LOW_ACT": 1, "BAT1_CAPACITY": 9000.0}, {"BAT1_CAPACITY": 40.0}),
)

TRIGGERS: Mapping[Autopilot, tuple[Trigger, ...]] = {Autopilot.ARDUPILOT: COPTER, Autopilot.PX4: PX4}
