import math

import pytest

from ipoa_mission.vehicles.arducopter.dynamics.legs import Stop, join, speed_left, spline_leg
from ipoa_mission.vehicles.arducopter.dynamics.motion import MotionLimits
from ipoa_mission.vehicles.arducopter.limits import copter_limits

LIMITS = copter_limits({})
SPEEDS = MotionLimits(10.0, 2.5, 1.5)


def test_a_short_spline_after_a_long_first_one_is_entered_slowly() -> None:
    """ArduCopter 4.7: a leg of 23.3 m, then 11.7 m, from rest; it braked from 6.2 to 5.4 m/s."""
    begin, middle, third, beyond = (0.0, 0.0, 10.0), (23.3, 0.0, 10.0), (35.0, 0.0, 10.0), (46.7, 0.0, 10.0)
    this = spline_leg(begin, Stop(middle, True, (third, True)), None, SPEEDS, LIMITS)
    following = spline_leg(middle, Stop(third, True, (beyond, True)), this, SPEEDS, LIMITS)
    first = join(this, following, LIMITS, 0.0).leave
    assert first == pytest.approx(math.sqrt(2 * 1.25 * 11.7), abs=1e-3)
    assert join(this, following, LIMITS, speed_left(following)).leave > first + 2.0
    last = spline_leg(third, Stop(beyond, True), following, SPEEDS, LIMITS)
    assert speed_left(last) == 0.0
