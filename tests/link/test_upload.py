import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.conversations import download
from ipoa_mission.link.dialogue import Cancelled, NoAnswer, TimeUp
from ipoa_mission.link.messages import Ack, Count, ItemAt, Message, MissionType, Request, RequestList, Result
from ipoa_mission.link.upload import Upload, upload
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.mission import stored_mission
from ipoa_mission.mission.items import FenceCircle, Item, Mission, takeoff, waypoint
from ipoa_mission.mission.stored_mission import compare
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.scripted_answers import lead
from tests.link_pair import HOME, STRANGER, Air, Fate, Vehicle, items_of
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
RALLY = tuple(Item(5100, 3, (0.0,) * 4, 47.4 + 0.001 * n, 8.5, 20.0) for n in range(3))
FENCE = (Item(5003, 3, (250.0, 0.0, 0.0, 0.0), 47.4, 8.5),)


def interrupt_at(moment: float) -> dict[float, MissionError]:
    return {moment: Cancelled("cancelled")}


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize(
    ("kind", "items"), [(MissionType.FENCE, FENCE), (MissionType.RALLY, RALLY), (MissionType.RALLY, ())]
)
def test_fence_and_rally_points_go_the_same_way(autopilot: Autopilot, kind: int, items: tuple[Item, ...]) -> None:
    vehicle = Vehicle(autopilot)
    vehicle.store(RALLY[:1], MissionType.RALLY)
    Air(vehicle).hold(upload(Upload(items, autopilot, kind)))
    assert compare(items, vehicle.holds(kind), autopilot) is None


@pytest.mark.parametrize("autopilot", registered())
def test_an_empty_mission_clears_the_vehicle(autopilot: Autopilot) -> None:
    vehicle = Vehicle(autopilot)
    vehicle.store(items_of(autopilot, 5))
    Air(vehicle).hold(upload(Upload((), autopilot)))
    assert vehicle.holds() == ()


def test_home_alone_is_an_empty_mission_of_ardupilots() -> None:
    home = items_of(ARDUPILOT, 1)[0]
    script = {Count: [[Ack(0)]], RequestList: [[Count(1)]], Request: [[ItemAt(0, home)]]}
    assert lead(upload(Upload((), ARDUPILOT)), script).finished  # type: ignore[arg-type]


def test_a_second_refusal_is_final_and_its_hint_names_the_vehicles_mission() -> None:
    vehicle = Vehicle(ARDUPILOT)
    vehicle.store(items_of(ARDUPILOT, 5, shift=0.1))
    items = [*items_of(ARDUPILOT, 5)]
    items[2] = Item(177, 2, (99.0, 1.0, 0.0, 0.0))  # a jump to nowhere
    with refuses("mission-refused", "", "item 2", "ERROR") as refusal:
        Air(vehicle).hold(upload(Upload(items, ARDUPILOT)))
    assert "mixture" in str(refusal.value)


def test_a_refusal_by_an_atomic_vehicle_is_final_at_once() -> None:
    vehicle = Vehicle(PX4)
    before = items_of(PX4, 4, shift=0.1)
    vehicle.store(before)
    spline = Item(82, 3, (0.0,) * 4, 47.4, 8.5, 30.0)
    air = Air(vehicle)
    with refuses("mission-refused", "", "UNSUPPORTED") as refusal:
        air.hold(upload(Upload((*items_of(PX4, 2), spline), PX4)))
    assert refusal.value.seq == 2
    assert "keeps" in str(refusal.value)
    assert compare(before, vehicle.holds(), PX4) is None
    assert air.now < 2.0


def test_another_station_that_uploads_is_waited_for() -> None:
    vehicle = Vehicle(ARDUPILOT)
    vehicle.hear(Count(3), 0.0, STRANGER)  # then silence: the vehicle gives it up after 8 s
    air = Air(vehicle)
    air.hold(upload(Upload(items_of(ARDUPILOT, 4), ARDUPILOT)))
    assert len(vehicle.holds()) == 4
    assert air.now > 8.0


@pytest.mark.parametrize("autopilot", registered())
def test_a_lost_final_acknowledgement_is_settled_by_reading_back(autopilot: Autopilot) -> None:
    class Deaf(Air):
        def _launch(self, messages: list[Message], to_vehicle: bool) -> None:
            super()._launch([message for message in messages if to_vehicle or not isinstance(message, Ack)], to_vehicle)

    vehicle = Vehicle(autopilot)
    Deaf(vehicle).hold(upload(Upload(items_of(autopilot, 4), autopilot)))
    assert len(vehicle.holds()) == 4


@pytest.mark.parametrize("autopilot", registered())
def test_a_transfer_that_broke_off_begins_anew(autopilot: Autopilot) -> None:
    class Tunnel(Air):
        def _launch(self, messages: list[Message], to_vehicle: bool) -> None:
            super()._launch([] if 1.0 < self.now < 13.0 else messages, to_vehicle)

    vehicle = Vehicle(autopilot)
    sent = items_of(autopilot, 30)
    Tunnel(vehicle, [Fate(1, 0.05)]).hold(upload(Upload(sent, autopilot)))
    assert compare(sent, vehicle.holds(), autopilot) is None


def test_difference_of_the_read_back_is_an_error_that_names_it() -> None:
    items = items_of(PX4, 1)
    changed = items_of(PX4, 2)[1]
    offered = {
        Count: [[Request(0)], [Request(0)]],
        ItemAt: [[Ack(0)], [Ack(0)]],
        RequestList: [[Count(1)], [Count(1)]],
        Request: [[ItemAt(0, changed)], [ItemAt(0, changed)]],
    }
    with refuses("read-back-differs", "", "item 1", "NAV_TAKEOFF"):
        lead(upload(Upload(items, PX4)), offered)  # type: ignore[arg-type]


def test_a_doubtful_end_with_a_different_list_is_a_refusal() -> None:
    offered = {
        Count: [[Request(0)], [Request(0)]],
        ItemAt: [[Ack(Result.ERROR)], [Ack(Result.ERROR)]],
        RequestList: [[Count(0)], [Count(0)]],
    }
    with refuses("mission-refused", "", "item 1", "ERROR"):
        lead(upload(Upload(items_of(PX4, 1), PX4)), offered)  # type: ignore[arg-type]


def test_nobody_there_is_an_error_after_two_attempts_at_most() -> None:
    air = Air(Vehicle(PX4), [Fate(0)])
    with pytest.raises(NoAnswer):
        air.hold(upload(Upload(items_of(PX4, 3), PX4)))
    assert air.now < 30.0


def test_a_refusal_that_never_passes_is_told_in_the_end() -> None:
    refusals = {Count: [[Ack(Result.DENIED)]] * 20}
    with refuses("mission-refused", "", "DENIED"):
        lead(upload(Upload(items_of(PX4, 3), PX4)), refusals)  # type: ignore[arg-type]


# --- cancelling -----------------------------------------------------------------------------------------------------


def test_cancelled_in_mid_upload_px4_keeps_the_mission_it_had() -> None:
    vehicle = Vehicle(PX4)
    before = items_of(PX4, 4, shift=0.1)
    vehicle.store(before)
    air = Air(vehicle, [Fate(1, 0.1)])
    with refuses("cancelled", list_on_vehicle="old"):
        air.hold(upload(Upload(items_of(PX4, 30), PX4)), interrupts=interrupt_at(2.0))
    assert compare(before, vehicle.holds(), PX4) is None
    assert vehicle.transfers.deadline > 1e9  # it has ended its transfer, too


def test_a_lost_cancel_is_said_again() -> None:
    vehicle = Vehicle(PX4)
    air = Air(vehicle, [Fate(1, 0.1)] * 20 + [Fate(0)] * 3)
    with pytest.raises(Cancelled):
        air.hold(upload(Upload(items_of(PX4, 40), PX4)), interrupts=interrupt_at(2.1))
    assert vehicle.holds() == ()


def test_cancelled_in_mid_upload_ardupilot_is_given_the_whole_new_mission() -> None:
    vehicle = Vehicle(ARDUPILOT)
    vehicle.store(items_of(ARDUPILOT, 40, shift=0.1))
    sent = items_of(ARDUPILOT, 30)
    air = Air(vehicle, [Fate(1, 0.1)])
    with refuses("cancelled", list_on_vehicle="new"):
        air.hold(upload(Upload(sent, ARDUPILOT)), interrupts=interrupt_at(2.0))
    assert compare(sent, vehicle.holds(), ARDUPILOT) is None


def test_an_upload_cancelled_while_read_back_asks_which_mission_it_holds() -> None:
    class Fading(Air):
        end = 1e9

        def _launch(self, messages: list[Message], to_vehicle: bool) -> None:
            super()._launch([] if self.now > self.end else messages, to_vehicle)

    sent = items_of(PX4, 4)
    air = Air(Vehicle(PX4), [Fate(1, 0.1)])
    with refuses("cancelled", list_on_vehicle="new"):
        air.hold(upload(Upload(sent, PX4)), interrupts=interrupt_at(1.3))
    fading = Fading(Vehicle(PX4), [Fate(1, 0.1)])
    fading.end = 1.3
    with refuses("cancelled", list_on_vehicle="either"):
        fading.hold(upload(Upload(sent, PX4)), interrupts=interrupt_at(1.3))


@pytest.mark.parametrize("error", [Cancelled("cancelled"), TimeUp("the time is up")], ids=["cancelled", "late"])
def test_broken_off_while_the_verdict_is_awaited_the_new_mission_is_whole(error: MissionError) -> None:
    air = Air(Vehicle(PX4))
    with refuses(error.code) as caught:
        air.hold(upload(Upload(items_of(PX4, 4), PX4)), interrupts={1.0: error})
    assert caught.value.known["list_on_vehicle"] == "new"
    assert caught.value.hint == "its check of the mission was not awaited"


@pytest.mark.parametrize(("autopilot", "words"), [(PX4, "keeps the mission it had"), (ARDUPILOT, "a mixture")])
def test_time_that_is_up_says_how_far_it_came_and_what_the_vehicle_holds(autopilot: Autopilot, words: str) -> None:
    vehicle = Vehicle(autopilot)
    vehicle.store(items_of(autopilot, 4, shift=0.1))
    air = Air(vehicle, [Fate(1, 0.1)])
    with refuses("time-up", "", "9 of 30 items") as late:
        air.hold(upload(Upload(items_of(autopilot, 30), autopilot)), interrupts={2.1: TimeUp("the time is up")})
    assert words in str(late.value)


def test_a_download_that_takes_too_long_says_how_much_had_come() -> None:
    vehicle = Vehicle(PX4)
    vehicle.store(items_of(PX4, 30))
    with refuses("time-up", "", "9 of 30"):
        Air(vehicle, [Fate(1, 0.1)]).hold(download(MissionType.MISSION), interrupts={2.1: TimeUp("the time is up")})


@pytest.mark.parametrize("refused", [MissionType.FENCE, MissionType.RALLY, MissionType.MISSION])
@pytest.mark.parametrize("family", registered())
def test_a_refused_list_is_named_with_the_state_of_all(family: Autopilot, refused: MissionType) -> None:
    mock = BuiltInAutopilot(family, HOME)
    vehicle = meet(Connection(Loopback(Station(mock)), Codec(245, 190)), options=ConnectionOptions(fast=False))
    items = (takeoff(HOME, 10.0), waypoint(Geodetic(47.4002, 8.5), 12.0))
    receive = mock.receive

    def refuse(message: Message, source: Target, now: float) -> None:
        if isinstance(message, Count) and message.kind == refused:
            mock.vehicle.send(Ack(Result.NO_SPACE, refused), source)
        else:
            receive(message, source, now)

    mock.receive = refuse  # type: ignore[method-assign]
    fence = (FenceCircle((47.4, 8.5), 300.0),)
    with refuses("mission-refused", "", "NO_SPACE") as failed:
        vehicle.upload(Mission(HOME, items, family, fence=fence, rally=(HOME,)))
    sent = [MissionType.FENCE, MissionType.RALLY, MissionType.MISSION]
    at = sent.index(refused)
    assert [bool(mock.transfers.listed(kind)) for kind in sent] == [n < at for n in range(3)]
    states = list(failed.value.known["lists_on_vehicle"].values())
    own = "mixture" if family is ARDUPILOT and refused != MissionType.FENCE else "old"
    assert states == [*["new"] * at, own, *["old"] * (2 - at)]
    assert ("it keeps the" in str(failed.value)) is (refused != MissionType.MISSION)
    assert ("it holds the new fence" in str(failed.value)) is (refused != MissionType.FENCE)


class CutOff(BuiltInAutopilot):
    left = 1000  # messages until the link is cut

    def receive(self, message: Message, source: Target, now: float) -> None:
        self.left -= 1
        if self.left >= 0:
            super().receive(message, source, now)


@pytest.mark.parametrize("fast", [False, True])
@pytest.mark.parametrize("family", registered())
def test_a_cut_upload_never_leaves_a_new_mission_with_an_old_fence(family: Autopilot, fast: bool) -> None:
    def mission(up: float, radius: float) -> Mission:
        place = Geodetic(47.4, 8.5 + up / 1e5)
        fence = (FenceCircle((47.4, 8.5), radius),)
        return Mission(HOME, (takeoff(HOME, up), waypoint(place, up)), family, fence=fence, rally=(place,))

    new = mission(20.0, 200.0)
    lists = {
        MissionType.FENCE: stored_mission.fence_to_wire(new.fence),
        MissionType.RALLY: stored_mission.rally_to_wire(new.rally),
        MissionType.MISSION: stored_mission.to_wire(new),
    }
    states = set[tuple[bool, ...]]()
    cut_at = 0
    while (True, True, True) not in states:
        mock = CutOff(family, HOME)
        vehicle = meet(Connection(Loopback(Station(mock)), Codec(245, 190)), options=ConnectionOptions(fast=fast))
        vehicle.upload(mission(10.0, 300.0))
        mock.left = cut_at
        cut_at += 1
        known: dict[str, object] = {}
        words = ""
        try:
            vehicle.upload(new)
        except MissionError as error:
            known = error.known
            words = str(error).split("; it keeps")[0]
        named = known.get("lists_on_vehicle", {})
        assert isinstance(named, dict)
        is_new = tuple(compare(lists[kind], mock.transfers.listed(kind), family) is None for kind in lists)
        assert is_new == tuple(sorted(is_new, reverse=True)), cut_at
        assert not (is_new[-1] and "keeps" in words), cut_at
        possible = {"old": {False}, "new": {True}, "either": {False, True}, "mixture": {False, True}}
        states_and_truth = zip(named.values(), is_new if named else (), strict=True)
        assert all(held in possible[state] for state, held in states_and_truth), named
        states.add(is_new)
    assert states == {(n > 0, n > 1, n > 2) for n in range(4)}
