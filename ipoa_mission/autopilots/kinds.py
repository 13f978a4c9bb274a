"""What a vehicle is: its firmware and its class, as its heartbeats tell them; and what of that the package flies."""

from dataclasses import dataclass

from ipoa_mission.autopilots.vehicle import Autopilot

QUADROTOR = 2  # MAV_TYPE
#: MAV_TYPE of what hovers on rotors alone: quadrotor, coaxial, helicopter, hexa-, octo-, tri-, dodeca-, decarotor.
MULTICOPTERS = frozenset({QUADROTOR, 3, 4, 13, 14, 15, 29, 35})

_CLASSES = {1: "plane", 5: "antenna tracker", 7: "airship", 8: "balloon", 9: "rocket", 10: "rover", 11: "boat"}
_CLASSES |= {12: "submarine", 16: "flapping wing", 17: "kite", 28: "parafoil"}
_CLASSES |= dict.fromkeys(MULTICOPTERS, "multicopter") | dict.fromkeys(range(19, 26), "VTOL")

#: Of those what takes off from nowhere: rover, boat, submarine.
NO_AIRCRAFT = frozenset({10, 11, 12})

_FIRMWARES = {3: Autopilot.ARDUPILOT, 12: Autopilot.PX4}  # MAV_AUTOPILOT
_NAMES = {Autopilot.ARDUPILOT: "ArduPilot", Autopilot.PX4: "PX4"}


def class_name(mav_type: int) -> str:
    """What a vehicle of this MAV_TYPE is called.

    >>> class_name(1), class_name(13), class_name(18)
    ('plane', 'multicopter', 'vehicle of MAV_TYPE 18')
    """
    return _CLASSES.get(mav_type, f"vehicle of MAV_TYPE {mav_type}")


def with_article(name: str) -> str:
    """A name with "a" or "an" before it.

    >>> with_article("airship"), with_article("PX4 VTOL")
    ('an airship', 'a PX4 VTOL')
    """
    return f"{'an' if name[0] in 'AEIOaeio' else 'a'} {name}"


@dataclass(frozen=True)
class Kind:
    """Firmware (MAV_AUTOPILOT) and class (MAV_TYPE) of a vehicle.

    >>> str(Kind(3, 1)), str(Kind(12, QUADROTOR)), str(Kind(0, QUADROTOR))
    ('ArduPilot plane', 'PX4 multicopter', 'multicopter with another firmware (MAV_AUTOPILOT 0)')
    """

    firmware: int
    mav_type: int

    @property
    def autopilot(self) -> Autopilot:
        """Its family; any other firmware is read as PX4 is, which keeps closest to the specification."""
        return _FIRMWARES.get(self.firmware, Autopilot.PX4)

    @property
    def is_flown(self) -> bool:
        """Whether the package knows how it flies: a multicopter of one of the two families."""
        return self.firmware in _FIRMWARES and self.mav_type in MULTICOPTERS

    def __str__(self) -> str:
        """Both in words."""
        if self.firmware in _FIRMWARES:
            return f"{_NAMES[_FIRMWARES[self.firmware]]} {class_name(self.mav_type)}"
        return f"{class_name(self.mav_type)} with another firmware (MAV_AUTOPILOT {self.firmware})"
