import math
import threading
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import Address, LinkDown, Transport, UdpChannel, open_channel, parse_address
from ipoa_mission.link.codec import EVERYONE, Codec, Heard, Target, TlogWriter, read_tlog
from ipoa_mission.link.connect import connect, meet, open_connection
from ipoa_mission.link.connection import CLAIM_S, MAX_PEERS, Connection, MessageLink, Routes
from ipoa_mission.link.dialogue import SPECIFIED, NoAnswer
from ipoa_mission.link.discovery import scan, version_of
from ipoa_mission.link.messages import AutopilotVersion, CommandLong, Heartbeat, Message, MissionType, Text
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Faults, Loopback, Station
from tests.link.suited import suited
from tests.link_pair import connection_of, far_end, port_of
from tests.px4_waypoints import waypoint
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
THERE = Geodetic(47.4002, 8.5)
MISSION = Mission(HOME, (takeoff(HOME, 5.0), waypoint(THERE, 5.0), land(THERE)))

ADDRESSES = [
    ("udpin:127.0.0.1:14550", Address(Transport.UDP_IN, "127.0.0.1", 14550)),
    ("udpin://127.0.0.1:14550", Address(Transport.UDP_IN, "127.0.0.1", 14550)),
    ("udp:0.0.0.0:14540", Address(Transport.UDP_IN, "0.0.0.0", 14540)),
    ("udpout:10.0.0.2:14550", Address(Transport.UDP_OUT, "10.0.0.2", 14550)),
    ("udpin::14550", Address(Transport.UDP_IN, "127.0.0.1", 14550)),
    ("udpin://:14550/", Address(Transport.UDP_IN, "127.0.0.1", 14550)),
    ("udpin:[::1]:14550", Address(Transport.UDP_IN, "::1", 14550)),
    ("tcp:sitl.local:5760", Address(Transport.TCP_OUT, "sitl.local", 5760)),
    ("tcpout://127.0.0.1:5760", Address(Transport.TCP_OUT, "127.0.0.1", 5760)),
    ("tcpin:127.0.0.1:0", Address(Transport.TCP_IN, "127.0.0.1", 0)),
    ("serial:/dev/ttyUSB0:921600", Address(Transport.SERIAL, device="/dev/ttyUSB0", baud=921600)),
    ("serial:///dev/ttyACM0", Address(Transport.SERIAL, device="/dev/ttyACM0", baud=57600)),
    ("serial:COM3:57600", Address(Transport.SERIAL, device="COM3", baud=57600)),
]


@pytest.mark.parametrize(("url", "address"), ADDRESSES, ids=[url for url, _ in ADDRESSES])
def test_both_spellings_of_a_connection_are_understood(url: str, address: Address) -> None:
    assert parse_address(url) == address
    assert parse_address(str(address).replace("::1", "[::1]")) == address


@pytest.mark.parametrize(
    "url",
    [
        *("", "udpin", "udpin:127.0.0.1", "http://x:80", "udpin:a:b", "tcp:1:2:3", "udpin:x:99999", "udpin::١٤٥٥٠"),
        *(f"udpin:127.0.0.1:{'9' * 5000}", f"serial:/dev/ttyS0:{'9' * 5000}"),
    ],
)
def test_wrong_connections_are_refused_with_an_example(url: str) -> None:
    with refuses("bad-input", "link"):
        parse_address(url)


def test_nobody_at_the_other_end_is_an_error_that_says_so() -> None:
    with UdpChannelClosed() as port, refuses("link-not-opened", f"tcp:127.0.0.1:{port}", kind=LinkDown):
        open_channel(f"tcp:127.0.0.1:{port}")
    with refuses("link-not-opened", "serial:/dev/no-such-port:57600", kind=LinkDown):
        open_channel("serial:/dev/no-such-port")


class UdpChannelClosed:
    def __enter__(self) -> int:
        channel = UdpChannel(parse_address("udpin:127.0.0.1:0"))
        port = port_of(channel)
        channel.close()
        return port

    def __exit__(self, *about: object) -> None:
        return None


def test_a_port_in_use_is_an_error_with_a_hint() -> None:
    channel = UdpChannel(parse_address("udpin:127.0.0.1:0"))
    try:
        with refuses("link-not-opened", f"udpin:127.0.0.1:{port_of(channel)}", kind=LinkDown) as down:
            open_channel(f"udpin:127.0.0.1:{port_of(channel)}")
        assert down.value.hint == "is another ground station using it?"
    finally:
        channel.close()


@pytest.mark.parametrize(
    ("family", "transport", "url"),
    [(Autopilot.PX4, "udpin", "udpout:127.0.0.1:{}"), (Autopilot.ARDUPILOT, "tcpin", "tcp:127.0.0.1:{}")],
)
def test_a_whole_session_over_real_sockets(
    family: Autopilot, transport: str, url: str, run_mock: Callable[..., object], tmp_path: Path
) -> None:
    log = tmp_path / "session.tlog"
    with (
        run_mock(family, 100.0, transport) as running,  # type: ignore[attr-defined]
        connect(url.format(running.port), log=str(log)) as vehicle,
    ):
        assert vehicle.autopilot is family
        vehicle.upload(suited(vehicle, replace(MISSION, items=MISSION.items[:2])))
        assert len(vehicle.download().items) == 2
        name = "WPNAV_SPEED" if family is Autopilot.ARDUPILOT else "MPC_XY_CRUISE"
        assert vehicle.parameters([name, "NO_SUCH_NAME"]) == {name: running.mock.table.values[name]}
        vehicle.prepare()
        vehicle.start()
        record = vehicle.watch()
        assert record.why_not == "the mission ends in the air"
        vehicle.clear()
    assert len(list(read_tlog(log))) > 50


def test_a_vehicle_that_is_not_there_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ipoa_mission.link.connect.PRESENCE_S", 0.2)
    with refuses("not-heard", "udpin:127.0.0.1:0", kind=NoAnswer):
        connect("udpin:127.0.0.1:0")


@pytest.mark.parametrize("family", registered())
def test_an_upload_ends_when_the_user_s_patience_does(family: Autopilot) -> None:
    slow = Faults(delay_s=0.2)
    connection = Connection(Loopback(Station(Mock(family, HOME)), slow), Codec(245, 190))
    vehicle = meet(connection, options=ConnectionOptions(retry_policy=replace(SPECIFIED, total_s=5.0), fast=False))
    begun = connection.channel.now()
    legs = (waypoint(Geodetic(47.4 + 1e-5 * n, 8.5), 12.0) for n in range(50))
    with refuses("time-up", "", "attempt 1") as late:
        vehicle.upload(suited(vehicle, Mission(HOME, (takeoff(HOME, 10.0), *legs))))
    assert connection.channel.now() == pytest.approx(begun + 5.0, abs=0.1)
    assert ("keeps" if family is Autopilot.PX4 else "mixture") in str(late.value)
    vehicle.upload(suited(vehicle, MISSION))  # the next one has its own five seconds


# --- several vehicles -----------------------------------------------------------------------------------------------


class Flock:
    def __init__(self, *stations: Station) -> None:
        self._stations = stations

    def receive(self, data: bytes, peer: object, now: float) -> None:
        for station in self._stations:
            station.receive(data, peer, now)

    def tick(self, now: float) -> None:
        for station in self._stations:
            station.tick(now)

    def outgoing(self) -> list[tuple[bytes, object]]:
        return [sent for station in self._stations for sent in station.outgoing()]

    @property
    def deadline(self) -> float:
        return min(station.deadline for station in self._stations)


def flock(*systems: int) -> Connection:
    families = list(registered())
    stations = [Station(Mock(families[n % 2], HOME), system) for n, system in enumerate(systems)]
    return Connection(Loopback(Flock(*stations)), Codec(245, 190))


def test_a_scan_finds_every_vehicle_on_the_link() -> None:
    assert [(vehicle.system, vehicle.kind.autopilot) for vehicle in scan(flock(3, 1, 7))] == [
        (1, Autopilot.ARDUPILOT),
        (3, Autopilot.PX4),
        (7, Autopilot.PX4),
    ]


def test_a_scan_asks_for_versions_and_does_not_wait_for_the_silent() -> None:
    connection = flock(1, 2, 3)
    one, _, three = (station.autopilot for station in far_end(connection)._stations)
    receive = three.receive
    three.receive = lambda message, *rest: None if isinstance(message, CommandLong) else receive(message, *rest)
    systems = [vehicle.system for vehicle in scan(connection)]
    begun = connection.now()
    versions = [version_of(connection, system) for system in systems]
    assert systems == [1, 2, 3]
    assert versions == [Autopilot.PX4.newest, Autopilot.ARDUPILOT.newest, None]
    assert connection.now() - begun == pytest.approx(3.0, abs=0.5)
    message = one.vehicle.message
    one.vehicle.message = lambda name: AutopilotVersion(0) if name == "AUTOPILOT_VERSION" else message(name)
    assert [version_of(connection, system) for system in (1, 2)] == [None, Autopilot.ARDUPILOT.newest]
    assert connection.now() - begun < 4.0


def test_one_of_several_vehicles_is_chosen_by_its_system_id() -> None:
    with refuses("several-vehicles", "", "1 (PX4 multicopter), 2 (ArduPilot multicopter)"):
        meet(flock(1, 2))
    with refuses("not-heard", "", "system id 9", "heard: 1, 2", kind=NoAnswer):
        meet(flock(1, 2), system=9)
    connection = flock(1, 2)
    vehicle = meet(connection, system=2)
    vehicle.upload(suited(vehicle, MISSION))
    stored = [station.autopilot.transfers.listed(MissionType.MISSION) for station in far_end(connection)._stations]
    assert [len(items) for items in stored] in ([0, 4], [0, 3], [3, 0], [4, 0])
    assert stored[0] == ()


def test_ardupilot_is_given_time_to_start_up() -> None:
    station = Station(Mock(Autopilot.ARDUPILOT, HOME, conditions=Conditions(cold=True)))
    vehicle = meet(Connection(Loopback(station), Codec(245, 190)))
    vehicle.upload(suited(vehicle, MISSION))
    assert connection_of(vehicle).channel.now() >= 3.0


# --- routes and logs ------------------------------------------------------------------------------------------------


ALICE, BOB = Target(245, 190), Target(255, 230)


def test_an_answer_goes_only_where_the_question_came_from() -> None:
    routes = Routes()
    routes.learn(ALICE, "alice", 0.0)
    routes.learn(BOB, "bob", 0.0)
    assert routes.to(BOB) == {"bob"}
    assert routes.to(EVERYONE) == {"alice", "bob"}


def test_stations_with_the_same_ids_all_get_answers_until_one_is_silent() -> None:
    routes = Routes()
    routes.learn(ALICE, "alice", 0.0)
    routes.learn(ALICE, "her twin", 1.0)
    assert routes.to(ALICE) == {"alice", "her twin"}
    routes.learn(ALICE, "her twin", CLAIM_S)
    routes.learn(ALICE, "alice moved", CLAIM_S)
    assert routes.to(ALICE) == {"her twin", "alice moved"}


def test_a_stranger_cannot_take_over_a_name_that_is_claimed() -> None:
    routes = Routes()
    assert routes.claim(ALICE, "alice", 0.0)
    assert not routes.claim(ALICE, "mallory", 1.0)
    assert routes.claim(ALICE, "alice", 2.0)
    assert routes.holder(ALICE) == "alice"
    assert routes.claim(ALICE, "alice moved", 2.0 + CLAIM_S)


def test_a_flood_of_peers_does_not_grow_without_bound() -> None:
    routes = Routes()
    for n in range(1000):
        routes.learn(Target(n % 256, n // 256), f"peer {n}", float(n))
        routes.frames(b"", f"peer {n}")
    assert len(routes.to(EVERYONE)) == MAX_PEERS
    assert len(routes._framers) == MAX_PEERS


def test_made_up_ids_do_not_evict_whom_we_speak_to() -> None:
    routes = Routes()
    routes.learn(BOB, "bob", 0.0)
    routes.to(BOB)
    for n in range(400):
        routes.learn(Target(1 + n % 40, 1), "mallory", 0.01 * n)
    assert routes.to(BOB) == {"bob"}
    for n in range(100):  # nor by taking the name itself
        routes.learn(BOB, f"mallory {n}", 4.0 + 0.001 * n)
    assert "bob" in routes.to(BOB)


def test_a_log_is_read_back_and_a_torn_record_is_passed_over(tmp_path: Path) -> None:
    path, codec = tmp_path / "a.tlog", Codec(1, 1)
    sent = [codec.encode(Text(3, f"words {n}"), EVERYONE, 0.0) for n in range(5)]
    with closing(TlogWriter(path)) as log:
        for n, frame in enumerate(sent):
            log.write(frame, 1_767_225_600.25 + n)
    records = list(read_tlog(path))
    assert [(record.unix_s, record.frame) for record in records] == [
        (1_767_225_600.25 + n, frame) for n, frame in enumerate(sent)
    ]
    data = path.read_bytes()
    path.write_bytes(data[:40] + data[45:-3])
    assert [record.frame for record in read_tlog(path)][-2:] == sent[2:4]
    with refuses("unreadable", "none.tlog"):
        list(read_tlog(tmp_path / "none.tlog"))
    with refuses("unwritable", "folder.tlog"):
        TlogWriter(tmp_path / "no" / "folder.tlog")
    with refuses("unwritable", "", "NUL"):
        TlogWriter("no\0name.tlog")


def test_a_garbled_peer_does_not_disturb_a_session(run_mock: Callable[..., object]) -> None:
    with run_mock(Autopilot.PX4, 60.0) as running:  # type: ignore[attr-defined]
        noise = UdpChannel(parse_address(f"udpout:127.0.0.1:{running.port}"))
        stop = threading.Event()

        def babble() -> None:
            while not stop.wait(0.001):
                noise.send(b"\xfd\xff\x00garbage" * 20, None)

        thread = threading.Thread(target=babble)
        thread.start()
        try:
            with connect(f"udpout:127.0.0.1:{running.port}") as vehicle:
                vehicle.upload(suited(vehicle, MISSION))
        finally:
            stop.set()
            thread.join()
            noise.close()


def test_our_own_heartbeat_goes_out_every_second() -> None:
    connection = flock(1)
    heard: list[float] = []
    far_end(connection)._stations[0].autopilot.receive = lambda message, source, now: (
        heard.append(now) if isinstance(message, Heartbeat) else None
    )
    while connection.channel.now() < 5.0:
        connection.receive(5.0)
    assert len(heard) in (5, 6)


def test_a_connection_opens_for_listening_alone() -> None:
    with open_connection("udpin:127.0.0.1:0") as connection:
        assert connection.receive(connection.channel.now()) == []


class Hidden(MessageLink):
    """A link that hides its peers, as MAVSDK's."""

    def now(self) -> float:
        return 0.0

    def send(self, message: Message, target: Target = EVERYONE) -> None: ...

    def receive(self, until: float) -> list[Heard]:
        return []

    def close(self) -> None: ...


def test_a_link_that_hides_its_peers_gives_no_cause_and_is_not_reopened() -> None:
    link = Hidden()
    link.note_answer(EVERYONE)
    link.expect_alone(1)
    link.reopen()
    assert link.no_reply_cause(EVERYONE) is None
    assert not link.reopens


def test_two_ends_that_wait_for_each_other_for_ever_are_an_error() -> None:
    class Silent:
        deadline = math.inf

        def receive(self, data: bytes, peer: object, now: float) -> None: ...

        def tick(self, now: float) -> None: ...

        def outgoing(self) -> list[tuple[bytes, object]]:
            return []

    with pytest.raises(RuntimeError, match="both ends wait, and neither"):
        Loopback(Silent()).receive(math.inf)
