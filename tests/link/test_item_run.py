import math
from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import plain_frame
from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Codec, Framer, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.item_run import ItemRun, ItemsRead, ItemsSent
from ipoa_mission.link.messages import ItemAt, Message, MissionType, Request
from ipoa_mission.link.signing import Signer
from ipoa_mission.link.upload import Upload
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.link.wire import ITEM, item_of, item_payload
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import compare, first_number
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link_pair import HOME, items_of

US, VEHICLE = Target(245, 190), Target(1, 1)
ITEMS = items_of(Autopilot.PX4, 6)
NOW = 1.8e9
KEY = bytes(range(32))


def payloads_of(some: Sequence[Item]) -> list[bytes]:
    return [item_payload(seq, item, MissionType.MISSION) for seq, item in enumerate(some)]


def sent(at: int = 0) -> ItemsSent:
    return ItemsSent(MissionType.MISSION, len(ITEMS), at=at, payloads=payloads_of(ITEMS))


def joined(run: ItemRun, codec: Codec) -> ItemRun:
    run.join(codec, VEHICLE)
    return run


def said_by(codec: Codec, message: Message, to: Target = US) -> bytes:
    return codec.encode(message, to, NOW)


def test_items_sent_in_a_row_are_those_of_the_codec() -> None:
    plain, vehicle = Codec(*US), Codec(*VEHICLE)
    run = joined(sent(), Codec(*US))
    for seq in range(1, 5):
        assert run.answer(said_by(vehicle, Request(seq)), NOW) == plain.encode(ItemAt(seq, ITEMS[seq]), VEHICLE, NOW)


def test_requests_in_a_row_are_those_of_the_codec() -> None:
    plain, vehicle = Codec(*US), Codec(*VEHICLE)
    kept: list[Item | bytes] = []

    def take(seq: int, item: Item | bytes) -> int:
        assert seq == len(kept)
        kept.append(item)
        return 0

    run = joined(ItemsRead(MissionType.MISSION, len(ITEMS), 0, take), Codec(*US))
    for seq in range(4):
        assert run.answer(said_by(vehicle, ItemAt(seq, ITEMS[seq])), NOW) == plain.encode(
            Request(seq + 1), VEHICLE, NOW
        )
    assert [len(payload) for payload in kept if isinstance(payload, bytes)] == [ITEM.layout.size] * 4
    assert Upload(ITEMS[:4], Autopilot.PX4).difference(kept) is None


@pytest.mark.parametrize(
    "frame",
    [
        said_by(Codec(*VEHICLE), ItemAt(1, ITEMS[1])),  # late
        said_by(Codec(*VEHICLE), ItemAt(3, ITEMS[3])),
        said_by(Codec(*VEHICLE), ItemAt(2, ITEMS[2], MissionType.FENCE)),
        said_by(Codec(*VEHICLE), ItemAt(2, ITEMS[2]), Target(255, 190)),
        said_by(Codec(*VEHICLE), Request(2)),
    ],
)
def test_other_items_are_left_to_the_dialogue(frame: bytes) -> None:
    run = joined(ItemsRead(MissionType.MISSION, len(ITEMS), 2, lambda seq, item: 0), Codec(*US))
    assert run.answer(frame, NOW) is None
    assert run.answer(said_by(Codec(*VEHICLE), ItemAt(2, ITEMS[2])), NOW)


@pytest.mark.parametrize(
    "frame",
    [
        said_by(Codec(*VEHICLE), Request(1)),  # late
        said_by(Codec(*VEHICLE), Request(3)),  # too early
        said_by(Codec(*VEHICLE), Request(2, MissionType.FENCE)),
        said_by(Codec(*VEHICLE), Request(2), Target(255, 190)),
        said_by(Codec(*VEHICLE), Request(2), Target(0, 0)),
        said_by(Codec(2, 1), Request(2)),
        said_by(Codec(1, 2), Request(2)),
        said_by(Codec(*VEHICLE, Signer(KEY)), Request(2)),
        said_by(Codec(*VEHICLE), Request(2))[:-1] + b"\x00",
        said_by(Codec(*VEHICLE), Request(2))[:-1],
        said_by(Codec(*VEHICLE), Request(2)) * 2,
        b"",
    ],
)
def test_anything_else_is_left_to_the_dialogue(frame: bytes) -> None:
    run = joined(sent(at=1), Codec(*US))
    assert run.answer(frame, NOW) is None
    assert run.at == 1
    assert run.answer(said_by(Codec(*VEHICLE), Request(2)), NOW)


def test_only_signed_frames_count_with_a_key_and_each_once() -> None:
    run = joined(sent(at=1), Codec(*US, Signer(KEY)))
    vehicle = Codec(*VEHICLE, Signer(KEY))
    second = said_by(vehicle, Request(2))
    assert not run.answer(said_by(Codec(*VEHICLE), Request(2)), NOW)
    assert not run.answer(said_by(Codec(*VEHICLE, Signer(bytes(32))), Request(2)), NOW)
    signed = run.answer(second, NOW)
    run.at = 1
    assert not run.answer(second, NOW)
    (reply,) = Framer().feed(signed or b"")
    heard = Codec(*VEHICLE, Signer(KEY)).decode(reply)
    assert heard is not None
    assert isinstance(heard.message, ItemAt)
    assert heard.message.seq == 2


class Counting(Loopback):
    sent = heard = 0

    def send(self, data: bytes, peer: Peer | None) -> None:
        self.sent += 1
        super().send(data, peer)

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        got = super().receive(until)
        self.heard += len(got)
        return got


@pytest.mark.parametrize("autopilot", list(registered()))
@pytest.mark.parametrize("key", [None, KEY])
def test_item_run_takes_one_frame_each_way_an_item(
    autopilot: Autopilot, key: bytes | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    reached: list[Message] = []
    mock = Mock(autopilot, HOME)
    channel = Counting(Station(mock, signer=Signer(key) if key else None))
    vehicle = meet(Connection(channel, Codec(*US, Signer(key) if key else None)), options=ConnectionOptions(fast=False))
    items = items_of(autopilot, 300)
    monkeypatch.setattr(vehicle, "_overhear", reached.append)
    sent, heard = channel.sent, channel.heard
    done: list[str] = []
    vehicle.upload_items(items, MissionType.MISSION, lambda share, words: done.append(words))
    assert compare(items, mock.transfers.listed(MissionType.MISSION), autopilot) is None
    assert done == [f"{n} of 300" for n in range(301)]
    assert channel.sent - sent < 620
    assert channel.heard - heard < 700
    assert sum(isinstance(message, Request | ItemAt) for message in reached) < 30


numbers = st.floats(width=32, allow_nan=True, allow_infinity=True)
items = st.builds(
    Item,
    command=st.sampled_from([16, 19, 20, 21, 22, 82, 93, 115, 177, 178, 201, 5001, 5003, 5100, 31000]),
    frame=st.sampled_from([0, 2, 3, 5, 6, 10, 11, 1]),
    params=st.tuples(numbers, numbers, numbers, numbers),
    latitude_deg=st.integers(-900_000_000, 900_000_000).map(lambda n: n / 1e7),
    longitude_deg=st.integers(-1_800_000_000, 1_800_000_000).map(lambda n: n / 1e7) | st.just(math.nan),
    altitude=numbers,
    autocontinue=st.booleans(),
)


@given(st.lists(st.tuples(items, items | st.none()), max_size=6), st.sampled_from(list(registered())))
def test_payloads_are_compared_as_their_items(pairs: list[tuple[Item, Item | None]], autopilot: Autopilot) -> None:
    wanted = [one for one, _ in pairs]
    got = [one if other is None else other for one, other in pairs]
    by_bits = Upload(wanted, autopilot).difference(payloads_of(got))
    one_by_one = compare(wanted, [item_of(payload) for payload in payloads_of(got)], autopilot)
    if one_by_one is None:
        assert by_bits is None
    elif by_bits != one_by_one:  # equal bits are no difference, whatever a rounding rule says
        assert one_by_one.seq is not None
        n = one_by_one.seq - first_number(wanted, autopilot)
        first, other = wanted[n], got[n]
        assert plain_frame(first.frame) == plain_frame(other.frame)
        assert payloads_of([first]) == payloads_of([replace(other, frame=first.frame)])


@given(items)
def test_item_of_a_payload_is_the_item_that_was_packed(item: Item) -> None:
    (payload,) = payloads_of([item])
    assert payloads_of([item_of(payload)]) == [payload]


def test_one_item_that_came_back_otherwise_is_found_among_many() -> None:
    changed = [*ITEMS[:4], replace(ITEMS[4], latitude_deg=ITEMS[4].latitude_deg + 1e-7), *ITEMS[5:]]
    difference = Upload(ITEMS, Autopilot.PX4).difference(payloads_of(changed))
    assert difference is not None
    assert (difference.seq, difference.field) == (5, "latitude")


def test_payloads_of_another_number_are_a_difference() -> None:
    difference = Upload(ITEMS[:-1], Autopilot.PX4).difference(payloads_of(ITEMS))
    assert difference is not None
    assert difference.field == "number of items"
