import math
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from itertools import count as counting

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import MissionError
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection, run_dialogue
from ipoa_mission.link.conversations import KeepsChanging
from ipoa_mission.link.dialogue import SPECIFIED, Cancelled, Exchange, RoundTrip, TimeUp
from ipoa_mission.link.mavftp import (
    MISSION_FILE,
    FileError,
    FileMessage,
    Opcode,
    file_checksum,
    list_checksum,
    pack_mission,
    read_file,
    unpack,
    unpack_mission,
    write_file,
)
from ipoa_mission.link.messages import CommandResult, FileTransfer, ItemAt, Message, MissionType
from ipoa_mission.link.onboard_list import prove
from ipoa_mission.link.upload import ReadBackDiffers, Replaced, Upload, upload, upload_by_file
from ipoa_mission.link.vehicle import ConnectionOptions, Vehicle
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import compare
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.built_in_autopilot import FileService
from ipoa_mission.simulator.station import Faults, Loopback, Station
from tests.examples import examples
from tests.link_pair import HOME, connection_of, items_of
from tests.refused import refuses

ARDUPILOT = Autopilot.ARDUPILOT
CLIENT = Target(245, 190)


def aboard(faults: Faults, seed: int = 0, fast: bool = True, family: Autopilot = ARDUPILOT) -> tuple[Vehicle, Mock]:
    mock = Mock(family, HOME)
    connection = Connection(Loopback(Station(mock), faults, seed), Codec(*CLIENT))
    return meet(connection, options=ConnectionOptions(fast=fast)), mock


def heard_by(mock: Mock) -> list[object]:
    heard: list[object] = []
    original = mock.receive

    def receive(message: object, source: Target, now: float) -> None:
        heard.append(message)
        original(message, source, now)  # type: ignore[arg-type]

    mock.receive = receive  # type: ignore[method-assign]
    return heard


def test_a_mission_goes_as_one_file_and_not_item_by_item() -> None:
    vehicle, mock = aboard(Faults())
    heard = heard_by(mock)
    sent = items_of(ARDUPILOT, 100)
    stages: list[tuple[float, str]] = []
    vehicle.upload_items(sent, MissionType.MISSION, lambda share, words: stages.append((share, words)))
    assert compare(sent, mock.transfers.listed(0), ARDUPILOT) is None
    assert not any(isinstance(message, ItemAt) for message in heard)
    assert sum(isinstance(message, FileTransfer) for message in heard) < 50
    assert stages[-1] == (1.0, "100 of 100")


def test_mission_file_is_several_times_as_quick_at_200_ms() -> None:
    took = {}
    for fast in (True, False):
        vehicle, _ = aboard(Faults(delay_s=0.2), fast=fast)
        begun = connection_of(vehicle).channel.now()
        vehicle.upload_items(items_of(ARDUPILOT, 100), MissionType.MISSION)
        took[fast] = connection_of(vehicle).channel.now() - begun
    assert took[True] < took[False] / 3


@pytest.mark.parametrize("seed", range(3))
def test_mission_file_is_exact_over_a_bad_radio(seed: int) -> None:
    vehicle, mock = aboard(Faults(loss=0.3, duplicate=0.1, delay_s=0.3, reorder=0.1), seed)
    sent = items_of(ARDUPILOT, 60)
    vehicle.upload_items(sent, MissionType.MISSION)
    assert compare(sent, mock.transfers.listed(0), ARDUPILOT) is None


def test_refusal_of_a_mission_file_names_the_item() -> None:
    vehicle, _ = aboard(Faults())
    bad = replace(items_of(ARDUPILOT, 5)[4], latitude_deg=95.0)
    with refuses("mission-refused", "", "item 4", "INVALID_PARAM5_X"):
        vehicle.upload_items((*items_of(ARDUPILOT, 4), bad), MissionType.MISSION)


def test_a_vehicle_without_the_file_is_served_the_ordinary_way() -> None:
    vehicle, mock = aboard(Faults())
    mock._files = FileService(False, 10, mock.transfers.listed, mock.transfers.replace)
    vehicle.upload_items(items_of(ARDUPILOT, 5), MissionType.MISSION)
    assert len(mock.transfers.listed(0)) == 5


@pytest.mark.parametrize("mute", ["capabilities", "files"])
def test_a_vehicle_without_file_transfer_gets_the_mission_item_by_item(mute: str) -> None:
    vehicle, mock = aboard(Faults())
    if mute == "capabilities":
        mock.vehicle._find_message = lambda name: CommandResult.UNSUPPORTED  # type: ignore[method-assign]
    else:
        original = mock.receive
        mock.receive = lambda message, *rest: (  # type: ignore[method-assign]
            None if isinstance(message, FileTransfer) else original(message, *rest)
        )
    vehicle.upload_items(items_of(ARDUPILOT, 5), MissionType.MISSION)
    assert len(mock.transfers.listed(0)) == 5


def test_px4_has_no_such_file() -> None:
    vehicle, mock = aboard(Faults(), family=Autopilot.PX4)
    heard = heard_by(mock)
    vehicle.upload_items(items_of(Autopilot.PX4, 5), MissionType.MISSION)
    assert not any(isinstance(message, FileTransfer) for message in heard)
    with refuses("file-refused", "", "MISSION/mission.dat"):
        run_dialogue(connection_of(vehicle), Target(1, 1), read_file(MISSION_FILE), RoundTrip(SPECIFIED))


def test_a_file_that_reads_back_differently_is_an_error() -> None:
    vehicle, mock = aboard(Faults())
    mock._files = FileService(True, 650, mock.transfers.listed, lambda items: True)
    job = Upload(items_of(ARDUPILOT, 5), ARDUPILOT)
    with pytest.raises(ReadBackDiffers):
        run_dialogue(connection_of(vehicle), Target(1, 1), upload_by_file(job), RoundTrip(SPECIFIED))


def test_silence_says_what_was_asked() -> None:
    vehicle, mock = aboard(Faults())
    mock.receive = lambda *anything: None  # type: ignore[method-assign]
    with refuses("no-answer", "", "reset"):
        run_dialogue(connection_of(vehicle), Target(1, 1), write_file("x", b"y"), RoundTrip(SPECIFIED))


@pytest.mark.parametrize("error", [Cancelled("cancelled"), TimeUp("the time is up")], ids=["cancelled", "late"])
@pytest.mark.parametrize("moment", [1.0, 4.0, 5.0], ids=["while writing", "while closing", "while reading back"])
def test_an_aborted_file_upload_leaves_a_whole_mission_and_names_it(error: MissionError, moment: float) -> None:
    vehicle, mock = aboard(Faults(delay_s=0.2))
    old, new = items_of(ARDUPILOT, 4, shift=0.1), items_of(ARDUPILOT, 40)
    vehicle.upload_items(old, MissionType.MISSION)
    until = connection_of(vehicle).channel.now() + moment
    job = Upload(new, ARDUPILOT, numbers=count(1000, 2))
    exchange = Exchange(upload(job, by_file=True), connection_of(vehicle).channel.now(), SPECIFIED)
    with pytest.raises(type(error)) as caught:
        drive(exchange, connection_of(vehicle), until, error)
    stored = mock.transfers.listed(0)
    words = str(caught.value)
    if isinstance(error, TimeUp) and moment > 2.0:
        assert "a whole mission, the old or the new one" in words
        assert None in (compare(old, stored, ARDUPILOT), compare(new, stored, ARDUPILOT))
    else:
        assert compare(old if "keeps the mission it had" in words else new, stored, ARDUPILOT) is None
        assert ("too late" in words) == (moment > 2.0)


@pytest.mark.parametrize(("mute", "words"), [(True, ("cancelled",)), (False, ("cancelled",))])
def test_cancelled_while_closing_a_vehicle_that_refuses_or_is_silent(mute: bool, words: tuple[str, ...]) -> None:
    vehicle, mock = aboard(Faults(delay_s=0.2))
    original = mock.receive

    def receive(message: Message, source: Target, now: float) -> None:
        closes = isinstance(message, FileTransfer) and unpack(message).opcode == Opcode.TERMINATE_SESSION
        if not (closes and mute):
            original(message, source, now)

    mock.receive = receive  # type: ignore[method-assign]
    mock._files = FileService(True, 650, mock.transfers.listed, lambda items: False)
    exchange = Exchange(
        upload_by_file(Upload(items_of(ARDUPILOT, 4), ARDUPILOT)), connection_of(vehicle).channel.now(), SPECIFIED
    )
    with refuses(*words):
        drive(exchange, connection_of(vehicle), connection_of(vehicle).channel.now() + 1.3, Cancelled("cancelled"))


def drive(exchange: Exchange[int], connection: Connection, moment: float, error: MissionError) -> None:
    now = connection.channel.now
    while not exchange.finished:
        for message in exchange.outgoing():
            connection.send(message, Target(1, 1))
        for heard in connection.receive(min(exchange.deadline, moment)):
            if heard.message is not None:
                exchange.receive(heard.message, now())
        exchange.tick(now())
        if now() >= moment:
            moment = math.inf
            exchange.interrupt(error, now())


# --- lists that somebody changes while they are read ----------------------------------------------------------------


def when_asked(mock: Mock, opcode: int, act: Callable[[int], None]) -> None:
    """Call `act`, with its number, before each file question of this kind."""
    receive, heard = mock.receive, count()

    def hear(message: Message, source: Target, now: float) -> None:
        if isinstance(message, FileTransfer) and unpack(message).opcode == opcode:
            act(next(heard))
        receive(message, source, now)

    mock.receive = hear  # type: ignore[method-assign]


@pytest.mark.parametrize("fast", [True, False], ids=["as a file", "item by item"])
def test_a_list_that_is_changed_each_time_that_it_is_read_is_unsettled(fast: bool) -> None:
    vehicle, mock = aboard(Faults(), fast=fast)
    items = items_of(ARDUPILOT, 5)
    homes = [replace(HOME, altitude=401.0 + n) for n in range(30)]  # it is item 0, and not compared
    when_asked(mock, Opcode.CALC_FILE_CRC32, lambda number: setattr(mock.flight, "home", homes[number]))
    with refuses("keeps-changing"):
        vehicle.upload_items(items, MissionType.MISSION)
    with pytest.raises(KeepsChanging):
        vehicle.download_items(MissionType.MISSION)


@pytest.mark.parametrize("fast", [True, False], ids=["as a file", "item by item"])
def test_a_list_that_was_changed_once_is_read_once_more(fast: bool) -> None:
    vehicle, mock = aboard(Faults(), fast=fast)
    first = 0 if fast else 1
    when_asked(
        mock,
        Opcode.CALC_FILE_CRC32,
        lambda number: setattr(mock.flight, "home", replace(HOME, altitude=400.0 + (number >= first))),
    )
    vehicle.upload_items(items_of(ARDUPILOT, 5), MissionType.MISSION)
    mock.transfers.stores[MissionType.MISSION].put(())
    with pytest.raises(Replaced):
        run_dialogue(
            connection_of(vehicle),
            Target(1, 1),
            prove(vehicle._onboard_lists.values(), vehicle.state),
            RoundTrip(SPECIFIED),
        )


def test_a_question_for_a_checksum_that_is_repeated_is_a_new_one() -> None:
    vehicle, mock = aboard(Faults())
    numbers: list[int] = []
    receive = mock.receive

    def deaf_at_first(message: Message, source: Target, now: float) -> None:
        if isinstance(message, FileTransfer):
            numbers.append(unpack(message).sequence)
        if len(numbers) > 3 or not isinstance(message, FileTransfer):
            receive(message, source, now)

    mock.receive = deaf_at_first  # type: ignore[method-assign]
    answers = run_dialogue(
        connection_of(vehicle), Target(1, 1), list_checksum(MissionType.MISSION, counting(0, 2)), RoundTrip(SPECIFIED)
    )
    assert answers == file_checksum(pack_mission(()))
    assert len(set(numbers)) == 4


def test_mission_file_without_checksums_is_read_and_silence_is_an_error() -> None:
    vehicle, mock = aboard(Faults(), fast=False)
    mock._files = FileService(False, 650, mock.transfers.listed, mock.transfers.replace)
    vehicle.upload_items(items_of(ARDUPILOT, 5), MissionType.MISSION)
    assert len(vehicle.download_items(MissionType.MISSION)) == 5
    receive = mock.receive
    mock.receive = lambda message, *rest: (  # type: ignore[method-assign]
        None if isinstance(message, FileTransfer) else receive(message, *rest)
    )
    with refuses("no-answer", "", "MISSION/mission.dat"):
        run_dialogue(
            connection_of(vehicle),
            Target(1, 1),
            list_checksum(MissionType.MISSION, counting(0, 2)),
            RoundTrip(SPECIFIED),
        )
    begun = vehicle.connection.now()
    assert len(vehicle.download_items(MissionType.MISSION)) == 5
    assert vehicle.connection.now() - begun < 40.0


# --- the file -------------------------------------------------------------------------------------------------------

ITEMS = st.builds(
    Item,
    st.integers(0, 65535),
    st.sampled_from([0, 2, 3, 5, 6, 10]),
    st.tuples(*[st.floats(width=32, allow_nan=False)] * 4),
    st.integers(-90, 90).map(float),
    st.integers(-180, 180).map(float),
    st.floats(width=32, allow_nan=False),
    st.booleans(),
)


@settings(max_examples=examples(30))
@given(st.lists(ITEMS, max_size=8))
def test_a_file_reads_back_as_it_was_packed(items: list[Item]) -> None:
    assert unpack_mission(pack_mission(items)) == tuple(items)


@settings(max_examples=examples(100))
@given(st.binary(max_size=120), st.booleans())
def test_wrong_mission_file_is_an_error(data: bytes, like: bool) -> None:
    file = b"\x3d\x76" + data if like else data
    if len(file) >= 10 and file[:2] == b"\x3d\x76" and len(file) == 10 + 38 * int.from_bytes(file[8:10], "little"):
        assert len(unpack_mission(file)) == file[8]
    else:
        with refuses("wrong-format", "mission file"):
            unpack_mission(file)


# --- the service ----------------------------------------------------------------------------------------------------


def service() -> FileService:
    return FileService(True, 3, lambda kind: (), lambda items: True)


def ask(service: FileService, *questions: FileMessage, client: Target = CLIENT) -> FileMessage:
    for question in questions:
        answer = service.answer(question.pack(), client)
    return unpack(answer)


OPEN = FileMessage(0, Opcode.CREATE_FILE, data=MISSION_FILE.encode())


REFUSALS = [
    (FileMessage(0, 99), FileError.UNKNOWN_COMMAND),
    (FileMessage(0, Opcode.OPEN_FILE_RO, data=b"@PARAM/param.pck"), FileError.FILE_NOT_FOUND),
    (FileMessage(0, Opcode.READ_FILE), FileError.INVALID_SESSION),
    (FileMessage(0, Opcode.BURST_READ_FILE), FileError.UNKNOWN_COMMAND),
    (FileMessage(0, Opcode.WRITE_FILE, data=b"x"), FileError.INVALID_SESSION),
]


@pytest.mark.parametrize(("question", "error"), REFUSALS, ids=lambda value: str(value)[:30])
def test_the_service_refuses_with_the_right_error(question: FileMessage, error: FileError) -> None:
    answer = ask(service(), question)
    assert (answer.opcode, answer.data[0], answer.sequence) == (Opcode.NAK, error, 1)


@pytest.mark.parametrize("offset", [5, 10**6])
def test_a_gap_or_an_endless_file_is_refused(offset: int) -> None:
    piece = FileMessage(2, Opcode.WRITE_FILE, offset=offset, data=b"x")
    assert ask(service(), OPEN, piece).opcode == Opcode.NAK


def test_a_broken_file_is_refused_at_its_close() -> None:
    piece = FileMessage(2, Opcode.WRITE_FILE, data=b"nonsense")
    assert ask(service(), OPEN, piece, FileMessage(4, Opcode.TERMINATE_SESSION)).opcode == Opcode.NAK


def test_a_repeated_question_gets_its_answer_again_and_is_done_once() -> None:
    file_service = service()
    ask(file_service, OPEN, piece := FileMessage(2, Opcode.WRITE_FILE, data=pack_mission(())))
    taken = FileMessage(4, Opcode.TERMINATE_SESSION)
    assert ask(file_service, piece, taken, taken).opcode == Opcode.ACK


numbers = st.floats(width=32)
items = st.builds(
    Item,
    command=st.integers(0, 0xFFFF),
    frame=st.sampled_from([0, 2, 3, 5, 6, 10, 11, 1]),
    params=st.tuples(numbers, numbers, numbers, numbers),
    latitude_deg=st.integers(-900_000_000, 900_000_000).map(lambda n: n / 1e7) | st.just(math.nan),
    longitude_deg=st.integers(-1_800_000_000, 1_800_000_000).map(lambda n: n / 1e7) | st.just(math.nan),
    altitude=numbers,
    autocontinue=st.booleans(),
)


@given(st.lists(items, max_size=4))
def test_mission_file_is_read_as_it_was_packed(some: list[Item]) -> None:
    data = pack_mission(some)
    assert pack_mission(unpack_mission(data)) == data
