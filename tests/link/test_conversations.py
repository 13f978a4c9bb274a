from collections.abc import Callable
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import REFUSAL_TIMEOUT_S, MissionRefused, clear, download, fetch, list_name, offer
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange, ListAboard, NoAnswer, Tell
from ipoa_mission.link.messages import (
    Ack,
    ClearAll,
    Count,
    Heartbeat,
    ItemAt,
    Message,
    MissionType,
    Request,
    RequestList,
    Result,
    Text,
)
from ipoa_mission.link.upload import ReadBackDiffers
from ipoa_mission.link.vehicle_words import VehicleTexts
from ipoa_mission.mission.stored_mission import Difference
from tests.link_pair import CLIENT, Air, Fate, Vehicle, items_of
from tests.refused import refuses

ITEMS = items_of(Autopilot.PX4, 3)
BEAT = Heartbeat(2, 12)
FAR = 1000.0


class Talk:
    """One end of a conversation; each message comes a second after the last."""

    def __init__(self, dialogue: Dialogue[object]) -> None:
        self.now = 0.0
        self.exchange = Exchange(dialogue, self.now, SPECIFIED)

    @property
    def sent(self) -> list[Message]:
        return self.exchange.outgoing()

    def hear(self, *messages: Message) -> "Talk":
        for message in messages:
            self.now += 1.0
            self.exchange.receive(message, self.now)
        return self

    def wait(self, seconds: float) -> "Talk":
        until = self.now + seconds
        while self.exchange.deadline <= until:
            self.now = self.exchange.deadline
            self.exchange.tick(self.now)
        return self

    def until(self, kind: type[Message]) -> "Talk":
        while not any(isinstance(message, kind) for message in self.sent):
            self.now = max(self.now, self.exchange.deadline)
            self.exchange.tick(self.now)
        return self


def item(seq: int, kind: int = MissionType.MISSION) -> ItemAt:
    return ItemAt(seq, ITEMS[seq], kind)


# --- offering -------------------------------------------------------------------------------------------------------


def test_an_upload_reads_like_the_sequence_diagram() -> None:
    talk = Talk(offer(ITEMS, 0))
    assert talk.sent == [Count(3)]
    for seq in range(3):
        assert talk.hear(Request(seq, legacy=seq == 1)).sent == [item(seq)]
    assert talk.hear(Ack(Result.ACCEPTED)).exchange.result == Result.ACCEPTED


def test_progress_is_told_item_by_item() -> None:
    asked: list[int] = []
    Talk(offer(ITEMS, 0, asked=asked.append)).hear(Request(0), Request(1), Request(2), Ack(0))
    assert asked == [0, 1, 2, 3]


def test_an_item_is_repeated_when_and_only_when_it_is_asked_for_again() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1))
    _ = talk.sent
    assert talk.wait(5.0).sent == []
    assert talk.hear(Request(1)).sent == [item(1)]


def test_a_late_duplicate_of_an_earlier_request_stays_unanswered() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1))
    _ = talk.sent
    assert talk.hear(Request(0)).sent == []


@pytest.mark.parametrize(
    "stray",
    [Request(2), Request(9), Request(0, MissionType.FENCE), Ack(0, MissionType.FENCE), Ack(0), Ack(5, 2), BEAT],
    ids=str,
)
def test_foreign_messages_change_nothing(stray: Message) -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0))
    _ = talk.sent
    assert talk.hear(stray).sent == []
    assert not talk.exchange.finished
    assert talk.hear(Request(1)).sent == [item(1)]


def test_an_early_acknowledgement_is_no_success() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Ack(Result.ACCEPTED))
    assert not talk.exchange.finished


def test_silence_after_the_last_item_is_not_known_to_be_a_failure() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1), Request(2)).wait(FAR)
    assert talk.exchange.result is None


def test_the_last_item_is_given_again_if_it_is_asked_for_again() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1), Request(2))
    _ = talk.sent
    assert talk.hear(Request(2)).sent == [item(2)]
    assert talk.hear(Ack(0)).exchange.result == Result.ACCEPTED


def test_a_vehicle_whose_client_says_no_final_word_is_done_all_the_same() -> None:
    talk = Talk(offer(ITEMS, 0, Tell)).hear(Request(0), Request(1), Request(2)).wait(FAR)
    assert talk.exchange.result is None


def test_silence_before_it_says_how_far_the_transfer_came() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1))
    with refuses("no-answer", "", "1 of 3", "mission"):
        talk.wait(FAR)


def test_an_empty_list_is_acknowledged_at_once_or_not_at_all() -> None:
    assert Talk(offer((), 0)).hear(Ack(0)).exchange.result == Result.ACCEPTED
    with pytest.raises(NoAnswer):
        Talk(offer((), 0)).wait(FAR)


@pytest.mark.parametrize("result", [Result.UNSUPPORTED, Result.NO_SPACE, Result.DENIED, 77], ids=str)
def test_a_refusal_has_its_result_its_item_and_the_vehicles_words(result: int) -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1), Text(4, "before"))
    talk.hear(Ack(result))
    with pytest.raises(MissionRefused) as refusal:
        _ = talk.hear(Text(3, "behind")).wait(1.0)
    assert (refusal.value.result, refusal.value.seq) == (result, 1)
    assert "at item 2" in str(refusal.value)
    assert "before" in str(refusal.value)


def test_words_that_follow_a_refusal_are_waited_for() -> None:
    exchange = Exchange(offer(ITEMS, 0), 0.0, SPECIFIED)
    exchange.receive(Request(0), 0.1)
    exchange.receive(Ack(Result.NO_SPACE), 0.2)
    exchange.receive(Text(4, "Only 1 items are supported"), 0.3)
    with refuses("mission-refused", "", "NO_SPACE"):
        exchange.tick(0.6)


def test_a_rebuke_for_a_duplicate_does_not_end_a_healthy_transfer() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Ack(Result.INVALID_SEQUENCE), Request(1), Request(2), Ack(0))
    assert talk.exchange.result == Result.ACCEPTED


def test_an_error_is_forgiven_if_the_vehicle_goes_on_asking() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Ack(Result.ERROR), Request(1), Request(2), Ack(0))
    assert talk.exchange.result == Result.ACCEPTED


@pytest.mark.parametrize("doubtful", [Result.ERROR, Result.INVALID_SEQUENCE])
def test_doubtful_end_is_settled_by_the_read_back(doubtful: int) -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Request(1), Request(2), Ack(doubtful)).wait(FAR)
    assert talk.exchange.result == doubtful


def test_an_error_is_final_if_it_does_not() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Ack(Result.ERROR), BEAT)
    with refuses("mission-refused", "", "ERROR"):
        talk.wait(REFUSAL_TIMEOUT_S)


def test_a_rebuke_is_final_if_nothing_follows() -> None:
    talk = Talk(offer(ITEMS, 0)).hear(Request(0), Ack(Result.INVALID_SEQUENCE))
    with refuses("mission-refused", "", "INVALID_SEQUENCE"):
        talk.wait(FAR)


def test_a_vehicle_gives_items_in_any_order() -> None:
    talk = Talk(offer(ITEMS, 0, Tell))
    assert talk.sent == [Count(3)]
    assert talk.hear(Request(2), Request(0), Request(2)).sent == [item(2), item(0), item(2)]
    assert talk.hear(Ack(0)).exchange.result == Result.ACCEPTED


# --- fetching -------------------------------------------------------------------------------------------------------


def reading(total: int, kind: int = MissionType.MISSION, refusal: int = 0, legacy: bool = False) -> Dialogue[int]:
    """`refusal`: of all items but the first."""
    return fetch(kind, total, lambda seq, heard: refusal if seq else Result.ACCEPTED, legacy=legacy)


def test_items_are_fetched_in_order_each_asked_for_until_it_comes() -> None:
    talk = Talk(reading(2))
    assert talk.sent == [Request(0)]
    assert talk.wait(0.6).sent == [Request(0)]
    assert talk.hear(item(0)).sent == [Request(1)]
    assert talk.hear(item(1)).exchange.result == Result.ACCEPTED


def test_a_duplicate_of_an_item_is_ignored() -> None:
    talk = Talk(reading(3)).hear(item(0))
    _ = talk.sent
    assert talk.hear(item(0), item(2), item(1, MissionType.RALLY), Ack(0), BEAT).sent == []


def test_a_fetcher_with_a_temper_rebukes_it() -> None:
    talk = Talk(reading(3, legacy=True)).hear(item(0))
    assert talk.sent == [Request(0, legacy=True), Request(1, legacy=True)]
    assert talk.hear(item(0)).sent == [Ack(Result.INVALID_SEQUENCE)]


def test_the_first_item_that_is_not_taken_ends_it() -> None:
    talk = Talk(reading(3, refusal=5)).hear(item(0), item(1))
    assert talk.exchange.result == 5


def test_the_other_side_may_break_it_off() -> None:
    with refuses("mission-refused", "", "item 2", "DENIED"):
        Talk(reading(3)).hear(item(0), Ack(Result.DENIED))


def test_a_doubtful_refusal_counts_only_when_silence_follows() -> None:
    assert Talk(reading(1)).hear(Ack(Result.ERROR), item(0)).exchange.result == Result.ACCEPTED
    with refuses("mission-refused", "", "ERROR"):
        Talk(reading(1)).hear(Ack(Result.ERROR)).wait(FAR)


def test_fetching_in_silence_says_how_far_it_came() -> None:
    with refuses("no-answer", "", "1 of 3", "rally list"):
        Talk(reading(3, kind=MissionType.RALLY)).hear(item(0, 2)).wait(FAR)


# --- reading and clearing -------------------------------------------------------------------------------------------


def test_a_download_ends_with_our_acknowledgement() -> None:
    talk = Talk(download(0))
    assert talk.sent == [RequestList()]
    assert talk.hear(Count(5, 1), Count(1)).sent == [Request(0)]
    assert talk.hear(item(0)).sent == [Ack(Result.ACCEPTED)]
    assert talk.exchange.result == ITEMS[:1]


def test_a_list_that_the_vehicle_closed_is_opened_again_and_read_on() -> None:
    talk = Talk(download(0)).hear(Count(2), item(0))
    _ = talk.sent
    talk.until(RequestList)
    assert talk.hear(Count(2)).sent[-1] == Request(1)
    assert talk.hear(item(1)).exchange.result == ITEMS[:2]


def test_another_list_in_between_is_read_from_its_beginning() -> None:
    talk = Talk(download(0)).hear(Count(2), item(0))
    _ = talk.sent
    talk.until(RequestList)
    assert talk.hear(Count(3)).sent[-1] == Request(0)
    assert talk.hear(item(0), item(1), item(2)).exchange.result == ITEMS


def test_a_download_that_gets_no_further_is_given_up() -> None:
    talk = Talk(download(0)).hear(Count(2), item(0))
    _ = talk.sent
    for _ in range(3):
        talk.until(RequestList).hear(Count(2))
    with refuses("no-answer", "", "1 of 2"):
        talk.wait(FAR)


def test_a_download_from_one_who_falls_silent_says_how_far_it_came() -> None:
    with refuses("no-answer", "", "1 of 2"):
        Talk(download(0)).hear(Count(2), item(0)).wait(FAR)
    with pytest.raises(NoAnswer):
        Talk(download(0)).wait(FAR)


@pytest.mark.parametrize("conversation", [download, clear])
def test_a_refused_list_is_an_error_with_words(conversation: Callable[[int], Any]) -> None:
    talk = Talk(conversation(0)).hear(Text(4, "busy"), Ack(Result.ERROR), Ack(Result.DENIED, 1), Ack(Result.DENIED))
    with refuses("mission-refused", "", "DENIED"):
        talk.wait(1.0)


def test_clearing_is_asked_for_until_it_is_confirmed() -> None:
    talk = Talk(clear(255))
    assert talk.wait(2.0).sent == [ClearAll(255), ClearAll(255)]
    assert talk.hear(Ack(0, 255)).exchange.finished


def test_clearing_in_silence_is_an_error() -> None:
    with pytest.raises(NoAnswer):
        Talk(clear(0)).wait(FAR)


# --- both ends ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("kind", [MissionType.MISSION])
def test_lists_offered_by_one_end_arrive_at_the_other(autopilot: Autopilot, kind: int) -> None:
    vehicle = Vehicle(autopilot)
    air = Air(vehicle, [Fate(), Fate(2, 0.05), Fate(0), Fate(1, 0.4)])
    assert air.hold(offer(items_of(autopilot, 40), kind)) in (Result.ACCEPTED, Result.ERROR, None)
    assert len(vehicle.holds()) == 40
    assert len(air.hold(download(kind))) == 40
    air.hold(clear(kind))
    assert vehicle.holds() == ()


def test_lists_are_called_what_humans_call_them() -> None:
    assert [list_name(kind) for kind in (0, 1, 2, 255, 9)] == ["mission", "fence", "rally list", "lists", "lists"]


@pytest.mark.parametrize(("kind", "name"), [(0, "mission"), (1, "fence"), (2, "rally list")])
def test_words_on_a_list_agree_in_number(kind: int, name: str) -> None:
    differs = ReadBackDiffers(kind, Difference(1, "param1", "1", "2"))
    assert f"{differs}".startswith(f"the {name} on the vehicle is not what was sent: ")
    assert ListAboard.EITHER.words(name) == f"the vehicle holds a whole {name}, the old or the new one"


def test_only_the_last_words_are_kept() -> None:
    texts = VehicleTexts()
    for n in range(30):
        texts.note(Text(4, f"word {n}"))
        texts.note(Text(7, "chatter"))
    texts.note(None)
    assert texts.words == [f"word {n}" for n in range(10, 30)]


def test_every_error_is_one_that_the_command_line_can_tell() -> None:
    assert issubclass(MissionRefused, MissionError)
    assert CLIENT.system == 245
