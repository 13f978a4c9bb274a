import contextlib
import itertools
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import FrameType

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.interrupts import noted_interrupts, noted_terminations, terminations
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection, run_dialogue
from ipoa_mission.link.dialogue import SPECIFIED, Cancelled, Dialogue, Pause, RoundTrip
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.mission.items import FenceCircle, Item, Mission, takeoff, waypoint
from ipoa_mission.mission.stored_mission import compare
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Faults, Loopback, Station
from tests.examples import some
from tests.link_pair import HOME, items_of
from tests.refused import refuses

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
SLOW = Faults(delay_s=0.02)
MOMENTS = 12


@pytest.fixture(autouse=True)
def _python_s_own_handler() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def press() -> None:
    signal.raise_signal(signal.SIGINT)


def _press_at(moment: int, number: int) -> None:
    if number == moment:
        press()


def aboard(family: Autopilot, fast: bool = False) -> tuple[Connection, Mock, Callable[[tuple[Item, ...]], None]]:
    mock = Mock(family, HOME)
    connection = Connection(Loopback(Station(mock), SLOW), Codec(245, 190))
    vehicle = meet(connection, options=ConnectionOptions(fast=fast))
    return connection, mock, lambda items: vehicle.upload_items(items, MissionType.MISSION)


@contextlib.contextmanager
def each_instruction(act: Callable[[int], None]) -> Iterator[None]:
    """Call `act` with a number before each instruction of the link."""
    done = 0

    def trace(frame: FrameType, event: str, argument: object) -> object:
        nonlocal done
        if "ipoa_mission/link/" not in frame.f_code.co_filename.replace("\\", "/"):
            return None
        frame.f_trace_opcodes = True
        if event == "opcode":
            done += 1
            act(done)
        return trace

    before = sys.gettrace()
    sys.settrace(trace)  # type: ignore[arg-type]
    try:
        yield
    finally:
        sys.settrace(before)


@pytest.mark.parametrize(("family", "fast"), some(2, [(PX4, False), (ARDUPILOT, True), (ARDUPILOT, False)]))
def test_interrupt_at_any_instruction_leaves_a_whole_mission(family: Autopilot, fast: bool) -> None:
    old, new = items_of(family, 4, shift=0.01), items_of(family, 6)
    counted = [0]
    upload = aboard(family, fast)[2]
    with each_instruction(lambda number: counted.__setitem__(0, number)):
        upload(new)
    outcomes = set()
    for moment in range(1, counted[0], counted[0] // MOMENTS):
        connection, mock, upload = aboard(family, fast)
        upload(old)
        try:
            with each_instruction(partial(_press_at, moment)):
                upload(new)
        except Cancelled as cancelled:
            words = str(cancelled)
        except KeyboardInterrupt:  # before the first message, or after the last
            words = "too late" if moment > counted[0] // 2 else "keeps"
        stored = mock.transfers.listed(MissionType.MISSION)
        expected = old if "keeps" in words else new
        assert compare(expected, stored, family) is None, (moment, words)
        assert any(sign in words for sign in ("keeps", "too late", "was completed", "holds the whole new")), words
        over = connection.channel.now() + 0.1
        while connection.channel.now() < over:
            connection.receive(over)
        assert mock.transfers.deadline > 1e9  # the vehicle waits for nothing more
        outcomes.add("keeps" in words)
    assert outcomes == {True, False}


@pytest.mark.parametrize(("family", "fast"), some(2, [(PX4, False), (ARDUPILOT, False), (ARDUPILOT, True)]))
def test_second_interrupt_at_any_instruction_names_the_list_left(family: Autopilot, fast: bool) -> None:
    old, new = items_of(family, 4, shift=0.01), items_of(family, 8)
    counted = [0]
    upload = aboard(family, fast)[2]
    with each_instruction(lambda number: counted.__setitem__(0, number)):
        upload(new)

    def end_at_once(moment: int, number: int) -> None:
        if number == moment:
            raise KeyboardInterrupt

    named = set[str]()
    for moment in range(1, counted[0], counted[0] // MOMENTS):
        _, mock, upload = aboard(family, fast)
        upload(old)
        try:
            with each_instruction(partial(end_at_once, moment)):
                upload(new)
        except Cancelled as cancelled:
            state = str(cancelled.known["list_on_vehicle"])
        except KeyboardInterrupt:  # before the first message, or after the last
            state = "new" if moment > counted[0] // 2 else "old"
        named.add(state)
        stored = mock.transfers.listed(MissionType.MISSION)
        is_old, is_new = (compare(each, stored, family) is None for each in (old, new))
        truth = {"old": is_old, "new": is_new, "either": is_old or is_new, "mixture": True}
        assert truth[state], (moment, state)
    assert named >= ({"mixture"} if family is ARDUPILOT and not fast else {"old"}), named


def test_second_interrupt_in_an_upload_to_ardupilot_names_the_mixture() -> None:
    _, mock, _ = aboard(ARDUPILOT)
    vehicle = meet(Connection(Loopback(Station(mock), SLOW), Codec(245, 190)), options=ConnectionOptions(fast=False))
    old, new = items_of(ARDUPILOT, 4, shift=0.01), items_of(ARDUPILOT, 8)
    vehicle.upload_items(old, MissionType.MISSION)
    calls = itertools.count(1)

    def end_at_the_fourth(share: float, words: str) -> None:
        if next(calls) == 4:
            raise KeyboardInterrupt

    with refuses("cancelled", "", "mission", list_on_vehicle="mixture") as cancelled:
        vehicle.upload_items(new, MissionType.MISSION, end_at_the_fourth)
    assert "upload again, or clear it" in str(cancelled.value.hint)
    stored = mock.transfers.listed(MissionType.MISSION)
    assert None not in (compare(old, stored, ARDUPILOT), compare(new, stored, ARDUPILOT))


def test_second_interrupt_while_px4_judges_names_the_new_list(monkeypatch: pytest.MonkeyPatch) -> None:
    def end_at_once(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ipoa_mission.link.upload._verdict", end_at_once)
    _, mock, upload = aboard(PX4)
    new = items_of(PX4, 8)
    with refuses("cancelled", list_on_vehicle="new"):
        upload(new)
    assert compare(new, mock.transfers.listed(MissionType.MISSION), PX4) is None


def test_cancellation_between_two_lists_names_the_state_of_both() -> None:
    connection, mock, _ = aboard(PX4)
    vehicle = meet(connection)
    listed = mock.vehicle.load_list
    items = (takeoff(HOME, 10.0), waypoint(Geodetic(47.4002, 8.5), 12.0))
    mission = Mission(HOME, items, PX4, fence=(FenceCircle((47.4, 8.5), 300.0),))
    for pressed_at, left in (
        (MissionType.FENCE, {"fence": "new", "mission": "old"}),
        (MissionType.MISSION, {"fence": "new", "mission": "new"}),
    ):

        def store_and_press(kind: int, at: int = pressed_at) -> None:
            listed(kind)
            _press_at(at, kind)

        mock.transfers.changed = store_and_press
        with refuses("cancelled", list_on_vehicle="new") as cancelled:
            vehicle.upload(mission)
        assert cancelled.value.known["lists_on_vehicle"] == left
        assert ("it keeps the mission that it had" in str(cancelled.value)) is ("old" in left.values())


class Pressing(Loopback):
    """Presses Ctrl-C at these moments."""

    def __init__(self, *presses: float) -> None:
        super().__init__(Station(Mock(PX4, HOME)))
        self._presses = list(presses)
        self.waited_at = 0.0

    def receive(self, until: float) -> list[tuple[bytes, object]]:
        self.waited_at = self.now()
        if self._presses and self.now() >= self._presses[0]:
            self._presses.pop(0)
            press()
        return super().receive(until)


def pausing() -> Dialogue[str]:
    try:
        heard = yield Pause(60.0)
        while heard is not None:
            heard = yield None
    except Cancelled:
        return "ended well"
    return "undisturbed"


def stubborn() -> Dialogue[None]:
    while True:
        with contextlib.suppress(Cancelled):
            yield Pause(60.0)


def test_a_conversation_may_end_well_and_a_second_press_ends_it_at_once() -> None:
    assert (
        run_dialogue(Connection(Pressing(5.0), Codec(245, 190)), Target(1, 1), pausing(), RoundTrip(SPECIFIED))
        == "ended well"
    )
    connection = Connection(Pressing(5.0, 6.0), Codec(245, 190))
    with pytest.raises(KeyboardInterrupt):
        run_dialogue(connection, Target(1, 1), stubborn(), RoundTrip(SPECIFIED))
    assert 6.0 <= connection.channel.now() < 6.2


def test_a_press_that_nobody_took_is_raised_when_the_conversation_is_over() -> None:
    with pytest.raises(KeyboardInterrupt), noted_interrupts():
        press()
    with noted_interrupts() as interrupt:
        press()
        assert interrupt.take()
        assert not interrupt.take()
    with pytest.raises(KeyboardInterrupt):
        press()


def test_a_program_keeps_its_own_handler_and_other_threads_have_none() -> None:
    heard: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    with noted_interrupts() as interrupt:
        press()
        assert not interrupt.is_pending
    assert heard == [signal.SIGINT]
    signal.signal(signal.SIGINT, signal.default_int_handler)
    noted: list[bool] = []

    def elsewhere() -> None:
        with noted_interrupts() as interrupt:
            noted.append(interrupt.is_pending)

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert noted == [False]


@pytest.mark.parametrize("number", terminations())
def test_a_termination_is_a_ctrl_c_and_later_ones_are_ignored(number: int) -> None:
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with noted_terminations():
            with noted_interrupts() as interrupt:
                for _ in range(3):
                    signal.raise_signal(number)
                assert interrupt.take()
                with pytest.raises(KeyboardInterrupt):
                    press()
            for each in terminations():
                signal.raise_signal(each)
        assert signal.getsignal(number) is signal.SIG_DFL
        with noted_terminations():
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(number)
            signal.raise_signal(number)
        signal.signal(number, signal.SIG_IGN)  # nohup
        with noted_terminations(), noted_interrupts():
            signal.raise_signal(number)
    finally:
        signal.signal(number, before)


def test_output_to_a_closed_terminal_is_discarded(tmp_path: Path) -> None:
    pty = pytest.importorskip("pty")
    code = "import signal, time; from ipoa_mission.interrupts import noted_terminations\n"
    code += "from ipoa_mission.terminal import print_lines\n"
    code += "signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"  # nohup ignores it
    code += "with noted_terminations():\n try:\n  print_lines('.'); time.sleep(60)\n"
    code += f" except KeyboardInterrupt:\n  print_lines('more'); open('{tmp_path}/done', 'w').close()"
    master, slave = pty.openpty()
    with subprocess.Popen([sys.executable, "-c", code], stdin=slave, stdout=slave, stderr=slave) as program:
        os.close(slave)
        os.read(master, 1)
        os.close(master)
        program.send_signal(signal.SIGHUP)
    assert (program.returncode, (tmp_path / "done").exists()) == (0, True)


def waiting() -> Dialogue[str]:
    heard = yield Pause(5.0)
    while heard is not None:
        heard = yield None
    return "done"


def test_a_press_in_the_moment_in_which_a_conversation_ends_is_not_lost() -> None:
    undisturbed = Pressing()
    assert (
        run_dialogue(Connection(undisturbed, Codec(245, 190)), Target(1, 1), waiting(), RoundTrip(SPECIFIED)) == "done"
    )
    with pytest.raises(KeyboardInterrupt):
        run_dialogue(
            Connection(Pressing(undisturbed.waited_at), Codec(245, 190)), Target(1, 1), waiting(), RoundTrip(SPECIFIED)
        )


def test_a_press_in_the_last_moment_of_an_upload_is_told_to_be_too_late() -> None:
    mission = Mission(HOME, (takeoff(HOME, 10.0), waypoint(Geodetic(47.4002, 8.5), 12.0)), PX4)
    undisturbed = Pressing()
    meet(Connection(undisturbed, Codec(245, 190))).upload(mission)
    channel = Pressing(undisturbed.waited_at)
    vehicle = meet(Connection(channel, Codec(245, 190)))
    with refuses("cancelled", list_on_vehicle="new"):
        vehicle.upload(mission)
    assert channel.now() == undisturbed.now()
    assert [item.altitude for item in vehicle.download().items] == [10.0, 12.0]
