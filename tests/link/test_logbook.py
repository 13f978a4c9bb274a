import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.dialogue import SPECIFIED, Exchange
from ipoa_mission.link.logbook import Logbook, watch
from ipoa_mission.link.messages import ARMED_FLAG, CommandAck, Current, Heartbeat, Message, Position, Reached, Text
from ipoa_mission.mission.items import Item, change_speed, land, return_to_launch, takeoff, waypoint

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME, THERE = Geodetic(47.4, 8.5, 400.0), Geodetic(47.401, 8.5, 400.0)
LANDS = (takeoff(HOME, 20.0), waypoint(THERE, 20.0), land(THERE))
RETURNS = (takeoff(HOME, 20.0), return_to_launch())
HOLDS = (takeoff(HOME, 20.0), change_speed(5.0), waypoint(THERE, 20.0))
ARMING = CommandAck(400, 0)


def at(seconds: float, place: Geodetic = THERE) -> Position:
    return Position(seconds, place.latitude_deg, place.longitude_deg, 430.0, 30.0, (3.0, 4.0, 0.0))


def armed(mode: int = PX4.modes.mission) -> Heartbeat:
    return Heartbeat(2, 12, ARMED_FLAG, mode)


DISARMED = Heartbeat(2, 12, 0, PX4.modes.mission)


def noted(items: tuple[Item, ...], *messages: Message, autopilot: Autopilot = PX4) -> Logbook:
    logbook = Logbook(items, autopilot)
    for message in messages:
        logbook.note(message)
    return logbook


def test_time_zero_is_the_arming_and_not_the_time_since_boot() -> None:
    before = (at(131.0), Reached(0), Text(6, "before"))
    flight = (at(135.0), Reached(0), Text(6, "words"), at(140.0), Current(2), at(150.0), DISARMED)
    for sign in (ARMING, armed()):
        record = noted(LANDS, *before, sign, armed(), *flight).record()
        assert record.item_reached_s == {0: 4.0, 1: 9.0, 2: 19.0}
        assert record.total_s == 19.0
        assert record.completed
        assert record.messages == ("words",)
        assert [sample.time_s for sample in record.path] == [4.0, 9.0, 19.0]
        assert record.path[0].speed == 5.0


def test_an_item_is_done_when_the_next_one_is_flown_or_reached() -> None:
    """ArduCopter never reports NAV_TAKEOFF and LAND; a DO item may be reported early."""
    flight = (Current(1), ARMING, armed(3), at(12.0), Reached(2), at(13.0), Current(3), at(20.0))
    assert noted(HOLDS, *flight, autopilot=ARDUPILOT).record().item_reached_s == {0: 12.0, 1: 12.0}


def test_items_done_in_a_link_loss_have_no_time() -> None:
    """Flown with a cut link: five waypoints of 18.5 to 31.9 s had 37.0 s, the time of its return."""
    logbook = noted(LANDS, ARMING, armed(), at(10.0), Current(1), at(19.0))
    logbook.note_return()
    for message in (Current(2), at(37.0), armed(), at(60.0), DISARMED):
        logbook.note(message)
    record = logbook.record()
    assert record.late_items == {1}
    assert record.timed_items_s == {0: 10.0, 2: 60.0}
    assert record.completed


def test_items_before_the_one_it_began_with_are_not_done() -> None:
    record = noted(LANDS, Current(1), ARMING, armed(), at(9.0), Current(2), at(20.0), DISARMED).record()
    assert record.item_reached_s == {1: 9.0, 2: 20.0}


def test_the_disarming_text_gives_the_time_and_not_the_later_heartbeat() -> None:
    flight = (ARMING, armed(), at(30.0), Current(2), Text(6, "Disarming motors"), at(30.9), DISARMED)
    assert noted(LANDS, *flight).record().total_s == 30.0


def test_a_return_is_done_on_the_ground_not_when_px4_reports_it() -> None:
    home = next(iter(PX4.modes.returns))
    for last in (Reached(1), Current(1, 2, 5)):
        flight = (ARMING, armed(), at(60.0, HOME), Reached(0), last, armed(home))
        logbook = noted(RETURNS, *flight)
        assert logbook.record().item_reached_s == {0: 60.0}
        assert not logbook.record().completed
        logbook.note(at(190.0, HOME))
        logbook.note(DISARMED)
        assert logbook.record().item_reached_s == {0: 60.0, 1: 190.0}
        assert logbook.record().completed


@pytest.mark.parametrize(
    ("items", "flight", "why"),
    [
        (LANDS, (at(9.0), Current(1), DISARMED), "disarmed at item 2 of 3"),
        (LANDS, (at(9.0), Current(2), armed(0x04030000), at(12.0), DISARMED), "left its mission before the landing"),
        (LANDS, (Current(2), at(9.0, HOME), DISARMED), "landed 111 m from the place of its LAND"),
        (LANDS, (Current(2), at(9.0)), "not down and disarmed"),
        (HOLDS, (at(9.0), Current(2, 3, 5), DISARMED), "ends in the air"),
    ],
)
def test_a_flight_that_does_not_end_where_its_mission_does_is_not_complete(
    items: tuple[Item, ...], flight: tuple[Message, ...], why: str
) -> None:
    record = noted(items, ARMING, armed(), *flight).record()
    assert not record.completed
    assert why in record.why_not


def test_an_acknowledged_arming_that_no_heartbeat_confirms_was_none() -> None:
    logbook = noted(LANDS, at(100.0), ARMING, at(104.0), DISARMED)
    assert not logbook.armed
    assert logbook.record().total_s == 0.0


def test_an_old_heartbeat_behind_the_arming_does_not_end_the_flight() -> None:
    logbook = noted(LANDS, at(100.0), ARMING, DISARMED, at(101.0), armed(), at(102.0))
    assert logbook.disarmed_s is None
    assert logbook.record().total_s == 2.0


def test_a_later_flight_begins_anew() -> None:
    first = (ARMING, armed(), at(9.0), Current(2), at(20.0), DISARMED)
    logbook = noted(LANDS, *first, at(50.0), Current(0), ARMING, armed(), at(60.0))
    assert logbook.record().total_s == 10.0
    assert logbook.record().item_reached_s == {}


def test_watching_ends_with_the_flight_and_tells_of_progress() -> None:
    reported: list[str] = []
    for items, last in ((LANDS, DISARMED), (HOLDS, Current(2, 3, 5))):
        logbook = noted(items, ARMING, armed())
        exchange = Exchange(watch(logbook, lambda share, words: reported.append(words)), 0.0, SPECIFIED)
        for now, message in enumerate([at(1.0), Reached(0), armed(), last]):
            logbook.note(message)
            exchange.receive(message, float(now))
        assert exchange.finished
    done = [*((n, LANDS) for n in (0, 1)), *((n, HOLDS) for n in (0, 1, 2))]
    assert reported == [f"item {n} of {len(items)}" for n, items in done]
