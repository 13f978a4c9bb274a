"""Check ArduCopter's stopping distance: `inv_sqrt_controller` of AP_Math/control.cpp."""

import numpy as np
import pytest

from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter
from ipoa_mission.vehicles.arducopter.limits import copter_limits

LIMITS = copter_limits({"PSC_POSXY_P": 2.0, "WPNAV_ACCEL": 250.0})


@pytest.mark.parametrize(("speed", "distance"), [(0.5, 0.25), (1.0, 0.5), (1.25, 0.625), (5.0, 0.3125 + 5.0)])
def test_stopping_distance_is_linear_below_acceleration_over_gain(speed: float, distance: float) -> None:
    assert float(LIMITS.stopping_distance(speed)) == pytest.approx(distance)
    assert LIMITS.stopping_distance(np.array([speed])) == pytest.approx([distance])


def test_a_slow_copter_stops_within_its_speed_over_the_gain() -> None:
    copter = Copter(LIMITS)
    copter.state.velocity = 0.5 + 0j
    assert copter.stopping_place()[0] == pytest.approx(0.25)
