"""A mission as MAVLink means it: items, fence, rally points, and the home they refer to.

Home is *not* an item here. Whether it stands at sequence 0 on the wire (ArduPilot) or nowhere (PX4) is decided in
`firmware`, and nowhere else.
"""

import math
from dataclasses import dataclass, field, replace

from ipoa_mission.commands import FLOWN_TO, Command, Frame, plain_frame
from ipoa_mission.finding import Finding
from ipoa_mission.vehicles.autopilot import Autopilot, default_autopilot
from ipoa_mission.vehicles.kinds import MULTICOPTERS, QUADROTOR, class_name, with_article
from ipoa_mission.vehicles.known_parameters import expect_own
from ipoa_mission.vehicles.learned import LearnedVehicle
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.version import Version
from ipoa_mission.world.frame import Geodetic
from ipoa_mission.world.ground import LEVEL, Ground


@dataclass(frozen=True)
class Item:
    """One mission item: MAV_CMD, MAV_FRAME, param1 to param4 (NaN: "the autopilot's own"), and param5 to param7.

    `latitude_deg`, `longitude_deg` and `altitude` hold param5, param6 and param7 whatever the command makes of them.
    Items are numbered from 1, as in mission files, and DO_JUMP's param1 is such a number; `firmware` renumbers for PX4.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    altitude: float = 0.0
    autocontinue: bool = True

    @property
    def has_position(self) -> bool:
        """Whether the vehicle flies to this item's latitude and longitude."""
        return (
            self.command in FLOWN_TO
            and self.frame != Frame.MISSION
            and (self.latitude_deg, self.longitude_deg) != (0.0, 0.0)
        )

    def height(self, home: Geodetic) -> float:
        """Its altitude over home [m]; one over terrain is taken as one over home."""
        return self.altitude - home.altitude if plain_frame(self.frame) == Frame.GLOBAL else self.altitude


@dataclass(frozen=True)
class FencePolygon:
    """A geofence polygon: vertices as (latitude, longitude) in degrees, open ring; to stay inside, or outside."""

    vertices: tuple[tuple[float, float], ...]
    inclusion: bool = True


@dataclass(frozen=True)
class FenceCircle:
    """A geofence circle: center as (latitude, longitude) in degrees, radius in metres."""

    center: tuple[float, float]
    radius: float
    inclusion: bool = True


@dataclass(frozen=True)
class Mission:
    """What the vehicle will do. `items[0]` is the first thing done; rally points hold altitudes above home.

    `cruise_speed` [m/s] is what ground stations show in a plan's header; the vehicle obeys DO_CHANGE_SPEED.
    `parameters` are those of the vehicle that differ from its autopilot's defaults, by the autopilot's own names.
    `vehicle_type` is the MAV_TYPE that a `.plan` names, `vehicle` what was learned of the one that flies it,
    and `ground` how high the ground is above home. `firmware_version`: whose tables hold; left out, the newest.
    `findings` are what reading the file had to say, and `source` its text: a mission that was not changed is written
    back as it was. `scanned` has for each structure scan the index of its first item and the height scanned [m], which
    QGroundControl counts as way.

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
    ground: Ground = field(default=LEVEL, compare=False, repr=False)
    firmware_version: Version | None = field(default=None, compare=False, repr=False)
    findings: tuple[Finding, ...] = field(default=(), compare=False, repr=False)
    source: str = field(default="", compare=False, repr=False)
    scanned: tuple[tuple[int, float], ...] = field(default=(), compare=False, repr=False)

    @property
    def other_vehicle(self) -> str | None:
        """What it is for, in words, where that is no multicopter: "a plane"; nobody here flies it."""
        if self.vehicle_type in MULTICOPTERS:
            return None
        return with_article(class_name(self.vehicle_type))

    def with_parameters(self, parameters: Parameters) -> "Mission":
        """The same on a vehicle that has these parameters too; they go before those that it carries.

        Raises:
            BadInput: one of them is the other firmware's.
        """
        expect_own(parameters, self.autopilot)
        return (
            replace(self, parameters=self.autopilot.book.overridden(self.parameters, parameters))
            if parameters
            else self
        )

    def assuming(self, parameters: Parameters) -> "Mission":
        """The same on a vehicle that has these parameters too; those that it carries go before them."""
        return (
            replace(self, parameters=self.autopilot.book.overridden(parameters, self.parameters))
            if parameters
            else self
        )

    def altitude_above_home(self, item: Item) -> float:
        """Altitude of an item over home [m]; NaN where it is given over terrain."""
        match plain_frame(item.frame):
            case Frame.GLOBAL:
                return item.altitude - self.home.altitude
            case Frame.GLOBAL_RELATIVE_ALT:
                return item.altitude
            case _:
                return math.nan


def _above_home(command: Command, place: Geodetic, height: float, *params: float) -> Item:
    first, second, third, fourth = params
    where = place.latitude_deg, place.longitude_deg, height
    return Item(command, Frame.GLOBAL_RELATIVE_ALT, (first, second, third, fourth), *where)


def takeoff(place: Geodetic, height: float) -> Item:
    """Climb to `height` above home at `place`."""
    return _above_home(Command.NAV_TAKEOFF, place, height, 0.0, 0.0, 0.0, math.nan)


def waypoint(place: Geodetic, height: float, hold_s: float = 0.0, radius: float = 0.0) -> Item:
    """Fly straight to `place` at `height` above home, and hold there.

    PX4 turns to the next waypoint within `radius` [m] of this one; 0: NAV_ACC_RAD. ArduCopter does not read it.
    """
    return _above_home(Command.NAV_WAYPOINT, place, height, hold_s, radius, 0.0, math.nan)


def spline_waypoint(place: Geodetic, height: float, hold_s: float = 0.0) -> Item:
    """Fly a smooth curve through `place` (ArduPilot only)."""
    return _above_home(Command.NAV_SPLINE_WAYPOINT, place, height, hold_s, 0.0, 0.0, 0.0)


def change_speed(speed: float) -> Item:
    """Fly at this ground speed from here on [m/s]; the form that QGroundControl recognizes."""
    return Item(Command.DO_CHANGE_SPEED, Frame.MISSION, (1.0, speed, -1.0, 0.0))


def return_to_launch() -> Item:
    """Return to home and land there."""
    return Item(Command.NAV_RETURN_TO_LAUNCH, Frame.MISSION)


def land(place: Geodetic) -> Item:
    """Land at `place`; the altitude is that of home."""
    return _above_home(Command.NAV_LAND, place, 0.0, 0.0, 0.0, 0.0, math.nan)
