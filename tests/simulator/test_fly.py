from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import read_tlog
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.messages import MissionType
from ipoa_mission.mission.items import FenceCircle, Mission, change_speed, land, return_to_launch, takeoff
from ipoa_mission.mission.stored_mission import compare, to_wire
from ipoa_mission.simulator.fly import board, conditions_for, fly_built_in
from ipoa_mission.simulator.station import Faults
from tests.examples import vehicles
from tests.link_pair import connection_of, far_end
from tests.px4_waypoints import waypoint
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
BAD_RADIO = Faults(loss=0.3, duplicate=0.1, delay_s=0.1, reorder=0.1)


def place(n: int) -> Geodetic:
    return Geodetic(47.4 + 0.00012345 * n, 8.5 + 0.0001 * (n % 2))


def mission(autopilot: Autopilot, waypoints: int = 4) -> Mission:
    legs = tuple(waypoint(place(n), 30.0) for n in range(1, waypoints + 1))
    return Mission(HOME, (takeoff(HOME, 20.0), change_speed(8.0), *legs, return_to_launch()), autopilot)


def low_mission(autopilot: Autopilot, waypoints: int = 4) -> Mission:
    legs = tuple(waypoint(place(n), 5.0) for n in range(1, waypoints + 1))
    return Mission(HOME, (takeoff(HOME, 5.0), *legs, land(place(waypoints))), autopilot)


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.PX4))
def test_a_mission_is_flown_and_every_item_is_done_in_order(autopilot: Autopilot, tmp_path: Path) -> None:
    log = tmp_path / "flight.tlog"
    record = fly_built_in(mission(autopilot), log=log)
    assert record.completed
    assert list(record.item_reached_s) == list(range(7))
    times = list(record.item_reached_s.values())
    assert times == sorted(times)
    assert times[0] > 3.0  # nobody climbs 20 m in less
    assert record.total_s >= times[-1]
    assert 29.0 < max(sample.height for sample in record.path) < 61.0  # PX4 returns at 60 m
    assert len(list(read_tlog(log))) > 100


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_the_same_seed_gives_the_same_bytes(autopilot: Autopilot, tmp_path: Path) -> None:
    logs = [tmp_path / "one.tlog", tmp_path / "two.tlog"]
    for log in logs:
        fly_built_in(low_mission(autopilot, 1), faults=Faults(loss=0.1, delay_s=0.05), seed=3, log=log)
    assert logs[0].read_bytes() == logs[1].read_bytes()


@pytest.mark.parametrize("autopilot", registered())
def test_two_hundred_items_arrive_exactly_over_a_bad_radio(autopilot: Autopilot) -> None:
    sent = mission(autopilot, 200)
    with board(sent, conditions_for(sent, seed=5), BAD_RADIO) as vehicle:
        vehicle.upload(sent)
        stored = far_end(connection_of(vehicle)).autopilot.transfers.stores[MissionType.MISSION].items
    assert compare(to_wire(sent), stored, autopilot) is None


@pytest.mark.parametrize("autopilot", registered())
def test_fence_and_rally_points_come_back_as_they_were_sent(autopilot: Autopilot) -> None:
    fence = (FenceCircle((47.4, 8.5), 500.0),)
    rally = (Geodetic(47.4005, 8.5, 25.0),)
    with board(mission(autopilot)) as vehicle:
        vehicle.upload(replace(mission(autopilot), fence=fence, rally=rally))
        read = vehicle.download()
        assert (read.fence, read.rally) == (fence, rally)
        vehicle.clear(255)
        read = vehicle.download()
        assert (read.items, read.fence, read.rally) == ((), (), ())


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_a_flight_begins_at_the_first_item_whatever_the_vehicle_was_told(autopilot: Autopilot) -> None:
    with board(low_mission(autopilot)) as vehicle:
        vehicle.upload(low_mission(autopilot))
        vehicle.set_current(3)
        vehicle.prepare()
        vehicle.start()
        assert 0 in vehicle.watch().item_reached_s


def test_a_flight_begins_with_another_item_where_that_is_asked_for() -> None:
    with board(low_mission(Autopilot.PX4)) as vehicle:
        vehicle.upload(low_mission(Autopilot.PX4))
        vehicle.prepare(3)
        vehicle.start()
        assert min(vehicle.watch().item_reached_s) == 3


def test_a_dead_radio_is_an_error_that_says_so() -> None:
    with refuses("not-heard", kind=NoAnswer):
        fly_built_in(mission(Autopilot.PX4), faults=Faults(loss=1.0))
