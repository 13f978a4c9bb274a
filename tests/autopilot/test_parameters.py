import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered


@pytest.mark.parametrize(
    ("parameters", "name", "value"),
    [
        ({"WPNAV_SPEED": 1234.0}, "WPNAV_SPEED", 12.34),  # [cm/s]
        ({"WP_SPD": 12.34}, "WPNAV_SPEED", 12.34),
        ({"LAND_SPEED": 57.0}, "LAND_SPEED", 0.57),
        ({"RTL_LOIT_TIME": 1234.0}, "RTL_LOIT_TIME", 1.234),  # [ms]
        ({"PSC_JERK_XY": 7.0}, "PSC_JERK_XY", 7.0),
    ],
)
def test_arducopter_s_parameters_are_exact_in_si_units(parameters: dict[str, float], name: str, value: float) -> None:
    """0.01 times 57 is 0.5700000000000001."""
    assert Autopilot.ARDUPILOT.parameter_table.si(parameters)[name] == value


@pytest.mark.parametrize("autopilot", registered())
def test_a_raised_slow_stretch_begins_higher_by_the_ground(autopilot: Autopilot) -> None:
    stretch, raised = (autopilot.slow_stretch(values) for values in ({}, autopilot.slowed({}, 12.0)))
    assert stretch is not None
    assert raised is not None
    assert (raised.begins, raised.ends) == (stretch.begins + 12.0, stretch.ends + 12.0)
