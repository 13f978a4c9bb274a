"""From the ground into the mission: nothing is armed too early, and what fails after the arming disarms again."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.errors import MissionError
from ipoa_mission.link.departure import Departure, NotYet, depart, depart_when_ready, prepare
from ipoa_mission.link.dialogue import SPECIFIED, Cancelled, Dialogue, Exchange, NoAnswer, TimeUp
from ipoa_mission.link.messages import (
    ARMED_FLAG,
    CommandAck,
    CommandLong,
    Current,
    Heartbeat,
    Message,
    SetCurrent,
    Text,
)
from ipoa_mission.link.orders import CommandRefused
from ipoa_mission.link.state import ON_GROUND, PREARM_CHECK, NotFlown, NotReady, VehicleState
from ipoa_mission.link.telemetry import ExtendedState, Position, SystemStatus
from ipoa_mission.vehicles.autopilot import Autopilot, registered
from ipoa_mission.vehicles.kind import Kind
from tests.examples import examples

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
TAKEOFF, SET_MODE, SET_CURRENT, START, ARM, RUN_PREARM_CHECKS, STREAM = 22, 176, 224, 300, 400, 401, 511


class Scripted:
    """A vehicle that does as it is told, but for what a test changes; `told` is what it was told, in order."""

    def __init__(self, autopilot: Autopilot, first: int = 1) -> None:
        self.autopilot = autopilot
        self.first = first
        self.mode, self.armed, self.height, self.current = 0, False, 0.0, 5
        self.ready_s, self.streams = 0.0, True
        self.landed: int | None = ON_GROUND  # None: it does not tell
        self.refuses: dict[int, tuple[int, str]] = {}
        self.told: list[tuple[int, ...]] = []
        self.state = VehicleState(autopilot)
        self.now = 0.0

    def hold(
        self,
        make: Callable[[Departure], Dialogue[None]],
        climb: float = 0.0,
        cancel_s: float = 1e9,
        cancel: MissionError | None = None,
    ) -> None:
        """A dialogue with it, on a virtual clock; it streams four times a second."""
        exchange = Exchange(make(Departure(self.state, self.first, self.first + 1, climb)), self.now, SPECIFIED)
        while not exchange.finished:
            heard = [answer for message in exchange.outgoing() for answer in self.answer(message)]
            self.now += 0.25
            for message in [*heard, *self.stream()]:
                self.state.note(message)
                exchange.receive(message, self.now)
            exchange.tick(self.now)
            if self.now >= cancel_s:
                cancel_s = 1e9
                exchange.interrupt(cancel or Cancelled("cancelled"), self.now)

    def stream(self) -> list[Message]:
        beat = Heartbeat(2, 3, ARMED_FLAG if self.armed else 0, self.mode)
        if not self.streams:
            return [beat]
        placed = self.now >= self.ready_s
        position = Position(self.now, 47.4 * placed, 8.5 * placed, 400.0, self.height)
        ready = PREARM_CHECK * placed
        told: list[Message] = [beat, position, Current(self.current)]
        if self.landed is not None:
            told.append(ExtendedState(self.landed))
        return [*told, SystemStatus(PREARM_CHECK, PREARM_CHECK, ready)]

    def answer(self, message: Message) -> list[Message]:
        if isinstance(message, SetCurrent):
            self.current = message.seq
        if not isinstance(message, CommandLong):
            return []
        number, params = message.command, message.params
        if number != STREAM:
            self.told.append((number, *(int(p) for p in params[:3])))
        if number == ARM and params[0] == 0.0:
            self.armed = False
            return [CommandAck(ARM, 0)]
        if number in self.refuses:
            result, words = self.refuses[number]
            return [CommandAck(number, result), Text(2, words)]
        self.obey(number, params)
        return [CommandAck(number, 0)]

    def obey(self, number: int, params: tuple[float, ...]) -> None:
        match number:
            case 176:
                sub = int(params[2])
                self.mode = int(params[1]) if self.autopilot is ARDUPILOT else int(params[1]) << 16 | sub << 24
            case 224:
                self.current = int(params[0])
            case 400:
                self.armed = True
            case 300:
                self.mode = self.autopilot.modes.mission
            case 22:
                self.height = params[6]


def test_each_firmware_is_prepared_and_started_in_its_own_order() -> None:
    copter, px4 = Scripted(ARDUPILOT), Scripted(PX4, first=0)
    for vehicle in (copter, px4):
        vehicle.hold(prepare)
        assert not vehicle.armed
        assert vehicle.current == vehicle.first
        assert vehicle.mode == vehicle.autopilot.modes.arming
        vehicle.hold(depart)
        assert vehicle.armed
        assert vehicle.mode == vehicle.autopilot.modes.mission
    assert [told[0] for told in copter.told] == [SET_CURRENT, SET_MODE, SET_CURRENT, ARM, START]
    assert [told[0] for told in px4.told] == [SET_CURRENT, SET_MODE, SET_CURRENT, ARM]
    assert copter.told[0] == (SET_CURRENT, 1, 1, 0)  # jumps are counted anew


def test_items_done_at_once_may_stand_before_the_one_that_is_current() -> None:
    """ArduCopter, set to a DO item, calls the item behind it current."""
    vehicle = Scripted(ARDUPILOT)
    obey = vehicle.obey
    vehicle.obey = lambda number, params: obey(number, tuple(p + (number == SET_CURRENT) for p in params))  # type: ignore[method-assign]
    vehicle.hold(prepare)
    assert vehicle.current == 2


def test_the_older_message_sets_the_current_item_where_the_command_is_unknown() -> None:
    vehicle = Scripted(PX4, first=0)
    vehicle.refuses[SET_CURRENT] = (3, "")
    vehicle.hold(prepare)
    assert vehicle.current == 0


def test_a_vehicle_without_a_position_is_waited_for() -> None:
    vehicle = Scripted(ARDUPILOT)
    said: list[str] = []
    vehicle.ready_s = 40.0
    vehicle.hold(lambda departure: prepare(replace(departure, progress=lambda share, words: said.append(words))))
    assert 40.0 <= vehicle.now < 50.0
    assert said
    assert ARM not in [told[0] for told in vehicle.told]


def test_one_that_does_not_become_ready_is_an_error_with_its_own_reason() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.refuses[SET_MODE] = (4, "Mode change to GUIDED failed: requires position")
    with pytest.raises(
        NotReady, match=r"not ready after 3. s: Mode change to GUIDED failed: requires position"
    ) as late:
        vehicle.hold(lambda departure: prepare(departure, ready_s=30.0))
    assert late.value.hint == "the vehicle is disarmed, in STABILIZE"


def test_what_waiting_does_not_mend_is_not_waited_for() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.ready_s = 1e9
    vehicle.refuses[RUN_PREARM_CHECKS] = (4, "PreArm: Hardware safety switch")
    with pytest.raises(NotReady, match="cannot be armed: PreArm: Hardware safety switch"):
        vehicle.hold(prepare)
    assert vehicle.now < 20.0
    assert ARM not in [told[0] for told in vehicle.told]


@pytest.mark.parametrize("autopilot", registered())
def test_an_armed_vehicle_is_left_alone(autopilot: Autopilot) -> None:
    vehicle = Scripted(autopilot)
    vehicle.armed = True
    with pytest.raises(NotReady, match="begins disarmed and on the ground, but the vehicle is armed"):
        vehicle.hold(prepare)
    assert vehicle.told == []


def test_a_vehicle_that_does_not_stream_is_not_flown() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.streams = False
    vehicle.refuses[STREAM] = (3, "")
    with pytest.raises(NotReady, match="does not send GLOBAL_POSITION_INT, MISSION_CURRENT, SYS_STATUS; it refused"):
        vehicle.hold(prepare)


def test_a_mission_that_stands_elsewhere_is_not_begun() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.obey = lambda number, params: None  # type: ignore[method-assign]
    with pytest.raises(NotReady, match="set to begin at item 1, but it stands at item 5"):
        vehicle.hold(prepare)


def test_what_is_refused_after_the_arming_disarms_a_vehicle_on_the_ground() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.refuses[START] = (4, "Mode change to AUTO failed: requires position")
    with pytest.raises(CommandRefused, match=r"start the mission: .*requires position") as refused:
        vehicle.hold(depart)
    assert vehicle.told[-1] == (ARM, 0, 0, 0)
    assert not vehicle.armed
    assert refused.value.hint == "the vehicle is disarmed, in GUIDED"


def test_a_mission_that_is_not_begun_disarms_it_too() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey
    vehicle.obey = lambda number, params: None if number == START else obey(number, params)  # type: ignore[method-assign]
    with pytest.raises(NotReady, match="did not begin its mission: the vehicle is armed, on the ground, in GUIDED"):
        vehicle.hold(depart)
    assert not vehicle.armed


@pytest.mark.parametrize(("words", "times"), [("Arming denied: high throttle", 1), ("", 5)])
def test_an_arming_that_is_refused_for_good_is_an_error(words: str, times: int) -> None:
    """One that gives no reason is asked some times more: a link may have lost it."""
    vehicle = Scripted(PX4, first=0)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (1, words)
    with pytest.raises(CommandRefused, match=f"arm: .*{words}") as refused:
        vehicle.hold(depart)
    assert not isinstance(refused.value, NotYet)
    assert [told[:2] for told in vehicle.told if told[0] == ARM] == [(ARM, 1)] * times


@pytest.mark.parametrize("autopilot", registered())
def test_an_arming_that_is_refused_for_what_passes_may_be_tried_again(autopilot: Autopilot) -> None:
    vehicle = Scripted(autopilot, first=0 if autopilot is PX4 else 1)
    vehicle.hold(prepare)
    reason = "Preflight Fail: GPS fix too low" if autopilot is PX4 else "Arm: Need Position Estimate"
    vehicle.refuses[ARM] = (4, reason)
    with pytest.raises(NotYet, match=reason) as refused:
        vehicle.hold(depart)
    assert refused.value.words == reason
    assert [told[:2] for told in vehicle.told if told[0] == ARM] == [(ARM, 1)]
    vehicle.refuses.clear()
    vehicle.hold(prepare)
    vehicle.hold(depart)
    assert vehicle.armed


@pytest.mark.parametrize(("tries", "passes_s"), [(1, 0.0), (3, 20.0)])
def test_it_is_tried_again_while_there_is_time(tries: int, passes_s: float) -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (4, "Arm: Need Position Estimate")
    until_s = vehicle.now + passes_s
    with pytest.raises(NotReady, match="not ready in time: Arm: Need Position Estimate"):
        vehicle.hold(lambda departure: depart_when_ready(departure, lambda: until_s - vehicle.now))
    assert [told[:2] for told in vehicle.told if told[0] == ARM] == [(ARM, 1)] * tries
    assert vehicle.now >= until_s


@pytest.mark.parametrize("landed", [None, 2, 3, 4], ids=["untold", "in the air", "taking off", "landing"])
def test_what_fails_is_not_disarmed_where_it_may_be_in_the_air(landed: int | None) -> None:
    """A plane that was taken for a copter went off into the air, and five seconds later was told to disarm."""
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey

    def into_the_air(number: int, params: tuple[float, ...]) -> None:
        if number == START:
            vehicle.landed = landed
        else:
            obey(number, params)

    vehicle.obey = into_the_air  # type: ignore[method-assign]
    with pytest.raises(NotReady, match="did not begin its mission"):
        vehicle.hold(depart)
    assert (ARM, 0, 0, 0) not in vehicle.told
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
def test_a_disarm_follows_the_vehicle_s_own_word_that_it_stands_on_the_ground(
    autopilot: Autopilot, landed: list[int | None], results: list[int], cancel_s: float, climb: float
) -> None:
    """Whatever it answers, and wherever it says that it is, second by second: never a disarm in the air."""
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


def test_what_was_refused_late_and_is_armed_all_the_same_is_begun() -> None:
    """The answer heard is that to an order given before; the last one was taken."""
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    answer = vehicle.answer

    def late(message: Message) -> list[Message]:
        if isinstance(message, CommandLong) and message.command == ARM:
            vehicle.obey(ARM, message.params)
            return [CommandAck(ARM, 1)]
        return answer(message)

    vehicle.answer = late  # type: ignore[method-assign]
    vehicle.hold(depart)
    assert vehicle.mode == ARDUPILOT.modes.mission


@pytest.mark.parametrize("mav_type", [1, 10, 12, 20])
def test_what_is_no_multicopter_is_neither_prepared_nor_armed(mav_type: int) -> None:
    vehicle = Scripted(ARDUPILOT)
    told_by = vehicle.stream

    def stream() -> list[Message]:
        return [replace(one, type=mav_type) if isinstance(one, Heartbeat) else one for one in told_by()]

    vehicle.stream = stream  # type: ignore[method-assign]
    with pytest.raises(NotFlown, match="the vehicle is an ArduPilot"):
        vehicle.hold(prepare)
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.state.kind = Kind(3, mav_type)
    told = len(vehicle.told)
    with pytest.raises(NotFlown):
        vehicle.hold(depart)
    assert len(vehicle.told) == told


def test_time_that_is_up_before_it_is_ready_says_what_hinders() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.refuses[SET_MODE] = (4, "Battery 1 below minimum arming voltage")
    exchange_ends = TimeUp("the time is up")
    with pytest.raises(TimeUp, match="the time is up: the vehicle is not ready: Battery 1 below minimum"):
        vehicle.hold(prepare, cancel_s=20.0, cancel=exchange_ends)
    placeless = Scripted(ARDUPILOT)
    placeless.ready_s = 1e9
    with pytest.raises(TimeUp, match="the vehicle is not ready: it has no position"):
        placeless.hold(prepare, cancel_s=4.0, cancel=exchange_ends)
    with pytest.raises(NotReady, match="it has no position"):
        placeless.hold(prepare)
    warned = Scripted(ARDUPILOT)
    warned.ready_s = 1e9
    warned.refuses[RUN_PREARM_CHECKS] = (4, "PreArm: Compass not calibrated")
    with pytest.raises(NotReady, match="PreArm: Compass not calibrated"):
        warned.hold(lambda departure: prepare(departure, ready_s=5.0))


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
    assert (ARM, 0) not in [told[:2] for told in vehicle.told]


def test_a_stream_that_does_not_come_is_asked_for_again() -> None:
    """The answer that was heard was to another request: the vehicle never heard this one."""
    vehicle = Scripted(ARDUPILOT)
    answer, asked = vehicle.answer, 0
    vehicle.streams = False

    def deaf(message: Message) -> list[Message]:
        nonlocal asked
        if isinstance(message, CommandLong) and message.command == STREAM:
            asked += 1
            vehicle.streams = asked > 5
        return answer(message)

    vehicle.answer = deaf  # type: ignore[method-assign]
    vehicle.hold(prepare)
    assert asked > 5


def test_ctrl_c_between_arming_and_start_disarms() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey
    vehicle.obey = lambda number, params: None if number == START else obey(number, params)  # type: ignore[method-assign]
    with pytest.raises(Cancelled) as cancelled:
        vehicle.hold(depart, cancel_s=vehicle.now + 2.0)
    assert not vehicle.armed
    assert cancelled.value.hint == "the vehicle is disarmed, in GUIDED"


def test_an_ardupilot_that_begins_with_a_waypoint_climbs_first() -> None:
    vehicle = Scripted(ARDUPILOT, first=4)
    vehicle.hold(prepare)
    vehicle.hold(depart, climb=20.0)
    assert [told[0] for told in vehicle.told][-3:] == [ARM, TAKEOFF, START]
    assert vehicle.height == 20.0


def test_a_vehicle_that_answers_nothing_after_the_arming_is_told_to_disarm_all_the_same() -> None:
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
    told = [(one.command, one.params[0]) for one in lost if isinstance(one, CommandLong)]
    assert list(dict.fromkeys(told)) == [(START, 0.0), (ARM, 0.0)]
    assert told.count((ARM, 0.0)) == 3
    assert silence.value.hint == "the vehicle is armed, on the ground, in GUIDED"


def test_an_arming_that_is_refused_at_first_without_a_reason_is_tried_again() -> None:
    vehicle = Scripted(PX4, first=0)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (1, "")
    told = vehicle.stream

    def calmer() -> list[Message]:
        if sum(number == ARM for number, *_ in vehicle.told) == 2:
            vehicle.refuses.clear()
        return told()

    vehicle.stream = calmer  # type: ignore[method-assign]
    vehicle.hold(depart)
    assert vehicle.armed
    assert [number for number, *_ in vehicle.told].count(ARM) == 3
