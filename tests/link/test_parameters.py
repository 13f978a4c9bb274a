"""Parameters that a vehicle reports, and keeps."""

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.link import orders
from ipoa_mission.link.dialogue import Dialogue, NoAnswer, Pause, SendOnce, Step
from ipoa_mission.link.messages import ParamSet, ParamValue
from tests.link.suited import met
from tests.refused import refuses


@pytest.mark.parametrize("autopilot", registered())
def test_a_set_parameter_is_kept_and_an_unknown_one_is_an_error(autopilot: Autopilot) -> None:
    vehicle = met(autopilot)
    name = "WPNAV_SPEED" if autopilot is Autopilot.ARDUPILOT else "MPC_XY_CRUISE"
    vehicle.set_parameter(name, 3.0)
    assert vehicle.parameters([name]) == {name: 3.0}
    assert vehicle.parameters([]) == {}
    with refuses("unknown-parameter", "", "NO_SUCH_NAME", kind=NoAnswer):
        vehicle.set_parameter("NO_SUCH_NAME", 1.0)


def test_a_value_that_its_type_has_not_is_bad_input() -> None:
    vehicle = met(Autopilot.PX4)
    with refuses("bad-input", "MPC_YAW_MODE", "32", "1e", "12"):
        vehicle.set_parameter("MPC_YAW_MODE", 1e12)


def setting(value: float) -> Dialogue[None]:
    """Return the dialogue that sets a parameter to 3, where it waits for the result."""
    dialogue = orders.set_parameter("MPC_XY_CRUISE", 3.0, Autopilot.PX4)
    step = next(dialogue)
    while not (isinstance(step, SendOnce) and isinstance(step.message, ParamSet)):
        step = dialogue.send(ParamValue("MPC_XY_CRUISE", value, 9, 1, 0) if isinstance(step, Pause) else None)
    assert isinstance(dialogue.send(None), Pause)
    return dialogue


def hear_nothing(dialogue: Dialogue[None], steps: list[Step]) -> None:
    while True:
        steps.append(dialogue.send(None))


def test_the_other_values_that_a_vehicle_tells_meanwhile_are_no_answer() -> None:
    dialogue = setting(5.0)
    assert dialogue.send(ParamValue("MPC_Z_P", 1.0, 9, 1, 0)) is None
    with pytest.raises(StopIteration):
        dialogue.send(ParamValue("MPC_XY_CRUISE", 3.0, 9, 1, 0))


def test_a_late_answer_to_an_earlier_request_does_not_confirm_a_parameter() -> None:
    dialogue = setting(5.0)
    for _ in range(6):
        assert dialogue.send(ParamValue("MPC_XY_CRUISE", 5.0, 9, 1, 0)) is None
    with pytest.raises(StopIteration):
        dialogue.send(ParamValue("MPC_XY_CRUISE", 3.0, 9, 1, 0))


def test_a_vehicle_that_keeps_a_value_is_asked_again_before_that_is_said() -> None:
    dialogue, steps = setting(5.0), list[Step]()
    dialogue.send(ParamValue("MPC_XY_CRUISE", 5.0, 9, 1, 0))
    with refuses("parameter-kept", "MPC_XY_CRUISE", "3", "5"):
        hear_nothing(dialogue, steps)
    assert sum(isinstance(step, SendOnce) for step in steps) == 2  # besides the first


def test_a_vehicle_that_says_nothing_of_a_parameter_that_is_set_is_silent() -> None:
    dialogue = setting(5.0)
    with refuses("no-answer", "", "MPC_XY_CRUISE"):
        hear_nothing(dialogue, [])
