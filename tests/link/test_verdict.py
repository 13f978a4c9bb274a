from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.messages import Ack, Count, Current, Event, ItemAt, Message, Request, RequestList, Text
from ipoa_mission.link.upload import Upload, upload
from ipoa_mission.link.vehicle_state import VehicleState
from ipoa_mission.link.vehicle_words import VehicleTexts, event, event_number, words_in
from ipoa_mission.mission.items import Item
from tests.link.scripted_answers import lead
from tests.link_pair import CLIENT, STRANGER, items_of
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT


def judged(*words: Message, readings: int = 2) -> dict[type[Message], list[list[Message]]]:
    items = items_of(PX4, 1)
    return {
        Count: [[Request(0)]],
        ItemAt: [[Ack(0)]],
        RequestList: [[Count(1)]] * readings,
        Request: [[ItemAt(0, items[0])]] * readings,
        Ack: [list(words)],
    }


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ((Event(event_number("navigator_mis_takeoff_too_low"), 3), Current(0, 1, 1)), ("unflyable",)),
        ((Text(2, "Mission rejected: geofence\t"), Current(0, 1, 1)), ("unflyable",)),
        ((Event(12345, 3), Current(0, 1, 1)), ("unflyable",)),
    ],
)
def test_a_mission_that_the_vehicle_rejects_is_an_error_with_its_reason(
    words: tuple[Message, ...], why: tuple[str, ...]
) -> None:
    with refuses(*why):
        lead(upload(Upload(items_of(PX4, 1), PX4)), judged(*words))


@pytest.mark.parametrize(
    "words", [(), (Current(0, 1, 2), Current(0, 1, 2)), (Current(0, 1, 1), Current(0, 1, 2)), (Current(0),)]
)
def test_the_last_state_that_is_told_counts(words: tuple[Message, ...]) -> None:
    assert lead(upload(Upload(items_of(PX4, 1), PX4)), judged(*words)).finished


ONE = items_of(PX4, 1)
OTHER = items_of(PX4, 1, shift=0.1) + items_of(PX4, 2)[1:]


@pytest.mark.parametrize(
    ("ack", "words", "stored", "expected"),
    [
        (Ack(0), (Current(0, 2, 2),), OTHER, "the list: number of items: sent 1, the vehicle holds 2"),
        (Ack(0), (Current(0, 1, 2), Current(0, 2, 2), Current(0, 2, 3)), OTHER, "number of items"),
        (Ack(0), (Current(0, 65535, 1),), (), "number of items: sent 1, the vehicle holds 0"),
        (Ack(0), (Current(0, 0, 1),), (), "number of items: sent 1, the vehicle holds 0"),
        (Ack(0), (Current(0, 2),), OTHER, "number of items"),
        (Ack(0, 0, 77), (Current(0, 1, 2, 2, 78),), items_of(PX4, 2)[1:], "item 1: command: sent NAV_TAKEOFF"),
    ],
)
def test_a_mission_replaced_before_the_verdict_is_an_error(
    ack: Ack, words: tuple[Message, ...], stored: tuple[Item, ...], expected: str
) -> None:
    script = judged(*words) | {
        ItemAt: [[ack]],
        RequestList: [[Count(1)], [Count(len(stored))]],
        Request: [[ItemAt(0, ONE[0])], *([ItemAt(seq, item)] for seq, item in enumerate(stored))],
    }
    with refuses("replaced", "", expected):
        lead(upload(Upload(ONE, PX4)), script)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("words", "readings"),
    [
        ((Current(0, 5, 2), Current(0, 1, 2, 2, 77)), 1),  # the first was said before the upload
        ((Current(0, 1, 2, 2, 77),), 1),
        ((Current(0, 1, 2),), 2),  # it does not name the mission
        ((Current(0, 1, 2, 2, 5), Current(0, 1, 2, 2, 77)), 2),
        ((Current(0, 1, 2, 2, 77), Ack(0, 0, 77)), 1),  # what comes twice says nothing new
        ((Ack(0, 0, 78), Current(0, 1, 2, 2, 77)), 2),
        ((Current(0, 5, 2),), 2),  # from before the upload, late: read again
        ((Current(0, 1, 2, 2, 5),), 2),
    ],
)
def test_messages_before_the_upload_are_no_replacement(words: tuple[Message, ...], readings: int) -> None:
    script = judged(*words) | {
        ItemAt: [[Ack(0, 0, 77)]],
        RequestList: [[Count(1)]] * 2,
        Request: [[ItemAt(0, ONE[0])]] * 2,
    }
    assert lead(upload(Upload(ONE, PX4)), script).finished
    assert len(script[RequestList]) == 2 - readings


def test_the_first_id_after_our_count_is_ours_and_a_later_one_is_a_doubt() -> None:
    """A second station with our ids: its Ack comes to us too."""
    theirs = items_of(PX4, 2)[1:]
    script = judged(Ack(0, 0, 78), Current(0, 1, 2, 2, 78)) | {
        ItemAt: [[Ack(0, 0, 77)]],
        Request: [[ItemAt(0, ONE[0])], [ItemAt(0, theirs[0])]],
    }
    with refuses("replaced"):
        lead(upload(Upload(ONE, PX4)), script)


def test_an_upload_names_the_mission_only_where_nothing_else_was_heard() -> None:
    named = lead(upload(Upload(ONE, PX4)), judged(Current(0, 1, 2, 2, 77)) | {ItemAt: [[Ack(0, 0, 77)]]})
    disputed = judged(Ack(0, 0, 78), Current(0, 1, 2, 2, 77)) | {ItemAt: [[Ack(0, 0, 77)]]}
    assert named.result == 77
    assert lead(upload(Upload(ONE, PX4)), disputed).result == 0
    assert lead(upload(Upload(ONE, PX4)), judged()).result == 0


def test_a_mission_that_differs_at_every_reading_is_no_success() -> None:
    script = judged(Current(0, 2, 2), readings=9)
    script[Ack] = [[Current(0, 2, 2)]] * 9
    script[RequestList] = [[Count(1), Current(0, 2, 2)]] * 9
    with refuses("keeps-changing"):
        lead(upload(Upload(ONE, PX4)), script)


def test_verdict_on_another_mission_then_silence_is_not_verified() -> None:
    with refuses("no-answer"):
        lead(upload(Upload(ONE, PX4)), judged(Current(0, 2, 2), readings=1))


def test_words_of_an_event_have_its_numbers() -> None:
    unsupported = event("navigator_mis_unsup_cmd", 2, 400)
    assert words_in(unsupported) == "item 2 has command 400, which this vehicle cannot fly"
    assert words_in(replace(unsupported, arguments=b"\x02")) == "item 2 has command 0, which this vehicle cannot fly"
    assert words_in(event("navigator_mis_geofence_violation", 7)) == "item 7 is outside of the vehicle's fence"


# As recorded from PX4 1.18 in its simulator.
NO_MISSION = (Text(2, "Mission start denied! No valid mission\t"), Event(23844490, 98))
NOT_AVAILABLE = (
    Text(2, "Switching to Mission is currently not available\t"),
    Event(27280279, 98, b"\x00\x00\x04\x04\x03"),
)


@pytest.mark.parametrize(("text", "its_event"), [NO_MISSION, NOT_AVAILABLE])
def test_a_reason_counts_once_whether_text_or_event_or_both_come(text: Text, its_event: Event) -> None:
    for heard in ([text], [its_event], [text, its_event], [its_event, text]):
        texts = VehicleTexts()
        for message in heard:
            texts.note(message)
        assert str(texts) == text.text.rstrip()


def test_events_are_warnings_of_a_vehicle_that_may_not_arm() -> None:
    state = VehicleState(PX4)
    for reason in (event("check_modes_global_pos"), Text(2, "Preflight Fail: Global position estimate required")):
        state.note(reason)
    assert state.warnings.words == ["Preflight Fail: Global position estimate required"]
    assert PX4.protocol_profile.arming_words.lasting(str(state.warnings)) == ()


@pytest.mark.parametrize(
    "name",
    [
        *(f"check_modes_{part}" for part in ("angular_velocity", "attitude", "local_alt", "local_pos", "global_pos")),
        *(f"check_system_no_{part}_pos" for part in ("global", "home")),
        *(f"check_estimator_{part}_not_stable" for part in ("hgt", "hor_pos", "hor_vel", "vert_vel")),
        "check_estimator_missing_data",
        "check_rc_dl_no_dllink",
    ],
)
def test_a_check_of_an_estimate_passes_with_time(name: str) -> None:
    words = words_in(event(name))
    arming_words = PX4.protocol_profile.arming_words
    assert (arming_words.reasons(words) != (), arming_words.lasting(words)) == (True, ())


def test_an_event_of_low_severity_is_no_reason() -> None:
    armed_by = Event(26266355, 102, b"\x04")
    refusal = replace(event("commander_arm_denied_calibrating"), log_levels=0x66)
    assert [words_in(armed_by, 7), words_in(refusal), words_in(refusal, 6)] == ["", "", "Arming denied: calibrating"]


def test_px4s_numbers_of_events_are_hashes_of_their_names() -> None:
    # FNV-1a's published vectors, cut to 24 bits, with the autopilot's component id before them.
    assert event_number("") == 0x01000000 | 0x811C9DC5 & 0xFFFFFF
    assert event_number("a") == 0x01000000 | 0xE40C292C & 0xFFFFFF
    assert event_number("foobar") == 0x01000000 | 0xBF9CF968 & 0xFFFFFF
    assert CLIENT != STRANGER
