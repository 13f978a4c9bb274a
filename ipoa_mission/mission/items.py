"""A mission: items, fence, rally points and home, which is no item."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ipoa_mission.autopilot import commands
from ipoa_mission.autopilot.autopilot import (
    MULTICOPTERS,
    QUADROTOR,
    Autopilot,
    class_name,
    default_autopilot,
    with_article,
)
from ipoa_mission.autopilot.commands import Command, Frame, plain_frame
from ipoa_mission.autopilot.firmware_tables import Firmware
from ipoa_mission.autopilot.known_parameters import expect_own
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.geodesy import Geodetic, LocalFrame


@dataclass(frozen=True)
class Item:
    """One mission item, numbered from 1 as in mission files and DO_JUMP.

    Attributes:
        command: MAV_CMD.
        frame: MAV_FRAME.
        params: param1 to param4; NaN: the autopilot's default.
        latitude_deg: param5, whatever its meaning.
        longitude_deg: param6.
        altitude: param7.
        autocontinue: go on with the next item.

    Example:
        >>> up = Item(Command.NAV_TAKEOFF, Frame.GLOBAL_RELATIVE_ALT, (0.0, 0.0, 0.0, math.nan), 47.3977, 8.5456, 15.0)
        >>> up.has_position, up.height(Geodetic(47.3977, 8.5456, 488.0))
        (True, 15.0)
    """

    command: int
    frame: int
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    altitude: float = 0.0
    autocontinue: bool = True

    @property
    def name(self) -> str:
        return commands.command_name(self.command)

    @property
    def is_jump(self) -> bool:
        return self.command in commands.JUMPS

    @property
    def is_takeoff(self) -> bool:
        return self.command in commands.TAKEOFFS

    @property
    def is_waypoint(self) -> bool:
        return self.command in commands.WAYPOINTS

    @property
    def moves(self) -> bool:
        return self.command <= commands.LAST_NAV or self.command in commands.MOVING_AFTER_LAST_NAV

    @property
    def has_position(self) -> bool:
        return self._is_flown_to and (self.latitude_deg, self.longitude_deg) != (0.0, 0.0)

    @property
    def _is_flown_to(self) -> bool:
        return self.command in commands.FLOWN_TO and self.frame != Frame.MISSION

    def is_here(self, autopilot: Autopilot) -> bool:
        return autopilot.guidance.zero_is_here and self._is_flown_to and not self.has_position

    def is_as_high_as_now(self, autopilot: Autopilot) -> bool:
        has_height = self._is_flown_to and self.command not in commands.TAKEOFF_AND_LAND
        return autopilot.guidance.zero_is_here and has_height and self.altitude == 0.0

    @property
    def is_over_terrain(self) -> bool:
        return plain_frame(self.frame) == Frame.GLOBAL_TERRAIN_ALT

    @property
    def hold_s(self) -> float:
        """Return the seconds that it waits at its place; NaN: none."""
        waits = self.command in commands.HOLDING or self.command == Command.NAV_DELAY
        return max(0.0, self.params[0]) if waits else 0.0

    @property
    def clock(self) -> str:
        """Return the time until which NAV_DELAY waits, or "".

        >>> Item(Command.NAV_DELAY, Frame.MISSION, (0.0, 18.0, 30.0, 0.0)).clock
        '18:30:00 UTC'
        """
        seconds, *fields = self.params
        if self.command != Command.NAV_DELAY or seconds > 0 or not all(map(math.isfinite, fields)):
            return ""
        hour, minute, second = map(int, fields)
        if hour != -1:
            return f"{hour:02}:{max(minute, 0):02}:{max(second, 0):02} UTC"
        if minute != -1:
            return f"{minute:02}:{max(second, 0):02} past the hour"
        return "" if second == -1 else f"second {second} of the minute"

    def height(self, home: Geodetic) -> float:
        """Return the height above home [m]; a terrain altitude is taken as one."""
        return self.altitude - home.altitude if plain_frame(self.frame) == Frame.GLOBAL else self.altitude


LEFT_OUT = Item(Command.CONDITION_DELAY, Frame.MISSION)


@dataclass(frozen=True)
class FencePolygon:
    """Polygon of a geofence.

    Attributes:
        vertices: (latitude, longitude) [degrees], the first not repeated.
        inclusion: stay inside; else outside.

    Example:
        >>> len(FencePolygon(((39.100, 121.819), (39.100, 121.823), (39.103, 121.821))).vertices)
        3
    """

    vertices: tuple[tuple[float, float], ...]
    inclusion: bool = True


@dataclass(frozen=True)
class FenceCircle:
    """Circle of a geofence.

    Attributes:
        center: (latitude, longitude) [degrees].
        radius: [m].
        inclusion: stay inside; else outside.

    Example:
        >>> FenceCircle((39.1, 121.8), 500.0).inclusion
        True
    """

    center: tuple[float, float]
    radius: float
    inclusion: bool = True


@dataclass(frozen=True)
class ComplexItem:
    """A survey or scan of QGroundControl; `json_text` is its entry in a file."""

    items: tuple[Item, ...]
    json_text: str


@dataclass(frozen=True)
class Mission:
    """A mission with home, fence, rally points and vehicle.

    Attributes:
        home: place of arming, and zero of heights.
        items: without home.
        autopilot: PX4 by default.
        cruise_speed: of a `.plan` [m/s]; the vehicle obeys DO_CHANGE_SPEED instead.
        fence: polygons and circles.
        rally: places of return instead of home; altitudes above home [m].
        parameters: that differ from the autopilot's defaults.
        vehicle_type: MAV_TYPE of a `.plan`.
        vehicle: properties learned from logs.
        landing_ground: landing place and height of its ground above home; ignored for other landings.
        firmware_version: of tables and model; the newest measured by default.
        unmeasured_version: version that may fly it, with a warning.
        complex_items: surveys and scans, until their items change.

    Example:
        >>> home = Geodetic(47.397742, 8.545594, 488.0)
        >>> there = Geodetic(47.398642, 8.545594, 488.0)
        >>> mission = Mission(home, (takeoff(home, 15.0), waypoint(there, 20.0), return_to_launch()))
        >>> mission.altitude_above_home(mission.items[1])
        20.0
        >>> dict(mission.with_parameters({"MPC_XY_CRUISE": 8.0}).parameters)
        {'MPC_XY_CRUISE': 8.0}
    """

    home: Geodetic
    items: tuple[Item, ...]
    autopilot: Autopilot = field(default_factory=default_autopilot)
    cruise_speed: float | None = None
    fence: tuple[FencePolygon | FenceCircle, ...] = ()
    rally: tuple[Geodetic, ...] = ()
    parameters: Parameters = field(default_factory=dict, hash=False)
    vehicle_type: int = QUADROTOR
    vehicle: LearnedVehicle | None = field(default=None, compare=False, repr=False)
    landing_ground: Geodetic | None = field(default=None, compare=False, repr=False)
    firmware_version: Version | None = field(default=None, compare=False, repr=False)
    unmeasured_version: bool = field(default=False, compare=False, repr=False)
    complex_items: tuple[ComplexItem, ...] = field(default=(), compare=False, repr=False)

    @property
    def other_vehicle(self) -> str | None:
        """Return "a plane" or the like; None for a multicopter."""
        return None if self.vehicle_type in MULTICOPTERS else with_article(class_name(self.vehicle_type))

    @property
    def firmware(self) -> Firmware:
        return self.autopilot.firmware(self.firmware_version)

    @property
    def frame(self) -> LocalFrame:
        return LocalFrame(self.home)

    @property
    def complete_parameters(self) -> Parameters:
        return self.autopilot.complete(self.parameters, self.firmware_version)

    def with_parameters(self, parameters: Parameters) -> "Mission":
        """Return the mission with these parameters, which override its own.

        Raises:
            BadInput: one belongs to the other firmware, or is not finite.
        """
        parameters = {name.upper(): value for name, value in parameters.items()}
        expect_own(parameters, self.autopilot)
        for name, value in parameters.items():
            if not math.isfinite(value):
                raise BadInput(f"expected a finite number, not {value}", place=name)
        return self._overridden(self.parameters, parameters) if parameters else self

    def assuming(self, parameters: Parameters) -> "Mission":
        """Return the mission with these parameters where it has none."""
        return self._overridden(parameters, self.parameters) if parameters else self

    def _overridden(self, parameters: Parameters, by: Parameters) -> "Mission":
        return replace(self, parameters=self.autopilot.parameter_table.overridden(parameters, by))

    def altitude_above_home(self, item: Item) -> float:
        """Return an item's altitude over home [m]; NaN over terrain."""
        is_known = plain_frame(item.frame) in (Frame.GLOBAL, Frame.GLOBAL_RELATIVE_ALT)
        return item.height(self.home) if is_known else math.nan


@dataclass(frozen=True)
class MissionFile:
    """A mission file as read.

    Attributes:
        mission: as read.
        findings: faults of the file.
        source: its text.
        suffix: ".plan" or ".waypoints".
        planned: name of the NAME.json written with it, and its flight time [s].
        taken_for: reason for the autopilot of a `.waypoints` file that names none; "": the default one.
    """

    mission: Mission
    findings: tuple[Finding, ...]
    source: str
    suffix: str
    planned: tuple[str, float] | None = None
    taken_for: str | None = None


class Numbered(NamedTuple):
    seq: int
    item: Item

    def __str__(self) -> str:
        return f"item {self.seq} ({self.item.name})"

    def error(self, code: str, message: str, hint: str | None = None, remedies: tuple[Remedy, ...] = ()) -> Finding:
        return Finding(code, Severity.ERROR, self.seq, f"{self}: {message}", hint, remedies)

    def warning(self, code: str, message: str, hint: str | None = None) -> Finding:
        return Finding(code, Severity.WARNING, self.seq, f"{self}: {message}", hint)


def numbered_items(mission: Mission) -> list[Numbered]:
    return [Numbered(seq, item) for seq, item in enumerate(mission.items, start=1)]


def item_of(mission: Mission, seq: int) -> Numbered:
    return Numbered(seq, mission.items[seq - 1])


def _above_home(command: Command, place: Geodetic, height: float, *params: float) -> Item:
    p1, p2, p3, p4 = params
    where = place.latitude_deg, place.longitude_deg, height
    return Item(command, Frame.GLOBAL_RELATIVE_ALT, (p1, p2, p3, p4), *where)


def takeoff(place: Geodetic, height: float) -> Item:
    return _above_home(Command.NAV_TAKEOFF, place, height, 0.0, 0.0, 0.0, math.nan)


def waypoint(place: Geodetic, height: float, hold_s: float = 0.0, radius: float = 0.0) -> Item:
    """PX4 turns within `radius` [m]; 0: NAV_ACC_RAD."""
    return _above_home(Command.NAV_WAYPOINT, place, height, hold_s, radius, 0.0, math.nan)


def spline_waypoint(place: Geodetic, height: float, hold_s: float = 0.0) -> Item:
    """ArduPilot only."""
    return _above_home(Command.NAV_SPLINE_WAYPOINT, place, height, hold_s, 0.0, 0.0, 0.0)


def change_speed(speed: float) -> Item:
    """Use the form that QGroundControl recognizes [m/s]."""
    return Item(Command.DO_CHANGE_SPEED, Frame.MISSION, (1.0, speed, -1.0, 0.0))


def camera_trigger(distance: float, at_once: bool = True) -> Item:
    """Trigger every `distance` [m]; 0: stop."""
    return Item(Command.DO_SET_CAM_TRIGG_DIST, Frame.MISSION, (distance, 0.0, float(at_once), 0.0))


def return_to_launch() -> Item:
    return Item(Command.NAV_RETURN_TO_LAUNCH, Frame.MISSION)


def land(place: Geodetic) -> Item:
    return _above_home(Command.NAV_LAND, place, 0.0, 0.0, 0.0, 0.0, math.nan)


def longest_part(fits: Callable[[int], bool], count: int, guess: int) -> int:
    """Return how many of a mission's `count` legs or lines fit one flight, possibly 0; quick if `guess` is near."""
    fitting = 0
    beyond = count + 1
    tried = guess
    step = 1
    while beyond - fitting > 1:
        tried = min(max(tried, fitting + 1), beyond - 1)
        fitting, beyond = (tried, beyond) if fits(tried) else (fitting, tried)
        if fitting > 0 and beyond <= count:
            tried = (fitting + beyond) // 2
        else:
            tried = fitting + step if beyond > count else beyond - step
        step *= 2
    return fitting
