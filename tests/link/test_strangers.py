from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import reconnect
from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import EVERYONE, Codec, Target, read_tlog
from ipoa_mission.link.connect import connect, meet
from ipoa_mission.link.connection import CAUSE_S, Connection
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.messages import NO_AUTOPILOT, Ack, Count, Heartbeat, Message, MissionType, Ping, Result
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.mission.items import Mission, takeoff, waypoint
from ipoa_mission.mission.stored_mission import compare, to_wire
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.suited import suited
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), *(waypoint(Geodetic(47.4 + 1e-5 * n, 8.5), 12.0) for n in range(30))))
PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
US, VEHICLE = Target(245, 190), Target(1, 1)


class Net:
    """A channel to several ends with addresses; a frame takes 10 ms."""

    def __init__(self, **ends: Station) -> None:
        self.ends = ends
        self.strangers: list[Callable[[float], list[tuple[bytes, Peer]]]] = []
        self.cut = 0
        self._now = 0.0
        self._coming: list[tuple[bytes, Peer]] = []

    def now(self) -> float:
        return self._now

    def unix_s(self) -> float:
        return 1_767_225_600.0 + self._now

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        while not self._coming and self._now < until:
            self._now = min(until, self._now + 0.01)
            for address, end in self.ends.items():
                end.tick(self._now)
                self._coming += [(data, address) for data, peer in end.outgoing() if peer in ("us", None)]
            for stranger in self.strangers:
                self._coming += stranger(self._now)
        coming, self._coming = self._coming, []
        size = self.cut or 1000
        return [(data[at : at + size], peer) for data, peer in coming for at in range(0, len(data), size)]

    def send(self, data: bytes, peer: Peer | None) -> None:
        for address, end in self.ends.items():
            if peer in (address, None):
                for at in range(0, len(data), self.cut or 1000):
                    end.receive(data[at : at + (self.cut or 1000)], "us", self._now)

    def close(self) -> None:
        return None


def station(family: Autopilot = PX4, system: int = 1) -> Station:
    return Station(Mock(family, HOME), system)


def stored_count(net: Net, address: str) -> int:
    return len(net.ends[address].autopilot.transfers.listed(MissionType.MISSION))


def connection_on(net: Net) -> Connection:
    return Connection(net, Codec(*US))


def is_exact(net: Net, address: str, family: Autopilot = PX4) -> bool:
    listed = net.ends[address].autopilot.transfers.listed(MissionType.MISSION)
    return compare(to_wire(replace(MISSION, autopilot=family)), listed, family) is None


# --- two vehicles with one system id --------------------------------------------------------------------------------


@pytest.mark.parametrize("system", [None, 1])
def test_two_vehicles_with_one_system_id_are_told_and_refused(system: int | None) -> None:
    net = Net(one=station(), other=station(ARDUPILOT))
    with refuses("contested", "", "system id 1") as caught:
        meet(connection_on(net), system)
    assert "MAV_SYS_ID" in str(caught.value.hint)
    assert (stored_count(net, "one"), stored_count(net, "other")) == (0, 0)


def test_forced_link_speaks_only_to_the_first_of_two(caplog: pytest.LogCaptureFixture) -> None:
    net = Net(one=station(), other=station())
    connection = connection_on(net)
    vehicle = meet(connection, options=ConnectionOptions(anyway=True))
    vehicle.upload(suited(vehicle, MISSION))
    assert connection.contested(1)
    assert is_exact(net, "one")
    assert stored_count(net, "other") == 0
    before = net.ends["other"].autopilot.vehicle.mode
    vehicle.prepare()
    assert net.ends["one"].autopilot.vehicle.mode == PX4.modes.arming
    assert net.ends["other"].autopilot.vehicle.mode == before
    assert [record.message for record in caplog.records] == [
        "another vehicle with system id 1 is on the link; it is not listened to"
    ]


def test_a_vehicle_that_moves_to_another_address_is_no_second_one() -> None:
    net = Net(one=station())
    connection = connection_on(net)
    meet(connection)
    net.ends = {"elsewhere": net.ends["one"]}
    until = net.now() + 20.0
    while net.now() < until:
        connection.receive(until)
        assert not connection.contested(1)
    meet(connection).upload(MISSION)
    assert is_exact(net, "elsewhere")


def test_vehicles_with_ids_of_their_own_are_not_contested() -> None:
    connection = connection_on(Net(one=station(), other=station(ARDUPILOT, 2)))
    assert meet(connection, 2).autopilot is ARDUPILOT
    assert not connection.contested(1)
    assert not connection.contested(2)
    assert connection._routes.heard_s(Target(9, 1)) is None
    assert connection._routes.heard_s(VEHICLE) == pytest.approx(connection.channel.now(), abs=1.1)


# --- made-up ids and forged answers ---------------------------------------------------------------------------------


def saying(message: Message, names: list[Target], peer: str = "mallory") -> Callable[[float], list[tuple[bytes, Peer]]]:
    voices = [Codec(*name) for name in names]
    return lambda now: [(voice.encode(message, EVERYONE, now), peer) for voice in voices]


@pytest.mark.parametrize("family", registered())
def test_forty_made_up_ids_do_not_come_between(family: Autopilot) -> None:
    net = Net(one=station(family))
    connection = connection_on(net)
    vehicle = meet(connection)
    net.strangers.append(saying(Heartbeat(2, 12), [Target(system, 1) for system in range(2, 42)]))
    vehicle.upload(suited(vehicle, MISSION))
    assert is_exact(net, "one", family)
    assert len(vehicle.download().items) == len(MISSION.items)


@pytest.mark.parametrize("family", registered())
def test_forty_made_up_stations_do_not_come_between(family: Autopilot) -> None:
    net = Net(one=station(family))
    beats = [Codec(system, 190).encode(Heartbeat(6, NO_AUTOPILOT), EVERYONE, 0.0) for system in range(100, 140)]

    def flood(now: float) -> list[tuple[bytes, Peer]]:
        for n, beat in enumerate(beats):
            net.ends["one"].receive(beat, f"mallory {n}", now)
        return []

    vehicle = meet(connection_on(net))
    vehicle.home()
    net.strangers.append(flood)
    vehicle.upload(suited(vehicle, MISSION))
    assert is_exact(net, "one", family)
    assert "us" in net.ends["one"]._routes.to(US)


@pytest.mark.parametrize("forged", [Ack(Result.DENIED), Ack(Result.ACCEPTED), Count(3)])
def test_messages_of_a_stranger_in_the_vehicle_s_name_are_not_heard(forged: Message) -> None:
    net = Net(one=station())
    vehicle = meet(connection_on(net))
    net.strangers.append(saying(forged, [VEHICLE]))
    vehicle.upload(suited(vehicle, MISSION))
    assert is_exact(net, "one")


# --- stations with our ids ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", registered())
def test_another_station_with_our_ids_does_not_hide_the_built_in_autopilot(family: Autopilot) -> None:
    net = Net(one=station(family))
    beat, twin = Codec(*US).encode(Heartbeat(6, NO_AUTOPILOT), EVERYONE, 0.0), 0.0
    for _ in range(20):  # it was there before us
        net.ends["one"].receive(beat, "twin", twin)

    def twin_beats(now: float) -> list[tuple[bytes, Peer]]:
        net.ends["one"].receive(beat, "twin", now)
        return []

    net.strangers.append(twin_beats)
    vehicle = meet(connection_on(net))
    vehicle.upload(suited(vehicle, MISSION))
    assert is_exact(net, "one", family)
    assert net.ends["one"]._routes.to(US) == {"us", "twin"}


def test_an_answer_reaches_both_stations_with_the_same_ids() -> None:
    single = station()
    for peer in ("us", "twin"):
        single.receive(Codec(*US).encode(Heartbeat(6, NO_AUTOPILOT), EVERYONE, 0.0), peer, 0.0)
    single.receive(Codec(*US).encode(Ping(1, 0), EVERYONE, 0.0), "us", 0.0)
    assert {peer for _, peer in single.outgoing()} == {"us", "twin"}


# --- torn frames and an old protocol --------------------------------------------------------------------------------


@pytest.mark.parametrize("family", registered())
def test_frames_that_are_cut_at_sixteen_bytes_are_heard(family: Autopilot) -> None:
    net = Net(one=station(family))
    net.cut = 16
    vehicle = meet(connection_on(net))
    vehicle.upload(suited(vehicle, MISSION))
    assert is_exact(net, "one", family)


class Drip(Net):
    """Reads sixteen bytes at a time."""

    _kept = b""

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        self._kept = self._kept or b"".join(data for data, _ in super().receive(until))
        piece, self._kept = self._kept[:16], self._kept[16:]
        return [(piece, "one")] if piece else []


@pytest.mark.parametrize("family", registered())
def test_a_stream_that_comes_in_pieces_is_heard(family: Autopilot) -> None:
    net = Drip(one=station(family))
    vehicle = meet(connection_on(net), options=ConnectionOptions(fast=False))
    vehicle.upload(suited(vehicle, MISSION))
    assert is_exact(net, "one", family)
    assert len(vehicle.download().items) == len(MISSION.items)


def test_messages_to_others_and_unread_messages_are_logged_only(tmp_path: Path) -> None:
    vehicle = Codec(*VEHICLE)
    ours, theirs = (vehicle.encode(Count(n), to, 0.0) for n, to in enumerate((US, Target(255, 190))))
    unread = dialect.MAVLink_meminfo_message(0, 0).pack(dialect.MAVLink(None, *VEHICLE))
    net = Net()
    net.strangers.append(lambda now: [(frame, "one") for frame in (theirs, unread, ours)])
    with Connection(net, Codec(*US), tmp_path / "all.tlog") as connection:
        assert [message.message for message in connection.receive(1.0)] == [Count(0)]
    logged = [record.frame for record in read_tlog(tmp_path / "all.tlog")]
    assert [frame for frame in logged if frame in (theirs, unread, ours)] == [theirs, unread, ours]


class OldOnly:
    """A vehicle of MAVLink 1: it beats, or answers all in MAVLink 1; `tells_home`: it streams HOME_POSITION."""

    def __init__(self, station: Station | None = None, tells_home: bool = False) -> None:
        self._station, self._tells_home = station, tells_home
        self._voice = dialect.MAVLink(None, 1, 1)
        self._next_beat = 0.0
        self._is_due = False

    def receive(self, data: bytes, peer: Peer, now: float) -> None:
        if self._station:
            self._station.receive(data, peer, now)

    def tick(self, now: float) -> None:
        if self._station:
            self._station.tick(now)
        self._is_due = now >= self._next_beat
        self._next_beat = now + 1.0

    def outgoing(self) -> list[tuple[bytes, Peer | None]]:
        if self._station:
            frames = [(frame, peer) for frame, peer in self._station.outgoing()]
            return [(self._in_old_words(frame), peer) for frame, peer in frames]
        if not self._is_due:
            return []
        self._is_due = False
        beat = dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3)
        messages = [beat]
        if self._tells_home:
            messages.append(
                dialect.MAVLink_home_position_message(int(47.4e7), int(8.5e7), 400_000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
            )
        return [(message.pack(self._voice, force_mavlink1=True), None) for message in messages]

    def _in_old_words(self, frame: bytes) -> bytes:
        (message,) = dialect.MAVLink(None).parse_buffer(frame) or [None]
        return bytes(message.pack(self._voice, force_mavlink1=True)) if message.get_msgId() < 256 else frame

    @property
    def deadline(self) -> float:
        return self._station.deadline if self._station else self._next_beat


@pytest.mark.parametrize("tells_home", [False, True])
def test_a_vehicle_of_mavlink_1_only_is_named_after_some_seconds(tells_home: bool) -> None:
    connection = Connection(Loopback(OldOnly(tells_home=tells_home)), Codec(*US))
    vehicle = meet(connection)
    if tells_home:
        assert vehicle.home() is not None
    began = connection.channel.now()
    with refuses("speaks-mavlink1", "", "vehicle 1") as caught:
        vehicle.upload(suited(vehicle, MISSION))
    assert "MAV_PROTO_VER 2" in str(caught.value.hint)
    assert connection.channel.now() - began <= CAUSE_S + 1.0


def test_a_vehicle_that_answers_in_mavlink_1_is_spoken_to_as_any_other() -> None:
    connection = Connection(Loopback(OldOnly(station())), Codec(*US))
    vehicle = meet(connection)
    vehicle.upload(suited(vehicle, MISSION))
    assert vehicle.parameters(["MPC_XY_CRUISE", "NO_SUCH_NAME"]).keys() == {"MPC_XY_CRUISE"}


# --- the other side goes away ---------------------------------------------------------------------------------------


def test_connection_closed_in_flight_reports_when_last_heard(
    run_mock: Callable[..., object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reconnect, "GIVE_UP_S", 1.5)
    with run_mock(PX4, 20.0, "tcpin") as running:  # type: ignore[attr-defined]
        vehicle = connect(f"tcp:127.0.0.1:{running.port}")
        vehicle.upload(suited(vehicle, MISSION))
        vehicle.prepare()
        vehicle.start()
    with vehicle, refuses("link-lost", "", "1.5", kind=NoAnswer) as lost:
        vehicle.watch()
    assert lost.value.hint is not None
    assert "when last heard, the vehicle is armed" in lost.value.hint
