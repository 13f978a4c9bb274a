from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import onboard_list as onboard_lists
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import Dialogue, NoAnswer
from ipoa_mission.link.messages import (
    AutopilotVersion,
    CommandLong,
    Count,
    Current,
    ItemAt,
    Message,
    MissionState,
    MissionType,
    Position,
)
from ipoa_mission.link.onboard_list import CHECK_INTERVAL_S, OnboardList, ReplacedSince, expect_unchanged
from ipoa_mission.link.upload import Replaced, Upload
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.items import Item, Mission, land, takeoff
from ipoa_mission.mission.stored_mission import to_wire
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.suited import suited
from tests.link_pair import connection_of, far_end, items_of
from tests.px4_waypoints import waypoint
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME = Geodetic(47.4, 8.5, 400.0)
THERE = Geodetic(47.4002, 8.5, 400.0)
MISSION = Mission(HOME, (takeoff(HOME, 5.0), waypoint(THERE, 5.0), land(THERE)))
STRANGER = Target(254, 190)


class MessageHeard(Exception):
    """The awaited message has arrived."""


def vehicle_of(family: Autopilot, **habits: object) -> Vehicle:
    return meet(Connection(Loopback(Station(Mock(family, HOME, **habits))), Codec(245, 190)))  # type: ignore[arg-type]


def mock_of(vehicle: Vehicle) -> Mock:
    mock: Mock = far_end(connection_of(vehicle)).autopilot
    return mock


def replaced_by(vehicle: Vehicle, mission: Mission) -> None:
    mock = mock_of(vehicle)
    items = to_wire(replace(mission, autopilot=vehicle.autopilot))
    mock.receive(Count(len(items)), STRANGER, vehicle.connection.now())
    for seq, item in enumerate(items):
        mock.receive(ItemAt(seq, item), STRANGER, vehicle.connection.now())


OTHERS: dict[str, Callable[[Mission], Mission]] = {
    "shorter": lambda mission: replace(mission, items=(mission.items[0], mission.items[2])),
    "as long": lambda mission: replace(mission, items=(mission.items[0], waypoint(HOME, 50.0), mission.items[2])),
}


@pytest.mark.parametrize("family", registered())
def test_start_without_prepare_is_not_ready(family: Autopilot) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, MISSION))
    with refuses("not-ready", "", "not prepared", kind=NotReady):
        vehicle.start()
    assert not mock_of(vehicle).flight.armed


@pytest.mark.parametrize("replacement", OTHERS)
@pytest.mark.parametrize("family", registered())
def test_a_list_that_another_station_has_put_there_is_not_flown(family: Autopilot, replacement: str) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    replaced_by(vehicle, OTHERS[replacement](MISSION))
    with refuses("replaced"):
        vehicle.start()
    assert not mock_of(vehicle).flight.armed
    assert not vehicle.record().armed


@pytest.mark.parametrize("has_checksum", [True, False])
def test_a_list_that_another_station_is_just_sending_is_not_flown(has_checksum: bool) -> None:
    """PX4 keeps the whole list that it has until it has the new one."""
    vehicle = vehicle_of(ARDUPILOT)
    vehicle.upload(suited(vehicle, MISSION))
    for onboard_list in vehicle._onboard_lists.values():
        onboard_list.list_id *= has_checksum
    vehicle.prepare()
    items = to_wire(replace(MISSION, autopilot=ARDUPILOT))
    mock = mock_of(vehicle)
    begun_s = vehicle.connection.now()
    receive = mock.receive

    def sending(message: Message, client: Target, now: float) -> None:
        if now - begun_s < 60.0:
            receive(Count(len(items) + 5), STRANGER, now)
        receive(message, client, now)

    mock.receive = sending  # type: ignore[method-assign,assignment]
    with pytest.raises((NotReady, Replaced, NoAnswer)):
        vehicle.start()
    assert not mock.flight.armed


@pytest.mark.parametrize("family", registered())
def test_a_fence_is_proved_too_and_what_was_downloaded_is_ours(family: Autopilot) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, replace(MISSION, rally=(THERE,))))
    vehicle.prepare()
    mock_of(vehicle).transfers.stores[MissionType.RALLY].put(())
    with refuses("replaced", "", "rally list"):
        vehicle.start()
    vehicle.download()
    vehicle.prepare()
    vehicle.start()
    assert vehicle.watch().completed


@pytest.mark.parametrize("family", registered())
def test_untouched_list_is_flown_to_the_end(family: Autopilot) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    assert vehicle.watch().completed
    assert vehicle.changed == ""


@pytest.mark.parametrize("family", registered())
def test_a_flight_is_watched_of_which_no_list_was_seen(family: Autopilot) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle._onboard_lists.clear()
    vehicle.start()
    assert vehicle.watch().completed
    assert vehicle.changed == ""


def test_a_list_that_cannot_be_read_in_flight_is_looked_at_once_more(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = vehicle_of(ARDUPILOT)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    read = onboard_lists._compare_list
    replaced_s, refused_s, told_s = list[float](), list[float](), list[float]()

    def once_refused(job: Upload) -> Dialogue[int]:
        if not refused_s:
            refused_s.append(vehicle.connection.now())
            raise NotReady("the vehicle does not tell")
        return (yield from read(job))

    def overhear(message: Message) -> None:
        if isinstance(message, Position) and message.height > 4.0 and not replaced_s:
            replaced_s.append(vehicle.connection.now())
            replaced_by(vehicle, OTHERS["as long"](MISSION))
        if vehicle.changed and not told_s:
            told_s.append(vehicle.connection.now())

    vehicle.overhearing = overhear
    monkeypatch.setattr(onboard_lists, "_compare_list", once_refused)
    assert not vehicle.watch().completed
    assert replaced_s[0] < refused_s[0] < told_s[0] <= refused_s[0] + CHECK_INTERVAL_S + 2.0


@pytest.mark.parametrize("replacement", OTHERS)
@pytest.mark.parametrize("family", registered())
def test_mission_replaced_in_flight_makes_the_flight_incomplete(
    family: Autopilot, replacement: str, caplog: pytest.LogCaptureFixture
) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    times: list[float] = []

    def overhear(message: Message) -> None:
        if isinstance(message, Position) and message.height > 4.0 and not times:
            times.append(vehicle.connection.now())
            replaced_by(vehicle, OTHERS[replacement](MISSION))
        if vehicle.changed and len(times) == 1:
            times.append(vehicle.connection.now())
            raise MessageHeard

    vehicle.overhearing = overhear
    with suppress(MessageHeard):
        vehicle.watch()
    record = vehicle.record()
    assert not record.completed
    assert "the mission on the vehicle is no longer ours: " in record.why_not
    is_asked = family is ARDUPILOT and replacement == "as long"  # without an id its checksum is requested
    assert times[1] - times[0] < (CHECK_INTERVAL_S + 2.0 if is_asked else 1.0)
    assert caplog.text.count("no longer ours") == 1


def test_one_that_makes_no_checksum_is_read_after_the_flight() -> None:
    vehicle = vehicle_of(ARDUPILOT)
    vehicle._about = AutopilotVersion(0, vehicle.autopilot.newest.number)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    replaced: list[Message] = []

    def overhear(message: Message) -> None:
        if isinstance(message, Position) and message.height > 4.0 and not replaced:
            replaced.append(message)
            replaced_by(vehicle, OTHERS["as long"](MISSION))

    vehicle.overhearing = overhear
    assert "when it was read after the flight, item 2" in vehicle.watch().why_not


def test_home_that_moves_in_flight_is_no_other_mission(caplog: pytest.LogCaptureFixture) -> None:
    vehicle = vehicle_of(ARDUPILOT)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    mock = mock_of(vehicle)
    items = mock.transfers.stores[MissionType.MISSION].items
    before = len(caplog.records)
    mock.transfers.stores[MissionType.MISSION].items = (replace(items[0], altitude=items[0].altitude + 1.0), *items[1:])
    assert vehicle.watch().completed
    assert vehicle.changed == ""
    assert len(caplog.records) == before


def test_between_the_arming_and_the_start_it_is_looked_at_once_more() -> None:
    vehicle = vehicle_of(ARDUPILOT)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    mock = mock_of(vehicle)
    receive = mock.receive

    def arming(message: Message, client: Target, now: float) -> None:
        receive(message, client, now)
        if isinstance(message, CommandLong) and message.command == 400 and message.params[0] == 1.0:
            replaced_by(vehicle, OTHERS["shorter"](MISSION))
            mock.vehicle.send(Current(0, 2, 3), Target(0, 0))

    mock.receive = arming  # type: ignore[method-assign,assignment]
    with refuses("replaced-since", "", "2 items", "3"):
        vehicle.start()
    assert not mock.flight.armed


@pytest.mark.parametrize("family", registered())
def test_onboard_list_unreadable_after_a_flight_is_accepted(family: Autopilot) -> None:
    vehicle = vehicle_of(family)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    mock = mock_of(vehicle)
    transfers = mock.transfers
    transfers.receive = lambda *_: False  # type: ignore[method-assign]
    assert vehicle.watch().completed


# --- what it says ---------------------------------------------------------------------------------------------------


def onboard_list(family: Autopilot, list_id: int = 0, count: int = 4) -> OnboardList:
    items: tuple[Item, ...] = items_of(family, count)
    return OnboardList(Upload(items, family), list_id)


@pytest.mark.parametrize(
    ("onboard", "current", "words"),
    [
        (onboard_list(PX4, 77), Current(0, 4, 2, 0, 77), ""),
        (onboard_list(PX4, 77), Current(0, 4, 2, 0, 78), "it has the id 78, and ours has 77"),
        (onboard_list(PX4, 77), Current(0, 4, 2, 0, 0), ""),
        (onboard_list(PX4), Current(0, 4, 2, 0, 78), ""),
        (onboard_list(PX4), Current(0, 5, 2), "it has 5 items, and ours has 4"),
        (onboard_list(PX4), Current(0, 65535, MissionState.NO_MISSION), "there is none any more"),
        (onboard_list(ARDUPILOT), Current(0, 3, 2), ""),
        (onboard_list(ARDUPILOT), Current(0, 0, MissionState.NO_MISSION), "there is none any more"),
        (onboard_list(ARDUPILOT), Current(0), ""),  # an old one tells neither
    ],
)
def test_another_mission_on_the_vehicle_is_named(onboard: OnboardList, current: Current, words: str) -> None:
    onboard.note(current)
    assert onboard.changed == words
    assert onboard.is_confirmed_by(current) is (current.mission_id == 77)
    assert not onboard.is_confirmed_by(None)
    onboard.note(Current(0, 9, 2))
    assert onboard.changed.startswith(words)
    with pytest.raises(ReplacedSince):
        expect_unchanged([onboard])


def test_a_fence_is_not_what_the_current_mission_is_about() -> None:
    fence = OnboardList(Upload((), PX4, MissionType.FENCE))
    fence.note(Current(0, 9, 2))
    expect_unchanged([fence])
