from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import MULTICOPTERS, Autopilot, VehicleKind, class_name, with_article
from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import Codec, Target, frames
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import wait
from ipoa_mission.link.discovery import scan
from ipoa_mission.link.messages import Count, Heartbeat, Message
from ipoa_mission.link.vehicle import ConnectionOptions, Vehicle
from ipoa_mission.link.vehicle_state import NotFlown
from ipoa_mission.mission.items import Mission, takeoff, waypoint
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
MISSION = Mission(HOME, (takeoff(HOME, 20.0), waypoint(HOME, 30.0)), Autopilot.ARDUPILOT)
OTHERS = [(3, 1), (3, 4), (3, 10), (3, 12), (3, 5), (12, 1), (12, 4), (12, 20), (0, 7), (0, 2), (4, 2)]
CHANGES: dict[str, Callable[[Vehicle], object]] = {
    "upload": lambda vehicle: vehicle.upload(MISSION),
    "upload_items": lambda vehicle: vehicle.upload_items((), 0),
    "clear": lambda vehicle: vehicle.clear(),
    "set_current": lambda vehicle: vehicle.set_current(0),
    "pause": lambda vehicle: vehicle.pause(),
    "resume": lambda vehicle: vehicle.resume(),
    "return_to_launch": lambda vehicle: vehicle.return_to_launch(),
    "prepare": lambda vehicle: vehicle.prepare(),
    "set_parameter": lambda vehicle: vehicle.set_parameter("FENCE_ENABLE", 0.0),
}


def test_classes_of_vehicles_are_named_in_words() -> None:
    assert [class_name(mav_type) for mav_type in (1, 13, 18)] == ["plane", "multicopter", "vehicle of MAV_TYPE 18"]
    assert [with_article(name) for name in ("airship", "PX4 VTOL")] == ["an airship", "a PX4 VTOL"]


class Disguised(Mock):
    def __init__(self, family: Autopilot, firmware: int, mav_type: int) -> None:
        super().__init__(family, HOME)
        self.kind_sent = firmware, mav_type

    def outgoing(self) -> list[tuple[Message, Target]]:
        firmware, mav_type = self.kind_sent
        return [
            (replace(message, autopilot=firmware, type=mav_type) if isinstance(message, Heartbeat) else message, to)
            for message, to in super().outgoing()
        ]


class Overheard(Loopback):
    """Keeps our messages; after `turning`, the vehicle says another kind."""

    def __init__(self, far: Any) -> None:
        super().__init__(far)
        self.sent: list[Message] = []
        self.turning: tuple[object, tuple[int, int]] | None = None
        self.sent_since: list[Message] = []  # since that was heard
        self._is_other = False

    def receive(self, until: float) -> list[tuple[bytes, Any]]:
        got = super().receive(until)
        beats = [message for data, _ in got for message in _messages(data) if isinstance(message, Heartbeat)]
        kind = None if self.turning is None else self.turning[1]
        self._is_other |= any((beat.autopilot, beat.type) == kind for beat in beats)
        return got

    def send(self, data: bytes, peer: Any) -> None:
        messages = _messages(data)
        self.sent += messages
        self.sent_since += messages if self._is_other else []
        super().send(data, peer)
        if self.turning and any(self.turning[0] in (type(each), getattr(each, "command", None)) for each in messages):
            self.far.autopilot.kind_sent = self.turning[1]  # type: ignore[attr-defined]


def _messages(data: bytes) -> list[Message]:
    heard = [Codec(1, 1).decode(frame) for frame in frames(data)]
    return [message.message for message in heard if message is not None and message.message is not None]


def connection_to(firmware: int, mav_type: int) -> tuple[Connection, Overheard]:
    family = Autopilot.ARDUPILOT if firmware == 3 else Autopilot.PX4
    channel = Overheard(Station(Disguised(family, firmware, mav_type)))
    return Connection(channel, Codec(245, 190)), channel


@pytest.mark.parametrize(("firmware", "mav_type"), OTHERS)
def test_other_kinds_are_refused_by_name_and_sent_only_heartbeats(firmware: int, mav_type: int) -> None:
    connection, channel = connection_to(firmware, mav_type)
    with refuses("not-flown", "", "vehicle 1", str(VehicleKind(firmware, mav_type))):
        meet(connection)
    assert {type(message) for message in channel.sent} == {Heartbeat}


@pytest.mark.parametrize("verb", CHANGES)
@pytest.mark.parametrize(("firmware", "mav_type"), [(3, 1), (12, 20), (0, 2)])
def test_other_kinds_can_be_read_and_not_changed(firmware: int, mav_type: int, verb: str) -> None:
    connection, channel = connection_to(firmware, mav_type)
    vehicle = meet(connection, options=ConnectionOptions(fast=False, reading=True))
    vehicle.download_items(0)
    channel.sent.clear()
    with refuses("not-flown"):
        CHANGES[verb](vehicle)
    assert {type(message) for message in channel.sent} <= {Heartbeat}


@pytest.mark.parametrize("mav_type", sorted(MULTICOPTERS))
def test_every_multicopter_is_taken(mav_type: int) -> None:
    connection, _ = connection_to(3, mav_type)
    meet(connection).upload(MISSION)


def test_one_that_turns_out_to_be_something_else_is_refused_from_there_on() -> None:
    """Two vehicles with one id, one after the other, or by turns."""
    connection, channel = connection_to(3, 2)
    vehicle = meet(connection, options=ConnectionOptions(fast=False))
    vehicle.upload(MISSION)
    for kind in ((3, 1), (3, 2)):
        channel.far.autopilot.kind_sent = kind  # type: ignore[attr-defined]
        vehicle._run(wait(3.0))
        with refuses("other-kind", "", "ArduPilot plane", "ArduPilot multicopter", kind=NotFlown):
            vehicle.upload(MISSION)
        with pytest.raises(NotFlown):
            vehicle.prepare()


def fly_all(vehicle: Vehicle) -> None:
    vehicle.upload(MISSION)
    vehicle.prepare()
    vehicle.start()
    vehicle.return_to_launch()


@pytest.mark.parametrize("after", [Count, 224, 176, 400, 300])
@pytest.mark.parametrize("kind", [(3, 1), (12, 2)])
def test_a_vehicle_that_changes_its_kind_in_flight_gets_only_heartbeats(after: object, kind: tuple[int, int]) -> None:
    """Nor is it disarmed."""
    connection, channel = connection_to(3, 2)
    vehicle = meet(connection, options=ConnectionOptions(fast=False))
    channel.turning = after, kind
    with pytest.raises(NotFlown):
        fly_all(vehicle)
    assert vehicle.state.other_kind == VehicleKind(*kind)
    assert {type(message) for message in channel.sent_since} <= {Heartbeat}


def test_a_companion_with_the_autopilots_ids_changes_no_vehicle_state() -> None:
    connection, channel = connection_to(3, 2)
    vehicle = meet(connection, options=ConnectionOptions(fast=False))
    vehicle.state.armed = True
    channel.far.autopilot.kind_sent = 8, 18  # type: ignore[attr-defined]
    vehicle._run(wait(3.0))
    vehicle.upload(MISSION)
    assert (vehicle.state.kind, vehicle.state.armed) == (VehicleKind(3, 2), True)


def test_a_mission_for_another_vehicle_is_not_uploaded() -> None:
    connection, channel = connection_to(3, 2)
    vehicle = meet(connection)
    channel.sent.clear()
    for checked in (True, False):
        with refuses("other-vehicle", "", "plane", "multicopter", kind=BadInput):
            vehicle.upload(replace(MISSION, vehicle_type=1), checked=checked)
    assert channel.sent == []


def test_a_scan_and_a_choice_among_several_name_the_kinds() -> None:
    connection, _ = connection_to(3, 10)
    assert [str(vehicle.kind) for vehicle in scan(connection)] == ["ArduPilot rover"]


def test_beside_a_plane_a_copter_is_chosen_by_its_id() -> None:
    class Both(Loopback):
        pass

    stations = [Station(Disguised(Autopilot.ARDUPILOT, 3, kind), system) for system, kind in ((1, 1), (2, 2))]

    class Pair:
        def receive(self, data: bytes, peer: object, now: float) -> None:
            for station in stations:
                station.receive(data, peer, now)

        def tick(self, now: float) -> None:
            for station in stations:
                station.tick(now)

        def outgoing(self) -> list[tuple[bytes, object]]:
            return [sent for station in stations for sent in station.outgoing()]

        @property
        def deadline(self) -> float:
            return min(station.deadline for station in stations)

    def connection() -> Connection:
        return Connection(Both(Pair()), Codec(245, 190))

    meet(connection(), 2).upload(MISSION)
    with refuses("not-flown", "", "vehicle 1", "ArduPilot plane"):
        meet(connection(), 1)
    with refuses("several-vehicles", "", "1 (ArduPilot plane), 2 (ArduPilot multicopter)"):
        meet(connection())
