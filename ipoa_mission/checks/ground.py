"""Landings on ground that is not as high as home: many autopilots slow down by their height over home.

ArduCopter asks a rangefinder, then its terrain data, then the height above home; PX4 the distance to the ground where
a sensor gives it, else the height above home.
"""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.autopilots.parameters import DEFAULT_PARAMETERS
from ipoa_mission.autopilots.renamed import by_old_names
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters
from ipoa_mission.checks.finding import Finding, Severity
from ipoa_mission.commands import command_name
from ipoa_mission.items import Mission
from ipoa_mission.itinerary.legs import Leg, Phase
from ipoa_mission.scenario import Scenario

DEEP = 5.0  # ground that is lower than home by less than this makes no long landing [m]
FASTER = 0.05  # a touchdown faster than the landing speed by less than this is none [m/s]
SLOWEST = 0.05  # [m/s]
HOME_AGREES = 0.5  # ground at home may differ from home's altitude by so much [m]


def check_ground(mission: Mission, scenario: Scenario, legs: tuple[Leg, ...]) -> Iterator[Finding]:
    """Warnings where the vehicle touches down too fast, comes down slowly from far up, or stands at another height."""
    at_home = float(scenario.airspace.ground(np.zeros((1, 3)))[0])
    if abs(at_home) > HOME_AGREES:
        yield Finding(
            Severity.WARNING,
            0,
            f"home: the ground there is {_apart(at_home)} home's altitude: a vehicle counts heights from where it "
            f"stands, and flies {abs(at_home):.1f} m {'higher' if at_home > 0 else 'lower'} than planned",
            f"set home.altitude_amsl = {scenario.home.altitude_amsl + at_home:.1f}",
        )
    parameters = {**DEFAULT_PARAMETERS[mission.autopilot], **by_old_names(mission.parameters)}
    if parameters.get("RNGFND1_TYPE", 0.0) > 0:
        return
    reported = set[tuple[int, float]]()
    for leg in legs:
        if leg.phase is not Phase.LANDING or leg.points[-1, 2] > leg.points[0, 2]:
            continue
        height = scenario.frame.geodetic(leg.points[-1]).altitude - mission.home.altitude
        descent = _landing(mission.autopilot, parameters, height)
        if descent is not None and (leg.seq, round(height, 1)) not in reported:
            reported.add((leg.seq, round(height, 1)))
            words, hint = descent
            item = f"item {leg.seq} ({command_name(mission.items[leg.seq - 1].command)})"
            east, north = leg.points[-1, :2]
            where = f"at east {east:.1f}, north {north:.1f} the ground is {_apart(height)} home"
            yield Finding(Severity.WARNING, leg.seq, f"{item}: {where}: {words}", hint)


def _landing(autopilot: Autopilot, parameters: Parameters, height: float) -> tuple[str, str] | None:
    """What a landing on ground so high above home comes to without a rangefinder, and what helps; None if nothing."""
    slow, fast, first, last, names = _SLOWING[autopilot](parameters)
    speed = float(np.interp(height, (last, first), (slow, fast)))
    if speed > slow + FASTER:
        words = f"without a rangefinder the vehicle touches down at up to {speed:.1f} m/s, not at {slow:.1f}"
        raised = " and ".join(f"{name} = {value + height / unit:.0f}" for name, value, unit in names)
        return words, f"{raised} lets it slow down in time, in the vehicle and under [vehicle.parameters]"
    if height < -DEEP:
        way = last - height
        words = f"without a rangefinder the last {way:.0f} m are flown at {slow:.1f} m/s and take {way / slow:.0f} s"
        return words, "a rangefinder, or a waypoint low over that place with its altitude above terrain, shortens it"
    return None


_Slowing = tuple[float, float, float, float, tuple[tuple[str, float, float], ...]]


def _ardupilot(p: Parameters) -> _Slowing:
    """Landing and descent speed [m/s], heights at which slowing begins and ends [m], and the parameters for them."""
    low = max(p["LAND_ALT_LOW"] / 100, 1.0)
    fast = (p["LAND_SPEED_HIGH"] or p["WPNAV_SPEED_DN"]) / 100
    return max(p["LAND_SPEED"] / 100, SLOWEST), fast, low + 1e-6, low, (("LAND_ALT_LOW", p["LAND_ALT_LOW"], 0.01),)


def _px4(p: Parameters) -> _Slowing:
    first, last = max(p["MPC_LAND_ALT1"], p["MPC_LAND_ALT2"] + 1e-6), p["MPC_LAND_ALT2"]
    names = (("MPC_LAND_ALT1", p["MPC_LAND_ALT1"], 1.0), ("MPC_LAND_ALT2", p["MPC_LAND_ALT2"], 1.0))
    return max(p["MPC_LAND_SPEED"], SLOWEST), p["MPC_Z_V_AUTO_DN"], first, last, names


_SLOWING = {Autopilot.ARDUPILOT: _ardupilot, Autopilot.PX4: _px4}


def _apart(height: float) -> str:
    return f"{abs(height):.1f} m {'above' if height > 0 else 'below'}"
