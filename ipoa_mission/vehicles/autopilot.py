"""What flies: a firmware on one class of vehicle, as one object that every room asks and none names.

What is of the lowest rooms stands here. A higher room (times, tubes, stand-ins) has an interface of its own, and asks
for it by `part`; so a vehicle is one folder, and a new one is a class and a call of `register`.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from ipoa_mission.errors import NotModeled
from ipoa_mission.vehicles.circle import FlownCircle
from ipoa_mission.vehicles.contingency import Contingency
from ipoa_mission.vehicles.failsafe import Failsafe, FailsafeRule, StationLoss
from ipoa_mission.vehicles.firmware_tables import Firmware, FirmwareTables
from ipoa_mission.vehicles.guidance_profile import GuidanceProfile, WaypointDefaults
from ipoa_mission.vehicles.modes import Modes
from ipoa_mission.vehicles.own_fence import OwnFence
from ipoa_mission.vehicles.parameters import Parameters, ParameterTable
from ipoa_mission.vehicles.protocol_profile import ProtocolProfile
from ipoa_mission.vehicles.refusal import Refusals
from ipoa_mission.vehicles.returning import MissionLanding, OverTerrain, Place, ReturnBy, ReturnRoute
from ipoa_mission.vehicles.slow_landing import SlowedBy, SlowStretch
from ipoa_mission.vehicles.version import Version
from ipoa_mission.vehicles.way_known import WayKnown

if TYPE_CHECKING:
    from ipoa_mission.geometry import Points, Vector

Part = TypeVar("Part")
STANDS = 0.1  # who is slower stands [m/s]


class Autopilot(ABC):
    """A firmware on one class of vehicle; there is one object of each, and it is told apart by identity.

    What it answers is asked by the rooms of this package, and may change with them; its names stay.

    Example:
        >>> Autopilot.PX4.name, str(Autopilot.ARDUPILOT), Autopilot.ARDUPILOT.model
        ('px4', 'ardupilot', 'ArduCopter')
    """

    PX4: ClassVar["Autopilot"]
    ARDUPILOT: ClassVar["Autopilot"]

    name: ClassVar[str]
    """As scenarios, files and the command line have it."""
    model: ClassVar[str]
    """Its proper name: the firmware's for this class of vehicle."""
    mav_autopilot: ClassVar[int]
    """HEARTBEAT.autopilot (MAV_AUTOPILOT) of its firmware."""
    mav_types: ClassVar[frozenset[int]]
    """HEARTBEAT.type (MAV_TYPE) of the vehicles that it flies."""
    measured: ClassVar[tuple[Version, ...]]
    """The versions on which flights kept what is promised, oldest first; where none is named, the last is meant."""
    modes: ClassVar[Modes]
    book: ClassVar[ParameterTable]
    tables: ClassVar[FirmwareTables]
    guidance: ClassVar[GuidanceProfile]
    way_known: ClassVar[WayKnown] = WayKnown()
    """Which commands of a mission its model knows the way of."""
    protocol_profile: ClassVar[ProtocolProfile]
    refusals: ClassVar[Refusals]
    """What it says to each item of a list that is uploaded to it."""
    slowed_by: ClassVar[SlowedBy]
    own_fence_by: ClassVar[tuple[str, ...]]
    """All parameters that decide about the fence of its own."""
    failsafe_by: ClassVar[tuple[str, ...]] = ()
    """All parameters that decide what it does when something fails, by their older names."""
    failsafe_rules: ClassVar[tuple[FailsafeRule, ...]] = ()
    """The tables of that, for all versions."""
    station_loss: ClassVar[StationLoss | None] = None
    """When it takes its ground station for lost; None: nobody knows."""
    parts: ClassVar[Mapping[str, Any]] = {}
    """What answers to an interface of a higher room, by the interface's name: the object, or its "module:name"."""

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"<Autopilot {self.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _known, (self.name,)

    def part(self, asked: type[Part]) -> Part:
        """What of this autopilot answers to the interface of a room.

        Raises:
            MissionError: it has no such part, as no model of its flight.
        """
        found = self.parts.get(asked.__name__)
        if found is None:
            raise NotModeled(f"{self.model} has no {asked.__name__} here")
        part = _loaded(found) if isinstance(found, str) else found
        assert isinstance(part, asked), f"{found} is no {asked.__name__}"
        return part

    def has(self, asked: type[Any]) -> bool:
        """Whether it answers to the interface of a room."""
        return asked.__name__ in self.parts

    def firmware(self, version: Version | None = None) -> Firmware:
        """What this version takes in a mission, and what it keeps of it; None: the newest that was measured."""
        return self.tables.of(version or self.newest)

    @property
    def parameter_names(self) -> frozenset[str]:
        """All names that are known: of its book, and of what decides about failsafes."""
        return self.book.names | frozenset(self.failsafe_by)

    @property
    def firmware_name(self) -> str:
        """The firmware's own name."""
        return self.firmware().name

    @property
    def counts_home(self) -> int:
        """The number on the wire of the first item that is flown: home stands before it, or nothing does."""
        return int(self.firmware().home_is_item_0)

    # --- how it flies, by its parameters ----------------------------------------------------------------------------

    @abstractmethod
    def braking_distance(self, parameters: Parameters, speed: "Vector", accel: "Vector") -> "Vector":
        """The way straight on to a stop from `speed` (n,) [m/s], gaining `accel` (n,) [m/s^2], (n,) [m]."""

    def flies_on(self, contingency: Contingency) -> float:
        """For how long it flies on as before once an ending is ordered [s]; it lands and holds at once."""
        return 0.0 if contingency in (Contingency.LAND, Contingency.HOLD) else self.guidance.brakes_after

    def braking_way(
        self, parameters: Parameters, velocity: "Points", accel: "Points", contingency: Contingency
    ) -> "Points":
        """From where it then begins to brake to where that brings it, level, by velocity and acceleration, (n, 2)."""
        import numpy as np

        speed = np.hypot(*velocity.T)
        along = (velocity * accel).sum(axis=1) / np.maximum(speed, STANDS)
        way = self.braking_distance(parameters, speed, along)
        return np.asarray(velocity * (way / np.maximum(speed, STANDS))[:, None])

    def circle(
        self, parameters: Parameters, radius: float, turn: float, speed: float | None, version: Version | None
    ) -> FlownCircle | None:
        """How it flies NAV_LOITER_TURNS; None: it does not.

        A `radius` > 0 m by a turn [rad], at up to a level speed [m/s].
        """
        return None

    @abstractmethod
    def slow_stretch(self, parameters: Parameters) -> SlowStretch | None:
        """How LAND slows down by these parameters; None where a range finder sees to it."""

    def slowed(self, parameters: Parameters, ground: float) -> Parameters:
        """What lets it slow down as high above ground so high above home [m] as these parameters do above home."""
        return self.slowed_by.raised(self.book, parameters, ground)

    @abstractmethod
    def own_fence(self, parameters: Parameters) -> OwnFence | None:
        """The fence that these parameters of a vehicle put into force; None where it has none that does something."""

    @abstractmethod
    def goal_of_return(self, parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
        """Which of the rally points a return from `here` leads to; None: home. Parameters by their older names."""

    @abstractmethod
    def return_height(self, parameters: Parameters, height: float, distance: float, goal_up: float = 0.0) -> float:
        """How high above home it returns from so high above it, over so far, to a goal of the height `goal_up` [m]."""

    def return_route(
        self,
        parameters: Parameters,
        here: Place,
        rally: Sequence[Place],
        landing: MissionLanding | None = None,
        version: Version | None = None,
    ) -> ReturnRoute:
        """Along which way a return from `here` leads, in a mission with or without a landing; None: the measured one.

        Parameters by their older names.
        """
        return ReturnRoute(ReturnBy.DIRECT, self.goal_of_return(parameters, here, rally))

    def defaults_of(self, version: Version | None = None) -> Parameters:
        """Defaults of a version that differ from those of its parameter book."""
        return {}

    def known_parameters(self, parameters: Parameters, version: Version | None = None) -> Parameters:
        """Parameters by their older names, and the version's own defaults of those that are not given."""
        return {**self.defaults_of(version), **self.book.by_old_names(parameters)}

    def complete(self, parameters: Parameters, version: Version | None = None) -> Parameters:
        """All parameters that move a mission, by their older names: those given, else the version's defaults."""
        return {**self.book.moving, **self.known_parameters(parameters, version)}

    def waypoint_defaults(self, version: Version | None = None) -> WaypointDefaults:
        """The hold and the acceptance radius that each waypoint is given."""
        return WaypointDefaults()

    def over_terrain(self, parameters: Parameters) -> OverTerrain | None:
        """How it keeps its height over the ground on its way home; None: it does not.

        `return_height` then counts from the ground.
        """
        return None

    def room_to_fences(self, parameters: Parameters, version: Version | None = None) -> float | None:
        """How far a return keeps from the fences that it flies around [m]; None: it flies straight through them."""
        return None

    def failsafes(self, parameters: Parameters, version: Version | None = None) -> tuple[Failsafe, ...]:
        """What follows all that can fail, and what a pilot can order; version None: the newest measured.

        What is not given has the firmware's default. None at all: nothing is known of it.
        """
        return ()

    # --- its version in words ---------------------------------------------------------------------------------------

    @property
    def newest(self) -> Version:
        """The newest version that was measured."""
        return self.measured[-1]

    def checked_for(self, version: Version | None) -> str:
        """The firmware that is meant, in a few words; None: the newest that was measured.

        >>> Autopilot.PX4.checked_for(Version(1, 16))
        'px4 1.16 (not measured)'
        """
        major, minor = (version or self.newest).series
        return f"{self.name} {major}.{minor}" + ("" if self.is_measured(version) else " (not measured)")

    def facts(self, version: Version | None) -> dict[str, object]:
        """The same for machines, with the source that the table was read in."""
        own = self.firmware(version)
        return {
            "autopilot": self.name,
            "version": str(version or self.newest),
            "table": f"{own.version.major}.{own.version.minor}",
            "source": own.commit,
            "date": own.date,
            "measured": self.is_measured(version),
        }

    def is_measured(self, version: Version | None) -> bool:
        """Whether flights of its series were measured; None: the newest that was."""
        return version is None or version.series in {one.series for one in self.measured}

    def not_measured(self, version: Version | None) -> str | None:
        """Why nothing stands behind a flight of this version, in words; None where something does.

        >>> Autopilot.PX4.not_measured(Version(1, 13))
        'how PX4 1.13.0 flies was not measured: PX4 1.17 and 1.18 were; what it takes is judged as PX4 1.15 does'
        """
        if version is None or self.is_measured(version):
            return None
        words = f"how {self.model} {version} flies was not measured: {self._measured_words()}"
        if version.series in self.tables.series:
            return words
        return f"{words}; what it takes is judged as {self.firmware(version)} does"

    def beyond_the_model(self, version: str) -> str | None:
        """What to say of times that are estimated for a version in a log; None where it was measured.

        >>> Autopilot.ARDUPILOT.beyond_the_model("3.5.7")
        'flown by ArduCopter 3.5.7, which was not measured: its times may be off; ArduCopter 4.7 and 4.8 were'
        """
        numbers = re.match(r"\d+\.\d+", version)
        if numbers is None:
            return f"the log does not say which {self.model} flew it; {self._measured_words()} measured"
        if self.is_measured(Version.parsed(numbers[0])):
            return None
        words = f"flown by {self.model} {version}, which was not measured: its times may be off"
        return f"{words}; {self._measured_words()}"

    def _measured_words(self) -> str:
        series = [f"{one.major}.{one.minor}" for one in self.measured]
        return f"{self.model} {' and '.join(series)} {'were' if len(series) > 1 else 'was'}"


_REGISTERED: dict[str, Autopilot] = {}


def register(autopilot: Autopilot) -> Autopilot:
    """Make an autopilot known to every room; the first that was registered is taken where nobody names one."""
    return _REGISTERED.setdefault(autopilot.name, autopilot)


def registered() -> tuple[Autopilot, ...]:
    """All that are known, in the order in which they were registered."""
    return tuple(_REGISTERED.values())


def default_autopilot() -> Autopilot:
    """The one that is taken where nobody names one."""
    return registered()[0]


def autopilot_named(name: str) -> Autopilot:
    """The autopilot that scenarios and files call so.

    Raises:
        ValueError: there is none, with those that there are.

    >>> autopilot_named("px4") is Autopilot.PX4
    True
    """
    if name in _REGISTERED:
        return _REGISTERED[name]
    raise ValueError(f"expected {' or '.join(repr(str(one)) for one in registered())}, not {name!r}")


def autopilot_of(mav_autopilot: int, mav_type: int) -> Autopilot | None:
    """The one with this firmware and class; None where none is registered."""
    return next((one for one in registered() if one.mav_autopilot == mav_autopilot and mav_type in one.mav_types), None)


def _known(name: str) -> Autopilot:
    return _REGISTERED[name]


@cache
def _loaded(address: str) -> Any:
    module, _, name = address.partition(":")
    return getattr(import_module(module), name)
