import numpy as np
import pytest

from ipoa_mission.link.mavftp import MISSION_FILE, FileMessage, Opcode, pack_mission
from ipoa_mission.link.messages import Ack, ClearAll, Count, ItemAt, Message, MissionType, Result, WritePartialList
from ipoa_mission.logs.telemetry_log import Items, Transfers, growing, unwrapped, vehicle_times
from ipoa_mission.mission.items import Item

OLD = tuple(Item(16, 3, latitude_deg=47.0 + n / 100, longitude_deg=8.5, altitude=10.0) for n in range(3))
NEW = tuple(Item(16, 3, latitude_deg=46.0 + n / 100, longitude_deg=8.5, altitude=10.0) for n in range(3))
ACCEPTED = Ack(Result.ACCEPTED)


def lists_in(*messages: tuple[Message, bool]) -> list[Items]:
    transfers = Transfers()
    return [items for message, by_vehicle in messages if (items := transfers.note(message, by_vehicle)) is not None]


def sent(items: Items, by_vehicle: bool) -> list[tuple[Message, bool]]:
    return [(Count(len(items)), by_vehicle), *((ItemAt(n, item), by_vehicle) for n, item in enumerate(items))]


def test_an_upload_counts_when_the_vehicle_has_accepted_it() -> None:
    assert lists_in(*sent(OLD, False)) == []
    assert lists_in(*sent(OLD, False), (ACCEPTED, True)) == [OLD]
    assert lists_in(*sent(OLD, False), (Ack(Result.ERROR), True)) == []
    assert lists_in(*sent(OLD, False)[:-1], (ACCEPTED, True)) == []


def test_a_download_counts_when_the_last_item_is_there_in_any_order() -> None:
    count, *items = sent(OLD, True)
    assert lists_in(count, items[2], items[0], items[0], items[1]) == [OLD]
    assert lists_in((Count(0), True)) == [()]


def test_a_count_that_is_repeated_begins_nothing_anew() -> None:
    count, first, *rest = sent(OLD, False)
    assert lists_in(count, first, count, *rest, (ACCEPTED, True)) == [OLD]


def test_lists_of_another_kind_are_not_the_mission() -> None:
    fence = [(Count(1, MissionType.FENCE), False), (ItemAt(0, OLD[0], MissionType.FENCE), False)]
    assert lists_in(*fence, (Ack(Result.ACCEPTED, MissionType.FENCE), True)) == []


def test_a_part_that_is_written_over_and_a_list_that_is_cleared() -> None:
    upload = [*sent(OLD, False), (ACCEPTED, True)]
    part = [(WritePartialList(1, 1), False), (ItemAt(1, NEW[1]), False), (ACCEPTED, True)]
    assert lists_in(*upload, *part) == [OLD, (OLD[0], NEW[1], OLD[2])]
    assert lists_in(*upload, (ClearAll(), False), (ACCEPTED, True)) == [OLD, ()]


@pytest.mark.parametrize("written", [True, False])
def test_a_mission_that_goes_as_a_file(written: bool) -> None:
    data = pack_mission(OLD)
    pieces = [(at, data[at : at + 60]) for at in range(0, len(data), 60)]
    if written:
        messages = [(FileMessage(2, Opcode.CREATE_FILE, data=MISSION_FILE.encode()).pack(), False)]
        messages += [(FileMessage(4, Opcode.WRITE_FILE, offset=at, data=piece).pack(), False) for at, piece in pieces]
        messages += [(FileMessage(8, Opcode.ACK, request=Opcode.WRITE_FILE).pack(), True)]
        messages += [(FileMessage(9, Opcode.ACK, request=Opcode.TERMINATE_SESSION).pack(), True)]
        assert lists_in(*messages[:-1]) == []
    else:
        messages = [(FileMessage(2, Opcode.OPEN_FILE_RO, data=MISSION_FILE.encode()).pack(), False)]
        messages += [
            (FileMessage(4, Opcode.ACK, request=Opcode.READ_FILE, offset=at, data=piece).pack(), True)
            for at, piece in pieces
        ]
    (items,) = lists_in(*messages)
    assert [item.latitude_deg for item in items] == pytest.approx([item.latitude_deg for item in OLD])


def test_clock_before_the_first_telemetry_is_as_fast_as_after() -> None:
    known_at = np.arange(10.0, 14.0, 0.1)
    known = 100.0 + 8.0 * (known_at - 10.0)
    stamps = np.array([9.5, 10.0, 10.05, 14.0])
    assert vehicle_times(stamps, known_at, known) == pytest.approx([96.0, 100.0, 100.4, 132.0])
    assert vehicle_times(stamps, np.empty(0), np.empty(0)) == pytest.approx(stamps)


def test_a_restart_of_the_autopilot_does_not_turn_the_clock_back() -> None:
    times = unwrapped(np.array([0.0, 1.0, 2.0, 5.0, 6.0]), np.array([200.0, 201.0, 200.9, 3.0, 4.0]))
    assert times == pytest.approx([200.0, 201.0, 201.0, 204.0, 205.0], abs=0.11)


def test_a_torn_stamp_is_between_its_neighbors() -> None:
    stamps = growing([1.7e9, 1.7e9 + 1, 9.9e12, 1.7e9 + 2, 1.7e9 + 2, 1.7e9 + 3])
    assert stamps == pytest.approx([0, 1, 2, 2, 2, 3], abs=1e-6)
    assert (np.diff(stamps) > 0).all()


def test_an_item_from_the_side_that_was_to_get_it_is_none_of_the_list() -> None:
    assert lists_in(*sent(OLD, False), (ItemAt(1, NEW[1]), True), (ACCEPTED, True)) == [OLD]
    assert lists_in(*sent(OLD, False)[:-1], (ItemAt(2, NEW[2]), True), (ACCEPTED, True)) == []
