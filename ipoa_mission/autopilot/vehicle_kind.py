"""Firmware and class of a vehicle, by MAV_AUTOPILOT and MAV_TYPE."""

from typing import NamedTuple

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_of, default_autopilot, registered

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


def class_name(mav_type: int) -> str:
    return _CLASSES.get(mav_type, f"vehicle of MAV_TYPE {mav_type}")


def with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOaeio' else 'a'} {name}"


class VehicleKind(NamedTuple):
    """Firmware (MAV_AUTOPILOT) and class (MAV_TYPE).

    >>> from ipoa_mission.autopilot.vehicle_kind import QUADROTOR
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
