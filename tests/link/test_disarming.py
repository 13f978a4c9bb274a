from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.link.departure import depart, prepare
from ipoa_mission.link.dialogue import Cancelled, NoAnswer
from ipoa_mission.link.messages import CommandLong, Message, Text
from ipoa_mission.link.vehicle_state import ON_GROUND, NotReady
from tests.examples import examples
from tests.link.scripted import ARDUPILOT, ARM, PX4, START, Scripted
from tests.refused import refuses


def test_refusal_after_the_arming_disarms_a_vehicle_on_the_ground() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.refuses[START] = (4, "Mode change to AUTO failed: requires position")
    with refuses("command-refused", "", "requires position") as refused:
        vehicle.hold(depart)
    assert vehicle.commands[-1] == (ARM, 0, 0, 0)
    assert not vehicle.armed
    assert refused.value.hint == "the vehicle is disarmed, in GUIDED"


def test_a_mission_that_is_not_begun_disarms_it_too() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey

    def refuse_later(number: int, params: tuple[float, ...]) -> None:
        if number == START:
            vehicle.state.note(Text(2, "Auto: mission not started"))
        else:
            obey(number, params)

    vehicle.obey = refuse_later  # type: ignore[method-assign]
    with refuses("mission-not-begun", "", "GUIDED; it says: Auto: mission not started", kind=NotReady):
        vehicle.hold(depart)
    assert not vehicle.armed


@pytest.mark.parametrize("landed", [None, 2, 3, 4], ids=["untold", "in the air", "taking off", "landing"])
def test_failure_does_not_disarm_a_vehicle_perhaps_in_the_air(landed: int | None) -> None:
    """A plane taken for a copter was ordered to disarm five seconds after its take-off."""
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey

    def into_the_air(number: int, params: tuple[float, ...]) -> None:
        if number == START:
            vehicle.landed = landed
        else:
            obey(number, params)

    vehicle.obey = into_the_air  # type: ignore[method-assign]
    with refuses("mission-not-begun", kind=NotReady):
        vehicle.hold(depart)
    assert (ARM, 0, 0, 0) not in vehicle.commands
    assert vehicle.armed


STATES: list[int | None] = [None, 0, ON_GROUND, 2, 3, 4]


@settings(max_examples=examples(150))
@given(
    st.sampled_from(registered()),
    st.lists(st.sampled_from(STATES), min_size=1, max_size=30),
    st.lists(st.sampled_from([0, 1, 2, 4]), max_size=8),
    st.floats(0.5, 30.0),
    st.floats(0.0, 4.0),
)
def test_a_disarm_is_sent_only_after_the_vehicle_reports_the_ground(
    autopilot: Autopilot, landed: list[int | None], results: list[int], cancel_s: float, climb: float
) -> None:
    vehicle = Scripted(autopilot, first=0 if autopilot is PX4 else 1)
    vehicle.hold(prepare)
    begun, script = vehicle.now, iter(results)
    answer = vehicle.answer

    def fitful(message: Message) -> list[Message]:
        if isinstance(message, CommandLong) and message.command == ARM and message.params[0] == 0.0:
            assert vehicle.state.landed_state == ON_GROUND
            assert vehicle.landed == ON_GROUND  # that was its last word
        vehicle.refuses = {n: (result, "no") for n in (ARM, START) if (result := next(script, 0)) != 0}
        return answer(message)

    def wandering() -> list[Message]:
        vehicle.landed = landed[int((vehicle.now - begun) / 0.75) % len(landed)]
        vehicle.armed |= vehicle.landed in (2, 3)
        return Scripted.stream(vehicle)

    vehicle.answer, vehicle.stream = fitful, wandering  # type: ignore[method-assign]
    with suppress(MissionError):
        vehicle.hold(depart, climb, cancel_s=vehicle.now + cancel_s)


def test_ctrl_c_while_it_is_disarmed_leaves_it_at_that() -> None:
    vehicle = Scripted(PX4, first=0)
    vehicle.hold(prepare)
    vehicle.obey = lambda number, params: None  # type: ignore[method-assign]
    vehicle.landed = None
    begun = vehicle.now
    with pytest.raises(MissionError):
        vehicle.hold(depart)
    late = vehicle.now - begun
    vehicle.state.armed, vehicle.armed = False, False
    with pytest.raises(MissionError):
        vehicle.hold(depart, cancel_s=vehicle.now + late - 1.0)
    assert (ARM, 0) not in [command[:2] for command in vehicle.commands]


def test_ctrl_c_between_arming_and_start_disarms() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey
    vehicle.obey = lambda number, params: None if number == START else obey(number, params)  # type: ignore[method-assign]
    with pytest.raises(Cancelled) as cancelled:
        vehicle.hold(depart, cancel_s=vehicle.now + 2.0)
    assert not vehicle.armed
    assert cancelled.value.hint == "the vehicle is disarmed, in GUIDED"


def test_silent_vehicle_after_arming_is_ordered_to_disarm() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    answer, lost = vehicle.answer, list[Message]()

    def until_armed(message: Message) -> list[Message]:
        if not vehicle.armed:
            return answer(message)
        lost.append(message)
        return []

    vehicle.answer = until_armed  # type: ignore[method-assign]
    with pytest.raises(NoAnswer) as silence:
        vehicle.hold(depart)
    commands = [(message.command, message.params[0]) for message in lost if isinstance(message, CommandLong)]
    assert list(dict.fromkeys(commands)) == [(START, 0.0), (ARM, 0.0)]
    assert commands.count((ARM, 0.0)) == 3
    assert silence.value.hint == "the vehicle is armed, on the ground, in GUIDED"
