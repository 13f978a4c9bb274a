import math
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.flight.preflight import idle_fence, other_values
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import ARMED_FLAG, Current, ExtendedState, Heartbeat, Message, Position
from ipoa_mission.link.vehicle_state import NotReady, VehicleState
from ipoa_mission.mission.items import FenceCircle, Mission, return_to_launch, takeoff
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
ARMED, DISARMED = (Heartbeat(2, Autopilot.ARDUPILOT.mav_autopilot, flag | 1, 3) for flag in (ARMED_FLAG, 0))
HIGH = Position(1.0, 47.4, 8.5, 420.0, 20.0, (0.0, 0.0, 0.0))
STATES: dict[str, tuple[list[Message], bool | None, str]] = {
    "nothing": ([], None, "the vehicle has not reported its state"),
    "disarmed": ([DISARMED, HIGH], False, "the vehicle is disarmed, in AUTO"),
    "armed": ([ARMED], None, "the vehicle is armed, perhaps in the air, in AUTO"),
    "landed": ([ARMED, HIGH, ExtendedState(1)], False, "the vehicle is armed, on the ground, in AUTO"),
    "flies": ([ARMED, ExtendedState(2)], True, "the vehicle is armed and in the air, in AUTO: "),
    "high": ([ARMED, HIGH], True, "the vehicle is armed and in the air 20 m above home, in AUTO: "),
    "far": (
        [ARMED, HIGH, Current(3, 9, 3)],
        True,
        "the vehicle is armed and in the air 20 m above home, in AUTO, at item 3: ",
    ),
}


@pytest.mark.parametrize("name", STATES)
def test_a_state_is_told_as_far_as_it_is_known(name: str) -> None:
    messages, in_air, words = STATES[name]
    state = VehicleState(Autopilot.ARDUPILOT)
    for message in messages:
        state.note(message)
    assert state.in_air is in_air
    assert str(state).startswith(words)
    assert words.endswith(": ") or str(state) == words


@pytest.mark.parametrize(
    ("messages", "words"),
    [
        ([], "has not reported its state"),
        ([ARMED], "is armed"),
        ([ARMED, ExtendedState(1)], "is armed, on the ground"),
        ([DISARMED, ExtendedState(2)], "is disarmed, in AUTO, and does not report to be on the ground"),
        ([DISARMED, ExtendedState(4)], "does not report"),
        ([DISARMED], None),
        ([DISARMED, ExtendedState(1)], None),
        ([DISARMED, ExtendedState(0)], None),
        ([ARMED, ExtendedState(4), DISARMED], None),
    ],
)
def test_only_a_disarmed_vehicle_on_the_ground_is_begun_with(messages: list[Message], words: str | None) -> None:
    state = VehicleState(Autopilot.ARDUPILOT)
    for message in messages:
        state.note(message)
    if words is None:
        state.expect_on_ground()
        return
    with refuses("not-on-ground", "", "expected a vehicle disarmed and on the ground", words, kind=NotReady):
        state.expect_on_ground()


def with_parameters(autopilot: Autopilot, values: Mapping[str, float]) -> Any:
    def parameters(wanted: Iterable[str | Sequence[str]]) -> Mapping[str, float]:
        names = [name for entry in wanted for name in ((entry,) if isinstance(entry, str) else entry)]
        return {name: values[name] for name in names if name in values}

    return SimpleNamespace(autopilot=autopilot, parameters=parameters)


def test_a_parameter_is_compared_by_the_name_that_the_vehicle_uses() -> None:
    vehicle = with_parameters(Autopilot.ARDUPILOT, {"WP_SPD": 5.0, "RTL_ALT": 1500.0})
    others, missing = other_values(vehicle, {"WPNAV_SPEED": 750.0, "RTL_ALT_M": 15.0, "WP_JERK": 1.0})
    assert [str(other) for other in others] == ["WP_SPD is 5 on the vehicle, and the mission was made for 7.5"]
    assert missing == ("WP_JERK",)
    assert other_values(vehicle, {}) == ((), ())
    ((value,), _) = other_values(with_parameters(Autopilot.PX4, {"MPC_XY_CRUISE": math.nan}), {"MPC_XY_CRUISE": 5.0})
    assert str(value) == "MPC_XY_CRUISE is nan on the vehicle, and the mission was made for 5"


@pytest.mark.parametrize(("switch", "idle"), [(0.0, True), (1.0, False), (None, False)])
def test_a_fence_that_does_nothing_is_told_of(switch: float | None, idle: bool) -> None:
    fenced = Mission(HOME, (takeoff(HOME, 10.0), return_to_launch()), fence=(FenceCircle((47.4, 8.5), 100.0),))
    vehicle = with_parameters(Autopilot.ARDUPILOT, {} if switch is None else {"FENCE_ENABLE": switch})
    words = (
        "the fence does nothing on this vehicle: its FENCE_ENABLE is 0; "
        "FENCE_TYPE chooses the enabled limits: 4 is this fence alone"
    )
    assert idle_fence(vehicle, fenced) == ((words,) if idle else ())
    assert idle_fence(vehicle, Mission(HOME, fenced.items)) == ()
