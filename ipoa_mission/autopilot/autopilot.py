"""Base class and registry of vehicle plug-ins; `part` finds their implementations of higher rooms' interfaces."""

import re
from abc import ABCMeta, abstractmethod
from collections.abc import Mapping
from functools import cache
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

from ipoa_mission.autopilot import guidance_profile as profile
from ipoa_mission.autopilot import returning
from ipoa_mission.autopilot.failsafe import IN_PLACE, Contingency, Failsafe, FailsafeProfile, OwnFence
from ipoa_mission.autopilot.firmware_tables import Firmware, FirmwareTables, Refusals
from ipoa_mission.autopilot.parameters import Parameters, ParameterTable
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, NotModeled
from ipoa_mission.files import plug_ins

if TYPE_CHECKING:
    from ipoa_mission.geometry import Points, Vector

Part = TypeVar("Part")
_resolved = cache(resolve_name)
STATIONARY_SPEED = 0.1  # [m/s]
QUADROTOR = 2  # MAV_TYPE
#: MAV_TYPE: quadrotor, coaxial, hexa-, octo-, tri-, dodeca-, decarotor.
MULTICOPTERS = frozenset({QUADROTOR, 3, 13, 14, 15, 29, 35})

_CLASSES = {
    1: "plane", 4: "helicopter", 5: "antenna tracker", 7: "airship", 8: "balloon", 9: "rocket", 10: "rover", 11: "boat",
    12: "submarine", 16: "flapping wing", 17: "kite", 28: "parafoil", **dict.fromkeys(MULTICOPTERS, "multicopter"),
    **dict.fromkeys(range(19, 26), "VTOL"),
}  # fmt: skip
#: Rover, boat, submarine.
NO_AIRCRAFT = frozenset({10, 11, 12})


class _ByName(ABCMeta):
    def __getattr__(cls, name: str) -> "Autopilot":
        """Return the registered autopilot of this name in capitals, as `Autopilot.PX4`."""
        if name.isupper() and name.lower() in _registered():
            return _registered()[name.lower()]
        raise AttributeError(f"no autopilot is registered as {name.lower()!r}", name=name, obj=cls)


class Autopilot(metaclass=_ByName):
    """A firmware on one class of vehicle; a singleton, compared by identity.

    Names are stable; methods may change.

    Example:
        >>> Autopilot.PX4.name, str(Autopilot.ARDUPILOT), Autopilot.ARDUPILOT.model
        ('px4', 'ardupilot', 'ArduCopter')
    """

    PX4: ClassVar["Autopilot"]
    ARDUPILOT: ClassVar["Autopilot"]

    name: ClassVar[str]  # in scenarios, files and the command line
    rank: ClassVar[int] = 9  # in lists; the lowest is the default
    model: ClassVar[str]  # its display name
    mav_autopilot: ClassVar[int]  # HEARTBEAT.autopilot (MAV_AUTOPILOT)
    mav_types: ClassVar[frozenset[int]]  # HEARTBEAT.type (MAV_TYPE) of its vehicles
    measured: ClassVar[tuple[Version, ...]]  # verified in flight, oldest first; the last is the default
    modes: ClassVar[profile.Modes]
    parameter_table: ClassVar[ParameterTable]
    tables: ClassVar[FirmwareTables]
    guidance: ClassVar[profile.GuidanceProfile]
    command_effects: ClassVar[profile.CommandEffects] = profile.CommandEffects()
    protocol_profile: ClassVar[profile.ProtocolProfile]
    refusals: ClassVar[Refusals]
    slowed_by: ClassVar[returning.SlowedBy]
    own_fence_by: ClassVar[tuple[str, ...]]  # parameters of the vehicle's own fence
    failsafe_profile: ClassVar[FailsafeProfile] = FailsafeProfile()
    parts: ClassVar[Mapping[str, Any]] = {}  # implementations by interface name: an object or its "module:name"

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"<Autopilot {self.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return autopilot_named, (self.name,)

    def part(self, interface: type[Part]) -> Part:
        """Return this autopilot's implementation of an interface, or raise MissionError."""
        if not self.has(interface):
            raise NotModeled(f"{self.model} has no {re.sub('(?<=[a-z])(?=[A-Z])', ' ', interface.__name__).lower()}")
        address = self.parts[interface.__name__]
        part = _resolved(address) if isinstance(address, str) else address
        assert isinstance(part, interface), f"{address} is no {interface.__name__}"
        return part

    def has(self, interface: type[Any]) -> bool:
        return interface.__name__ in self.parts

    def firmware(self, version: Version | None = None) -> Firmware:
        return self.tables.of(version or self.newest)

    @property
    def parameter_names(self) -> frozenset[str]:
        return self.parameter_table.names | self.failsafe_profile.parameters

    @property
    def firmware_name(self) -> str:
        return self.firmware().name

    @property
    def seq_offset(self) -> int:
        return int(self.firmware().home_is_item_0)

    @abstractmethod
    def braking_distance(self, parameters: Parameters, speed: "Vector", accel: "Vector") -> "Vector":
        """Return the straight distance to a stop (n,) [m] from `speed` [m/s] and `accel` along it [m/s^2]."""

    def braking_delay_s(self, contingency: Contingency) -> float:
        return 0.0 if contingency in IN_PLACE else self.guidance.brakes_after

    def stopping_displacement(
        self, parameters: Parameters, velocity: "Points", accel: "Points", contingency: Contingency
    ) -> "Points":
        """Return the displacement to the stop of velocities and accelerations, (n, 3) each [m].

        By default the vehicle stops along a line, after the braking distance of its horizontal speed.
        """
        import numpy as np

        speed = np.hypot(*velocity[:, :2].T)
        along = (velocity * accel)[:, :2].sum(axis=1) / np.maximum(speed, STATIONARY_SPEED)
        distance = self.braking_distance(parameters, speed, along)
        return np.asarray(velocity * (distance / np.maximum(speed, STATIONARY_SPEED))[:, None])

    @abstractmethod
    def sinking_brake(self, parameters: Parameters) -> returning.SinkingBrake: ...

    def farthest_landing(self, parameters: Parameters, velocity: "Points") -> "Points":
        """Return the displacement (n, 3) [m] to LAND's farthest and lowest stopping point."""
        import numpy as np

        brake = self.sinking_brake(parameters)
        level = velocity * (1.0, 1.0, 0.0)
        late_s = brake.begins_late_s * (1.0 + np.minimum(velocity[:, 2], 0.0) / brake.descent)
        sinks_s = np.hypot(*level[:, :2].T) / brake.accel + brake.settles_s - late_s
        stopped = self.stopping_displacement(parameters, level, 0.0 * level, Contingency.LAND)
        farthest = stopped + brake.overshoots_s * level
        return np.column_stack([farthest[:, :2], -brake.descent * np.maximum(sinks_s, 0.0)])

    def circle(
        self, parameters: Parameters, radius: float, turn: float, speed: float | None, version: Version | None
    ) -> profile.FlownCircle | None:
        """Return the circle flown of NAV_LOITER_TURNS, or None; `radius` > 0 [m], `turn` [rad], most `speed` [m/s]."""
        return None

    @abstractmethod
    def slow_stretch(self, parameters: Parameters) -> returning.SlowStretch | None:
        """Return how LAND slows down; None with a range finder."""

    def slowed(self, parameters: Parameters, ground: float) -> Parameters:
        """Raise the slow landing stretch by the ground's height above home [m]."""
        return self.slowed_by.raised(self.parameter_table, parameters, ground)

    @abstractmethod
    def own_fence(self, parameters: Parameters) -> OwnFence | None:
        """Return the active fence; None: without effect."""

    @abstractmethod
    def return_height(self, parameters: Parameters, height: float, distance: float, goal_up: float = 0.0) -> float:
        """Return the height above home [m] of a return from `height` over a level `distance` to `goal_up`.

        `parameters`: by `complete`.
        """

    @abstractmethod
    def return_route(self, parameters: Parameters, order: returning.ReturnOrder) -> returning.ReturnRoute:
        """Return the route of a return; parameters by their older names."""

    def defaults_of(self, version: Version | None = None) -> Parameters:
        """Return a version's defaults that differ from the parameter table's."""
        return {}

    def known_parameters(self, parameters: Parameters, version: Version | None = None) -> Parameters:
        """Return parameters by their older names, with the version's own defaults."""
        return {**self.defaults_of(version), **self.parameter_table.by_old_names(parameters)}

    def complete(self, parameters: Parameters, version: Version | None = None) -> Parameters:
        return {**self.parameter_table.moving, **self.known_parameters(parameters, version)}

    def assumed_parameters(self, version: Version | None = None) -> dict[str, float]:
        """Return the defaults [MAVLink units] that a forecast, its contingencies and fences use without parameters."""
        others = self.parameter_table.others
        fence = {name: others[name] for name in self.own_fence_by if name in others}
        failsafes = self.failsafe_profile.defaults((version or self.newest).series)
        return {**failsafes, **fence, **self.complete({}, version)}

    def waypoint_defaults(self, version: Version | None = None) -> profile.WaypointDefaults:
        return profile.WaypointDefaults()

    def over_terrain(self, parameters: Parameters) -> returning.OverTerrain | None:
        """Return how a return follows terrain; `return_height` then counts from the ground."""
        return None

    def fence_margin(self, parameters: Parameters, version: Version | None = None) -> float | None:
        """Return a return's distance to fences that it flies around [m]; None: it ignores them."""
        return None

    def failsafes(self, parameters: Parameters, version: Version | None = None) -> tuple[Failsafe, ...]:
        """Return the action for each failure and pilot order; empty: unknown.

        Missing parameters have the firmware's default.

        >>> str(Autopilot.ARDUPILOT.failsafes({"BATT_FS_LOW_ACT": 3.0})[0].action)
        'smart_rtl or rtl or land'
        """
        old = self.parameter_table.by_old_names(parameters)
        return self.failsafe_profile.resolve(old, (version or self.newest).series)

    @property
    def newest(self) -> Version:
        return self.measured[-1]

    def checked_for(self, version: Version | None) -> str:
        major, minor = (version or self.newest).series
        return f"{self.name} {major}.{minor}" + ("" if self.is_measured(version) else " (not measured)")

    def facts(self, version: Version | None) -> dict[str, object]:
        """Return the firmware and its table's source as JSON values."""
        firmware = self.firmware(version)
        return {
            "autopilot": self.name,
            "version": str(version or self.newest),
            "table": f"{firmware.version.major}.{firmware.version.minor}",
            "source": firmware.commit,
            "date": firmware.date,
            "measured": self.is_measured(version),
        }

    def is_measured(self, version: Version | None) -> bool:
        return version is None or version.series in {measured.series for measured in self.measured}

    def not_measured(self, version: Version | None) -> str | None:
        """Return a warning unless flights of this version were measured.

        >>> Autopilot.PX4.not_measured(Version(1, 13))
        'PX4 1.13.0 was not measured in flight: PX4 1.17 and 1.18 were; its items are checked by the tables of PX4 1.15'
        """
        if version is None or self.is_measured(version):
            return None
        words = f"{self.model} {version} was not measured in flight: {self._measured_words()}"
        if version.series in self.tables.series:
            return words
        return f"{words}; its items are checked by the tables of {self.firmware(version)}"

    def beyond_the_model(self, version: str) -> str | None:
        """Return a warning unless a logged version was measured.

        >>> Autopilot.ARDUPILOT.beyond_the_model("3.5.7")
        'flown by ArduCopter 3.5.7, which was not measured: its times may be off; ArduCopter 4.7 and 4.8 were'
        """
        numbers = re.match(r"\d+\.\d+", version)
        if numbers is None:
            return f"the log does not name the version of {self.model}; {self._measured_words()} measured"
        if self.is_measured(Version.parsed(numbers[0])):
            return None
        words = f"flown by {self.model} {version}, which was not measured: its times may be off"
        return f"{words}; {self._measured_words()}"

    def _measured_words(self) -> str:
        series = [f"{version.major}.{version.minor}" for version in self.measured]
        return f"{self.model} {' and '.join(series)} {'were' if len(series) > 1 else 'was'}"


@cache
def _registered() -> dict[str, Autopilot]:
    """Load the vehicle plug-ins. Raise BadInput for one that is no `Autopilot`, or has another one's name."""
    vehicles = dict[str, Autopilot]()
    for entry in plug_ins("vehicles"):
        try:
            vehicle = entry.load()
        except (ImportError, AttributeError) as error:
            raise BadInput(f"the vehicle {entry.name} is registered as {entry.value}, which fails: {error}") from error
        if not isinstance(vehicle, Autopilot):
            raise BadInput(f"the vehicle {entry.name} is registered as {entry.value}, which is no Autopilot")
        if vehicles.setdefault(vehicle.name, vehicle) is not vehicle:
            raise BadInput(f"expected one vehicle {vehicle.name}, not another registered as {entry.value}")
    if not vehicles:
        raise BadInput("no vehicle is registered among the entry points", hint="install ipoa-mission again")
    return dict(sorted(vehicles.items(), key=lambda named: (named[1].rank, named[0])))


def autopilot_names() -> tuple[str, ...]:
    """Return the names of vehicle plug-ins without loading them."""
    return tuple(sorted({entry.name for entry in plug_ins("vehicles")}))


def registered() -> tuple[Autopilot, ...]:
    return tuple(_registered().values())


def default_autopilot() -> Autopilot:
    return registered()[0]


def autopilot_named(name: str) -> Autopilot:
    """Return the autopilot of this name.

    Raises:
        ValueError: it does not exist.

    >>> autopilot_named("px4") is Autopilot.PX4
    True
    """
    if name in _registered():
        return _registered()[name]
    raise ValueError(f"expected {' or '.join(repr(str(vehicle)) for vehicle in registered())}, not {name!r}")


def autopilot_of(mav_autopilot: int, mav_type: int) -> Autopilot | None:
    of_firmware = (vehicle for vehicle in registered() if vehicle.mav_autopilot == mav_autopilot)
    return next((vehicle for vehicle in of_firmware if mav_type in vehicle.mav_types), None)


def class_name(mav_type: int) -> str:
    return _CLASSES.get(mav_type, f"vehicle of MAV_TYPE {mav_type}")


def with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOaeio' else 'a'} {name}"


class VehicleKind(NamedTuple):
    """Firmware (MAV_AUTOPILOT) and class (MAV_TYPE).

    >>> str(VehicleKind(3, 1)), str(VehicleKind(12, QUADROTOR)), str(VehicleKind(0, QUADROTOR))
    ('ArduPilot plane', 'PX4 multicopter', 'multicopter with another firmware (MAV_AUTOPILOT 0)')
    """

    firmware: int
    mav_type: int

    @property
    def autopilot(self) -> Autopilot:
        return autopilot_of(self.firmware, self.mav_type) or self._of_its_firmware or default_autopilot()

    @property
    def is_flown(self) -> bool:
        return autopilot_of(self.firmware, self.mav_type) is not None

    @property
    def _of_its_firmware(self) -> Autopilot | None:
        return next((vehicle for vehicle in registered() if vehicle.mav_autopilot == self.firmware), None)

    def __str__(self) -> str:
        if self._of_its_firmware is not None:
            return f"{self._of_its_firmware.firmware_name} {class_name(self.mav_type)}"
        return f"{class_name(self.mav_type)} with another firmware (MAV_AUTOPILOT {self.firmware})"
