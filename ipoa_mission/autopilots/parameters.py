"""The defaults of both autopilots, the names that are known, and what each calls what the other calls otherwise."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches

from ipoa_mission.autopilots.ardupilot import ARDUCOPTER_DEFAULTS
from ipoa_mission.autopilots.px4 import PX4_DEFAULTS
from ipoa_mission.autopilots.renamed import RENAMED, by_old_names
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters
from ipoa_mission.errors import BadInput

DEFAULT_PARAMETERS: Mapping[Autopilot, Parameters] = {
    Autopilot.ARDUPILOT: ARDUCOPTER_DEFAULTS,
    Autopilot.PX4: PX4_DEFAULTS,
}

#: What every vehicle has: its own MAVLink id (ArduCopter's name since 4.7 and before), and its airframe.
SURELY_THERE: Mapping[Autopilot, tuple[tuple[str, ...], ...]] = {
    Autopilot.ARDUPILOT: (("MAV_SYSID", "SYSID_THISMAV"), ("FRAME_CLASS",)),
    Autopilot.PX4: (("MAV_SYS_ID",), ("SYS_AUTOSTART",)),
}

#: What ground stations look for besides what moves a mission.
OTHER_PARAMETERS: Mapping[Autopilot, Parameters] = {
    Autopilot.ARDUPILOT: {
        "MAV_SYSID": 1.0,
        "FRAME_CLASS": 1.0,
        "ARMING_CHECK": 1.0,
        "AUTO_OPTIONS": 0.0,
        "GUID_OPTIONS": 0.0,
        "MIS_OPTIONS": 0.0,
        "MIS_RESTART": 0.0,
        "LOG_DISARMED": 0.0,
        "FENCE_ENABLE": 0.0,
        "FENCE_TYPE": 7.0,
        "FENCE_ACTION": 1.0,
        "FENCE_OPTIONS": 0.0,
        "FENCE_MARGIN": 2.0,
        "FENCE_RADIUS": 300.0,
        "FENCE_ALT_MAX": 100.0,
        "FENCE_ALT_MIN": -10.0,
        "RTL_ALT_TYPE": 0.0,
    },
    Autopilot.PX4: {
        "MAV_SYS_ID": 1.0,
        "SYS_AUTOSTART": 4001.0,
        "GF_ACTION": 2.0,
        "GF_MAX_HOR_DIST": 0.0,
        "GF_MAX_VER_DIST": 0.0,
        "MIS_DIST_1WP": 10_000.0,
        "MIS_TAKEOFF_ALT": 2.5,
        "MIS_TKO_LAND_REQ": 0.0,
        "COM_DISARM_LAND": 2.0,
        "COM_DISARM_PRFLT": 10.0,
        "COM_RC_IN_MODE": 1.0,
        "NAV_DLL_ACT": 0.0,
    },
}

INT8, INT16, INT32, REAL32 = 2, 4, 6, 9  # MAV_PARAM_TYPE
_AS_DECLARED = {
    INT8: "WP_YAW_BEHAVIOR DISARM_DELAY FRAME_CLASS FENCE_ENABLE FENCE_ACTION FENCE_TYPE RTL_ALT_TYPE MIS_RESTART "
    "LOG_DISARMED TERRAIN_ENABLE RNGFND1_TYPE",
    INT16: "ANGLE_MAX LAND_SPEED LAND_SPEED_HIGH LAND_ALT_LOW RTL_SPEED RTL_ALT_FINAL RTL_CLIMB_MIN MAV_SYSID "
    "FENCE_OPTIONS MIS_OPTIONS",
    INT32: "RTL_ALT RTL_LOIT_TIME AUTO_OPTIONS GUID_OPTIONS ARMING_CHECK "  # ArduCopter's, then PX4's
    "MPC_YAW_MODE MPC_USE_HTE RTL_CONE_ANG MAV_SYS_ID SYS_AUTOSTART GF_ACTION MIS_TKO_LAND_REQ COM_RC_IN_MODE "
    "NAV_DLL_ACT",
}
#: What the autopilots declare, by name; a name that is not here holds a float.
TYPES: Mapping[str, int] = {name: kind for kind, names in _AS_DECLARED.items() for name in names.split()}

#: ArduCopter's name and PX4's for what does the same.
_COUNTERPARTS: Mapping[str, str] = {
    "WPNAV_SPEED": "MPC_XY_CRUISE",
    "WPNAV_SPEED_UP": "MPC_Z_V_AUTO_UP",
    "WPNAV_SPEED_DN": "MPC_Z_V_AUTO_DN",
    "WPNAV_ACCEL": "MPC_ACC_HOR",
    "WPNAV_ACCEL_Z": "MPC_ACC_UP_MAX",
    "WPNAV_JERK": "MPC_JERK_AUTO",
    "WPNAV_RADIUS": "NAV_ACC_RAD",
    "WP_YAW_BEHAVIOR": "MPC_YAW_MODE",
    "ATC_SLEW_YAW": "MPC_YAWRAUTO_MAX",
    "ANGLE_MAX": "MPC_TILTMAX_AIR",
    "LAND_SPEED": "MPC_LAND_SPEED",
    "LAND_ALT_LOW": "MPC_LAND_ALT2",
    "RTL_ALT": "RTL_RETURN_ALT",
    "RTL_ALT_FINAL": "RTL_DESCEND_ALT",
    "RTL_LOIT_TIME": "RTL_LAND_DELAY",
    "RTL_CONE_SLOPE": "RTL_CONE_ANG",
    "MOT_SPOOL_TIME": "COM_SPOOLUP_TIME",
    "DISARM_DELAY": "COM_DISARM_LAND",
    "PSC_POSXY_P": "MPC_XY_P",
    "PSC_VELXY_P": "MPC_XY_VEL_P_ACC",
    "PSC_VELXY_I": "MPC_XY_VEL_I_ACC",
    "PSC_VELXY_D": "MPC_XY_VEL_D_ACC",
    "PSC_POSZ_P": "MPC_Z_P",
    "FENCE_ENABLE": "GF_ACTION",
    "MAV_SYSID": "MAV_SYS_ID",
}


def known_parameters() -> frozenset[str]:
    """The names of all parameters that the models of either autopilot use, old names and new ones."""
    return frozenset(name for names in (*DEFAULT_PARAMETERS.values(), RENAMED) for name in names)


def expect_own(names: Iterable[str], autopilot: Autopilot) -> None:
    """Refuse the other firmware's parameters; those that are neither's pass, as a vehicle has a thousand more.

    Raises:
        BadInput: as `WPNAV_SPEED: expected a parameter of px4, not of ardupilot`, with px4's name as the hint.
    """
    own, other = _named(autopilot), _named(_other(autopilot))
    for name in names:
        if name in other and name not in own:
            counterpart = _counterpart(name, autopilot)
            raise BadInput(
                f"{name}: expected a parameter of {autopilot}, not of {_other(autopilot)}",
                hint=f"{autopilot} has {counterpart} for that" if counterpart else None,
            )


def expect_known(names: Iterable[str], autopilot: Autopilot | None = None) -> None:
    """Refuse what is no parameter of the autopilot that is known here, or of either where none is named.

    For names that a person wrote; a vehicle has a thousand that nothing here depends on.

    Raises:
        BadInput: with the name that is nearest as the hint.
    """
    if autopilot is not None:
        expect_own(names, autopilot)
    existing = frozenset.union(*(_named(one) for one in (Autopilot if autopilot is None else (autopilot,))))
    for name in names:
        if name not in existing:
            near = get_close_matches(name, sorted(existing), 1)
            raise BadInput(
                f"{name}: expected a parameter that the models know" + (f" of {autopilot}" if autopilot else ""),
                hint=f"did you mean {near[0]}?" if near else None,
            )


def firmware_of(names: Iterable[str]) -> Autopilot | None:
    """Whose parameters these are; None where none of them is known.

    >>> firmware_of(["WP_SPD", "BATT_MONITOR"])
    <Autopilot.ARDUPILOT: 'ardupilot'>
    """
    return next((one for name in names for one in Autopilot if name in _named(one)), None)


def _named(autopilot: Autopilot) -> frozenset[str]:
    renamed = RENAMED if autopilot is Autopilot.ARDUPILOT else ()
    return frozenset((*DEFAULT_PARAMETERS[autopilot], *OTHER_PARAMETERS[autopilot], *renamed))


def _other(autopilot: Autopilot) -> Autopilot:
    return Autopilot.PX4 if autopilot is Autopilot.ARDUPILOT else Autopilot.ARDUPILOT


def _counterpart(name: str, autopilot: Autopilot) -> str | None:
    """What `autopilot` calls what the other one calls `name`."""
    if autopilot is Autopilot.PX4:
        return _COUNTERPARTS.get(next(iter(by_old_names({name: 0.0}))))
    return next((ours for ours, theirs in _COUNTERPARTS.items() if theirs == name), None)
