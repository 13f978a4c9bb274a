from dataclasses import dataclass

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_of, default_autopilot, registered
from ipoa_mission.autopilot.mav_types import class_name


@dataclass(frozen=True)
class Kind:
    """Firmware (MAV_AUTOPILOT) and class (MAV_TYPE).

    >>> from ipoa_mission.autopilot.mav_types import QUADROTOR
    >>> str(Kind(3, 1)), str(Kind(12, QUADROTOR)), str(Kind(0, QUADROTOR))
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
        return next((one for one in registered() if one.mav_autopilot == self.firmware), None)

    def __str__(self) -> str:
        if self._of_its_firmware is not None:
            return f"{self._of_its_firmware.firmware_name} {class_name(self.mav_type)}"
        return f"{class_name(self.mav_type)} with another firmware (MAV_AUTOPILOT {self.firmware})"
