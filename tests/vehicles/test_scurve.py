import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.vehicles.arducopter.dynamics.legs import limits_along, straight_leg
from ipoa_mission.vehicles.arducopter.dynamics.motion import NO_LEG, MotionLimits
from ipoa_mission.vehicles.arducopter.dynamics.scurve import Profile, SCurveLimits, change, profile, ramp_for
from ipoa_mission.vehicles.arducopter.dynamics.shaping import along
from ipoa_mission.vehicles.arducopter.limits import copter_limits
from tests.examples import examples

lengths = st.floats(0.01, 500.0)
limits = st.builds(SCurveLimits, st.floats(0.5, 20.0), st.floats(0.5, 6.0), st.floats(0.5, 10.0), st.floats(2.0, 60.0))


def sampled(shape: Profile, length: float, count: int = 400) -> np.ndarray:
    """Return acceleration, speed and way at even moments, by the flight code."""
    leg = NO_LEG._replace(length=length, profile=shape)
    return np.array([along(leg, t) for t in np.linspace(1e-9, shape.lasts * (1 - 1e-9), count)])


@given(lengths, limits)
def test_a_leg_ends_at_rest_where_it_should_within_its_limits(length: float, limit: SCurveLimits) -> None:
    shape = profile(length, limit)
    accel, speed, way = sampled(shape, length).T
    assert way[-1] == pytest.approx(length, rel=1e-5, abs=1e-6)
    assert speed[-1] == pytest.approx(0.0, abs=1e-3 * limit.speed)
    assert np.all(np.diff(way) >= -1e-9)
    assert speed.max() <= limit.speed * (1 + 1e-9)
    assert np.abs(accel).max() <= limit.accel * (1 + 1e-6)
    assert np.abs(np.gradient(accel, shape.lasts / 399)).max() <= limit.jerk * 1.02 + 1e-6


@settings(max_examples=examples(8))
@given(st.floats(0.5, 40.0), limits)
def test_way_speed_and_acceleration_are_derivatives_of_each_other(length: float, limit: SCurveLimits) -> None:
    shape = profile(length, limit)
    accel, speed, way = sampled(shape, length, 1500).T
    dt = shape.lasts * (1 - 2e-9) / 1499
    assert np.cumsum((speed[1:] + speed[:-1]) / 2 * dt)[-1] == pytest.approx(way[-1], rel=1e-3)
    assert np.abs(np.cumsum((accel[1:] + accel[:-1]) / 2 * dt) - speed[1:]).max() < 1e-2 * shape.peak + 1e-6


@pytest.mark.parametrize(
    ("gain", "expected"),
    [
        (10.0, 10 / 2.5 + 2.5 / 1 + 0.3),  # V/a + a/J + t_j
        (2.0, 2 * ((math.sqrt(0.09 + 8.0) - 0.3) / 2) + 0.6),  # 2 a_p/J + 2 t_j
        (0.01, 4 * (math.pi * 0.01 / (4 * math.pi / 0.6)) ** (1 / 3)),  # 4 t_j, t_j = (pi V/4S)^(1/3)
    ],
)
def test_the_time_to_a_speed_is_the_published_one(gain: float, expected: float) -> None:
    """Acceleration 2.5, jerk 1, ramps of 0.3 s (snap pi J / 2 t_j): ArduCopter's defaults."""
    assert ramp_for(gain, SCurveLimits(12.0, 2.5, 1.0, math.pi / 0.6)).lasts == pytest.approx(expected)


def test_a_twelve_meter_leg_crawls_whatever_speed_is_asked_for() -> None:
    limit = SCurveLimits(12.0, 2.5, 1.0, math.pi / 0.6)
    assert profile(12.0, limit).peak == pytest.approx(3.1, abs=0.1)
    assert profile(12.0, SCurveLimits(20.0, 2.5, 1.0, math.pi / 0.6)).lasts == profile(12.0, limit).lasts


@given(lengths, limits)
def test_a_leg_entered_at_a_speed_has_its_length_and_less_time(length: float, limit: SCurveLimits) -> None:
    rest = profile(length, limit)
    moving = profile(length, limit, enter=rest.peak / 2)
    assert sampled(moving, length)[-1, 2] == pytest.approx(length, rel=1e-4, abs=1e-5)
    assert moving.peak <= rest.peak * (1 + 1e-9)
    ramp = limit.jerk * math.pi / (2 * limit.snap)  # taken whole by a change of speed, however small
    if moving.peak == rest.peak and rest.peak / 2 > 2 * limit.jerk * ramp**2:
        assert moving.lasts < rest.lasts * (1 + 1e-9)


@pytest.mark.parametrize("speed", [3.0, 6.0, 9.0, 12.0])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.3, 0.6])
def test_a_speed_changed_on_the_way_still_ends_where_it_should(speed: float, share: float) -> None:
    limit = SCurveLimits(8.0, 2.5, 1.0, math.pi / 0.6)
    shape = profile(120.0, limit)
    changed = change(shape, share * shape.lasts, 120.0, SCurveLimits(speed, 2.5, 1.0, math.pi / 0.6))
    accel, flown, distance = sampled(changed, 120.0).T
    assert distance[-1] == pytest.approx(120.0, rel=1e-5)
    assert np.abs(accel).max() < 2.5 * (1 + 1e-6)
    if speed < 8.0:
        assert (np.abs(flown - speed) < 0.01 * speed).sum() > 3, "it flies at the new speed for a while"
    else:
        assert flown.max() == pytest.approx(speed if share < 0.5 and speed < 12 else 8.0, rel=0.5)


def test_a_climbing_leg_keeps_the_climb_rate() -> None:
    copter = copter_limits({})
    ends, speeds = ((0.0, 0.0, 10.0), (30.0, 40.0, 60.0)), MotionLimits(10.0, 2.5, 1.5)
    assert limits_along(*ends, speeds, copter).speed == pytest.approx(2.5 * math.sqrt(2))
    assert straight_leg(*ends, speeds, copter).length == pytest.approx(math.hypot(50.0, 50.0))
