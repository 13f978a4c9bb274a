import math
from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.signing import Signer
from ipoa_mission.link.upload import Upload
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.link.wire import item_of, item_payload
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import Difference, compare
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link_pair import HOME, items_of

US = Target(245, 190)
ITEMS = items_of(Autopilot.PX4, 6)
KEY = bytes(range(32))


def read_back(some: Sequence[Item]) -> list[Item]:
    return [item_of(item_payload(seq, item, MissionType.MISSION)) for seq, item in enumerate(some)]


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
def test_an_upload_takes_one_frame_each_way_an_item(autopilot: Autopilot, key: bytes | None) -> None:
    mock = Mock(autopilot, HOME)
    channel = Counting(Station(mock, signer=Signer(key) if key else None))
    vehicle = meet(Connection(channel, Codec(*US, Signer(key) if key else None)), options=ConnectionOptions(fast=False))
    items = items_of(autopilot, 300)
    sent, heard = channel.sent, channel.heard
    done: list[str] = []
    vehicle.upload_items(items, MissionType.MISSION, lambda share, words: done.append(words))
    assert compare(items, mock.transfers.listed(MissionType.MISSION), autopilot) is None
    assert done == [f"{n} of 300" for n in range(301)]
    assert channel.sent - sent < 620
    assert channel.heard - heard < 700


numbers = st.floats(width=32, allow_nan=True, allow_infinity=False)
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


@given(st.lists(items, max_size=6), st.sampled_from(list(registered())))
def test_items_that_come_back_as_mavlink_carried_them_are_equal(wanted: list[Item], autopilot: Autopilot) -> None:
    assert Upload(wanted, autopilot).difference(read_back(wanted)) is None


@given(st.lists(st.tuples(items, items | st.none()), max_size=6), st.sampled_from(list(registered())))
def test_other_items_differ_as_the_firmware_judges_them(
    pairs: list[tuple[Item, Item | None]], autopilot: Autopilot
) -> None:
    wanted = read_back([one for one, _ in pairs])
    got = read_back([one if other is None else other for one, other in pairs])
    assert repr(Upload(wanted, autopilot).difference(got)) == repr(compare(wanted, got, autopilot))


@given(items)
def test_item_of_a_payload_is_the_item_that_was_packed(item: Item) -> None:
    payload = item_payload(0, item, MissionType.MISSION)
    assert item_payload(0, item_of(payload), MissionType.MISSION) == payload


def test_one_item_that_came_back_otherwise_is_found_among_many() -> None:
    changed = [*ITEMS[:4], replace(ITEMS[4], latitude_deg=ITEMS[4].latitude_deg + 1e-7), *ITEMS[5:]]
    difference = Upload(ITEMS, Autopilot.PX4).difference(read_back(changed))
    assert difference is not None
    assert (difference.seq, difference.field) == (5, "latitude")


def test_a_list_of_another_length_differs() -> None:
    difference = Upload(ITEMS[:-1], Autopilot.PX4).difference(read_back(ITEMS))
    assert difference is not None
    assert difference.field == "number of items"


@pytest.mark.parametrize(("version", "is_lost"), [(None, False), (Version(1, 17), False), (Version(1, 18), True)])
def test_a_param_that_this_firmware_keeps_may_not_be_lost(version: Version | None, is_lost: bool) -> None:
    """PX4 1.18 keeps the abort altitude of a LAND (param1), which 1.17 drops."""
    land = Item(Command.NAV_LAND, 3, (12.0, 0.0, 0.0, 0.0), 47.4, 8.5, 0.0)
    difference = Upload([land], Autopilot.PX4, version=version).difference([replace(land, params=(0.0, 0.0, 0.0, 0.0))])
    assert (None if difference is None else difference.field) == ("param1" if is_lost else None)


def test_an_upload_compares_by_the_firmware_that_was_heard(monkeypatch: pytest.MonkeyPatch) -> None:
    versions: list[Version | None] = []
    compared = Upload.difference

    def difference(job: Upload, stored: Sequence[Item]) -> Difference | None:
        versions.append(job.version)
        return compared(job, stored)

    monkeypatch.setattr(Upload, "difference", difference)
    vehicle = meet(Connection(Loopback(Station(Mock(Autopilot.PX4, HOME))), Codec(*US)))
    vehicle.upload_items(ITEMS, MissionType.MISSION)
    vehicle.firmware_version()
    vehicle.upload_items(ITEMS, MissionType.MISSION)
    assert [version and version.series for version in versions] == [None, (1, 18)]
