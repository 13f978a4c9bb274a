"""Measured on ArduCopter 4.7.0-dev and PX4 1.17.0."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import (
    Item,
    Mission,
    change_speed,
    land,
    return_to_launch,
    spline_waypoint,
    takeoff,
    waypoint,
)
from ipoa_mission.mission.stored_mission import as_stored, compare, from_wire, to_wire
from tests.refused import refuses

HOME = Geodetic(39.101, 121.82, 20.0)
AWAY = Geodetic(39.1023457, 121.8212346)
NAN = math.nan

FLIGHT = Mission(
    HOME,
    (
        takeoff(HOME, 40.0),
        change_speed(15.0),
        waypoint(AWAY, 40.25, hold_s=3.0),
        Item(Command.DO_JUMP, 2, (3.0, 2.0, 0.0, 0.0)),
        return_to_launch(),
    ),
)

BOTH = pytest.mark.parametrize("autopilot", list(registered()))


def test_ardupilot_is_sent_home_as_item_0_and_px4_is_not() -> None:
    ours = to_wire(replace(FLIGHT, autopilot=Autopilot.ARDUPILOT))
    assert ours[0] == Item(16, 0, (0.0, 0.0, 0.0, 0.0), 39.101, 121.82, 20.0)
    assert [item.command for item in ours[1:]] == [22, 178, 16, 177, 20]
    assert [item.command for item in to_wire(FLIGHT)] == [22, 178, 16, 177, 20]


def test_a_jump_counts_as_the_autopilot_counts() -> None:
    assert to_wire(replace(FLIGHT, autopilot=Autopilot.ARDUPILOT))[4].params[0] == 3.0  # home is 0
    assert to_wire(FLIGHT)[3].params[0] == 2.0  # the take-off is 0


@pytest.mark.parametrize("command", [Command.NAV_RETURN_TO_LAUNCH, Command.DO_CHANGE_SPEED, Command.NAV_DELAY])
@BOTH
def test_commands_without_position_are_in_frame_2(command: Command, autopilot: Autopilot) -> None:
    sent = to_wire(Mission(HOME, (Item(command, 3),), autopilot))
    assert sent[-1].frame == 2


def test_nan_becomes_0_only_where_ardupilot_refuses_it() -> None:
    items = (Item(Command.NAV_WAYPOINT, 3, (NAN, NAN, NAN, NAN)), Item(Command.CONDITION_YAW, 2, (1.0, 2.0, NAN, NAN)))
    waypoints, yaw = to_wire(Mission(HOME, items, Autopilot.ARDUPILOT))[1:]
    assert waypoints.params[:3] == (0.0, 0.0, 0.0)
    assert math.isnan(waypoints.params[3])
    assert yaw.params == (1.0, 2.0, 0.0, 0.0)
    assert all(math.isnan(p) for p in to_wire(Mission(HOME, items[:1], Autopilot.PX4))[0].params)


@BOTH
def test_mission_read_back_from_the_wire_is_the_same(autopilot: Autopilot) -> None:
    mission = replace(FLIGHT, autopilot=autopilot)
    back = from_wire(to_wire(mission), autopilot, HOME)
    assert (back.home, len(back.items)) == (HOME, 5)
    assert compare(to_wire(mission), to_wire(back), autopilot) is None


def test_ardupilots_item_0_is_home_unless_the_vehicle_reports_another() -> None:
    wire = to_wire(replace(FLIGHT, autopilot=Autopilot.ARDUPILOT))
    assert from_wire(wire, Autopilot.ARDUPILOT).home == HOME
    assert from_wire(wire, Autopilot.ARDUPILOT, AWAY).home == AWAY


def test_a_px4_list_without_a_known_home_is_an_error() -> None:
    with refuses("home-missing", "home", "PX4"):
        from_wire(to_wire(FLIGHT), Autopilot.PX4)


#: Sent; read back: each row was measured.
MEASURED = {
    "ardupilot cuts holds to whole seconds and drops param2 to 4": (
        Autopilot.ARDUPILOT,
        Item(16, 3, (2.9, 1.0, 2.0, 90.0), 39.1, 121.8, 30.0),
        Item(16, 3, (2.0, 0.0, 0.0, 0.0), 39.1, 121.8, 30.0),
    ),
    "ardupilot cuts altitudes to centimeters": (
        Autopilot.ARDUPILOT,
        Item(16, 3, (0.0, 0.0, 0.0, 0.0), 39.1, 121.8, 30.567),
        Item(16, 3, (0.0, 0.0, 0.0, 0.0), 39.1, 121.8, 30.56),
    ),
    "ardupilot's land comes back with param4 1": (
        Autopilot.ARDUPILOT,
        Item(21, 3, (0.0, 0.0, 0.0, NAN), 39.1, 121.8, 0.0),
        Item(21, 3, (0.0, 0.0, 0.0, 1.0), 39.1, 121.8, 0.0),
    ),
    "ardupilot knows no frame 2": (Autopilot.ARDUPILOT, Item(20, 2), Item(20, 0)),
    "ardupilot gives frame 6 back as 3": (Autopilot.ARDUPILOT, Item(16, 6, altitude=5.0), Item(16, 3, altitude=5.0)),
    "ardupilot gives frame 11 back as 10": (
        Autopilot.ARDUPILOT,
        Item(16, 11, altitude=5.0),
        Item(16, 10, altitude=5.0),
    ),
    "ardupilot always continues": (Autopilot.ARDUPILOT, Item(20, 2, autocontinue=False), Item(20, 0)),
    "ardupilot keeps a change of speed": (
        Autopilot.ARDUPILOT,
        Item(178, 2, (1.0, 7.3, -1.0, 0.0)),
        Item(178, 0, (1.0, 7.3, -1.0, 0.0)),
    ),
    "px4 keeps fractions of a second": (
        Autopilot.PX4,
        Item(16, 3, (2.9, 0.0, 0.0, NAN), 39.1, 121.8, 30.567),
        Item(16, 6, (2.9, 0.0, 0.0, NAN), 39.1, 121.8, 30.567),
    ),
    "px4 gives frame 0 back as 5": (Autopilot.PX4, Item(16, 0, altitude=50.0), Item(16, 5, altitude=50.0)),
    "px4 zeroes unused params": (
        Autopilot.PX4,
        Item(22, 3, (15.0, 1.0, 1.0, 45.0), 39.1, 121.8, 30.0),
        Item(22, 6, (0.0, 0.0, 0.0, 45.0), 39.1, 121.8, 30.0),
    ),
    "px4 keeps frame 2": (Autopilot.PX4, Item(93, 2, (4.0, 0.0, 0.0, 0.0)), Item(93, 2, (4.0, 0.0, 0.0, 0.0))),
}


@pytest.mark.parametrize("row", MEASURED)
def test_known_changes_of_an_autopilot_are_no_difference(row: str) -> None:
    autopilot, sent, got = MEASURED[row]
    head = to_wire(Mission(HOME, (), autopilot))
    assert compare((*head, sent), (*head, got), autopilot) is None
    assert str(as_stored([sent], autopilot)[0].params) == str(as_stored([got], autopilot)[0].params)


def test_the_home_that_ardupilot_gives_back_is_its_own_and_not_compared() -> None:
    sent = to_wire(replace(FLIGHT, autopilot=Autopilot.ARDUPILOT))
    got = (replace(sent[0], latitude_deg=39.2, altitude=21.0), *sent[1:])
    assert compare(sent, as_stored(got, Autopilot.ARDUPILOT), Autopilot.ARDUPILOT) is None


@BOTH
def test_a_list_of_another_length_is_a_difference(autopilot: Autopilot) -> None:
    sent = to_wire(replace(FLIGHT, autopilot=autopilot))
    difference = compare(sent, sent[:-1], autopilot)
    assert difference is not None
    assert str(difference) == f"the list: number of items: sent {len(sent)}, the vehicle holds {len(sent) - 1}"


SPOILED = {
    "latitude": lambda item: replace(item, latitude_deg=item.latitude_deg + 1e-7),
    "longitude": lambda item: replace(item, longitude_deg=item.longitude_deg - 1e-7),
    "altitude": lambda item: replace(item, altitude=item.altitude + 0.02),
    "param1": lambda item: replace(item, params=(item.params[0] + 1.0, *item.params[1:])),
    "frame": lambda item: replace(item, frame=10 if item.frame == 0 else 0),
    "command": lambda item: replace(item, command=19),
}


@pytest.mark.parametrize("field", SPOILED)
@BOTH
def test_the_first_spoiled_field_is_named(autopilot: Autopilot, field: str) -> None:
    sent = to_wire(replace(FLIGHT, autopilot=autopilot))
    seq = len(sent) - 3  # the waypoint
    got = [*sent]
    got[seq] = SPOILED[field](sent[seq])
    difference = compare(sent, got, autopilot)
    assert difference is not None
    assert (difference.seq, difference.field) == (seq + 1 - autopilot.seq_offset, field)


def test_a_changed_speed_is_a_difference_on_px4_and_on_ardupilot() -> None:
    for autopilot in registered():
        sent = to_wire(Mission(HOME, (change_speed(15.0),), autopilot))
        got = (*sent[:-1], replace(sent[-1], params=(1.0, 14.0, -1.0, 0.0)))
        difference = compare(sent, got, autopilot)
        assert difference is not None
        assert str(difference).endswith("param2: sent 15, the vehicle holds 14")


FINITE = st.floats(-1e4, 1e4, width=32)


@st.composite
def known_items(draw: st.DrawFn, autopilot: Autopilot) -> Item:
    firmware = autopilot.firmware()
    placed = draw(st.booleans())
    return Item(
        draw(st.sampled_from(sorted(firmware.placed if placed else firmware.plain))),
        draw(st.sampled_from(sorted(firmware.frames - {2}))) if placed else 2,
        tuple(draw(FINITE) for _ in range(4)),  # type: ignore[arg-type]
        draw(st.integers(-900_000_000, 900_000_000)) / 1e7 if placed else 0.0,
        draw(st.integers(-1_800_000_000, 1_800_000_000)) / 1e7 if placed else 0.0,
        draw(FINITE),
        draw(st.booleans()),
    )


@BOTH
@given(data=st.data())
def test_stored_items_never_differ_from_sent_ones(autopilot: Autopilot, data: st.DataObject) -> None:
    mission = Mission(HOME, tuple(data.draw(st.lists(known_items(autopilot), max_size=4))), autopilot)
    sent = to_wire(mission)
    stored = as_stored(sent, autopilot)
    assert compare(sent, stored, autopilot) is None
    assert compare(stored, stored, autopilot) is None, "storing twice changes nothing more"
    assert compare(sent, to_wire(from_wire(stored, autopilot, HOME)), autopilot) is None


def test_the_splines_that_ardupilot_flies_are_unknown_to_px4() -> None:
    item = spline_waypoint(AWAY, 30.0)
    assert Autopilot.ARDUPILOT.firmware().kept(item.command, item.frame) is not None
    assert Autopilot.PX4.firmware().kept(item.command, item.frame) is None


@pytest.mark.parametrize("item", [land(HOME), takeoff(HOME, 10.0), waypoint(AWAY, 10.0), change_speed(5.0)])
@BOTH
def test_both_know_what_the_package_itself_writes(item: Item, autopilot: Autopilot) -> None:
    assert autopilot.firmware().kept(item.command, item.frame) is not None
