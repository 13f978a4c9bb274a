"""A vehicle on a link: search, limits of time, start-up, preparation."""

from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import connect as connecting
from ipoa_mission.link import vehicle as verbs
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import connect, meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import NoAnswer, TimeUp
from ipoa_mission.link.messages import AutopilotVersion, Message, MissionType, Request
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Faults, Loopback, Station
from tests.link.suited import HOME, MISSION, RALLY, met, suited
from tests.link_pair import connection_of
from tests.refused import refuses


def test_every_end_of_the_search_for_a_vehicle_closes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Open(Connection):
        is_closed = False

        def close(self) -> None:
            self.is_closed = True

    connection = Open(Loopback(Station(Mock(Autopilot.PX4, HOME))), Codec(245, 190))
    monkeypatch.setattr(connecting, "open_connection", lambda *_: connection)
    with refuses("not-heard", "udpin:127.0.0.1:0", "system id 9", kind=NoAnswer):
        connect("udpin:127.0.0.1:0", system=9)
    assert connection.is_closed
    monkeypatch.setattr(connection, "receive", lambda until: (_ for _ in ()).throw(LinkDown("gone")))
    connection.is_closed = False
    with refuses("link-down", "", "gone"):
        connect("udpin:127.0.0.1:0")
    assert connection.is_closed


def test_an_arducopter_that_never_ends_its_start_up_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = met(Autopilot.ARDUPILOT, conditions=Conditions(cold=True))
    monkeypatch.setattr(verbs, "STARTUP_S", 0.3)
    with refuses("not-started-up", kind=NoAnswer):
        vehicle.download()


def test_running_order_ends_after_its_time() -> None:
    slow = Faults(delay_s=0.2)
    connection = Connection(Loopback(Station(Mock(Autopilot.PX4, HOME)), slow), Codec(245, 190))
    vehicle = meet(connection)
    vehicle.give_up_after(0.3)
    with pytest.raises(TimeUp):
        vehicle.download()
    assert connection.now() < 3.0


def test_an_arducopter_is_asked_once_whether_it_takes_a_file() -> None:
    vehicle = met(Autopilot.ARDUPILOT)
    heard: list[Message] = []
    vehicle.overhearing = heard.append
    for _ in range(2):
        vehicle.upload(suited(vehicle, MISSION))
        assert vehicle.download().rally == RALLY
    assert sum(isinstance(message, AutopilotVersion) for message in heard) == 1
    assert not any(isinstance(message, Request) and message.kind == MissionType.MISSION for message in heard)


def test_a_vehicle_that_is_armed_is_not_on_the_ground_to_be_prepared() -> None:
    vehicle = met(Autopilot.PX4)
    vehicle.upload(suited(vehicle, replace(MISSION, rally=())))
    vehicle.prepare()
    vehicle.start()
    with pytest.raises(NotReady):
        vehicle.state.expect_on_ground()


@pytest.mark.parametrize("autopilot", registered())
def test_vehicle_with_another_sessions_mission_is_prepared(autopilot: Autopilot) -> None:
    before = met(autopilot)
    before.upload(suited(before, MISSION))
    vehicle = meet(connection_of(before))
    places: list[Geodetic] = []

    def forbid(place: Geodetic) -> None:
        places.append(place)
        raise NotReady("not from here")

    with refuses("not-ready", "", "not from here"):
        vehicle.prepare(permit=forbid)
    (place,) = places
    assert (place.latitude_deg, place.longitude_deg) == pytest.approx((HOME.latitude_deg, HOME.longitude_deg), abs=1e-4)
    vehicle.prepare()
    vehicle.start()
    assert vehicle.state.armed


@pytest.mark.parametrize("autopilot", registered(), ids=str)
def test_set_current_item_is_reported_by_the_vehicle(autopilot: Autopilot) -> None:
    vehicle = met(autopilot)
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.set_current(1)
    vehicle.home()  # meanwhile it reports its current item
    assert vehicle.state.current is not None
    assert vehicle.state.current.seq == 1 + autopilot.seq_offset
