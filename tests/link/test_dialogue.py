import math
from typing import Any

import pytest

from ipoa_mission.link.dialogue import (
    SPECIFIED,
    Ask,
    Cancelled,
    Dialogue,
    Exchange,
    NoAnswer,
    Pause,
    RetryPolicy,
    RoundTrip,
    SendOnce,
    Tell,
)
from ipoa_mission.link.messages import Ack, Count, Heartbeat, Message, Request

BEAT = Heartbeat(2, 12)


def asking(item: bool = False) -> Dialogue[Message | None]:
    heard = yield Ask(Count(3), item)
    while not isinstance(heard, Request):
        heard = yield None
    return heard


def run_until(exchange: Exchange[Any], now: float) -> list[tuple[float, Message]]:
    """Let time pass; return messages with times."""
    sent = [(0.0, message) for message in exchange.outgoing()]
    while exchange.deadline <= now:
        moment = exchange.deadline
        exchange.tick(moment)
        sent += [(moment, message) for message in exchange.outgoing()]
    return sent


def test_a_request_is_sent_at_once_and_again_after_the_specified_timeout() -> None:
    sent = run_until(Exchange(asking(), 0.0, RetryPolicy(adapt=False)), 3.1)
    assert sent == [(0.0, Count(3)), (1.5, Count(3)), (3.0, Count(3))]


def test_an_item_has_the_shorter_timer() -> None:
    sent = run_until(Exchange(asking(item=True), 0.0, RetryPolicy(adapt=False)), 0.6)
    assert [when for when, _ in sent] == [0.0, 0.25, 0.5]


def test_silence_is_an_error() -> None:
    exchange = Exchange(asking(), 0.0, RetryPolicy(adapt=False))
    with pytest.raises(NoAnswer):
        run_until(exchange, 60.0)
    assert exchange.deadline == pytest.approx(SPECIFIED.silence_s)


def test_a_busy_vehicle_on_a_fast_link_keeps_the_specified_timeout() -> None:
    rtt = RoundTrip(SPECIFIED)
    rtt.sample(0.001)
    exchange = Exchange(asking(), 0.0, SPECIFIED, rtt)
    times: list[float] = []

    def wait() -> None:
        while not exchange.finished:
            times.extend(exchange.deadline for _ in exchange.outgoing())
            exchange.receive(BEAT, exchange.deadline)
            exchange.tick(exchange.deadline)

    with pytest.raises(NoAnswer):
        wait()
    assert exchange.deadline == pytest.approx(SPECIFIED.silence_s, abs=SPECIFIED.answer_s)
    assert SPECIFIED.alive_retries < len(times) < 30  # quickly at first, then at the specification's pace


def test_vehicle_that_is_heard_gets_more_patience() -> None:
    exchange = Exchange(asking(), 0.0, RetryPolicy(adapt=False))
    second = 0
    while exchange.deadline < (SPECIFIED.alive_retries + 1) * SPECIFIED.answer_s - 0.01:
        exchange.receive(BEAT, float(second))
        run_until(exchange, second + 0.9)
        second += 1
    with pytest.raises(NoAnswer):
        run_until(exchange, exchange.deadline)


def test_an_answer_ends_the_waiting_and_the_result_is_returned() -> None:
    exchange = Exchange(asking(), 0.0, SPECIFIED)
    exchange.receive(BEAT, 0.1)
    assert not exchange.finished
    with pytest.raises(RuntimeError):
        _ = exchange.result
    exchange.receive(Request(0), 0.2)
    assert exchange.finished
    assert exchange.result == Request(0)
    assert exchange.deadline == math.inf


def test_a_finished_exchange_hears_and_says_nothing_more() -> None:
    exchange = Exchange(asking(), 0.0, SPECIFIED)
    exchange.receive(Request(0), 0.2)
    exchange.outgoing()
    exchange.receive(Request(1), 0.3)
    exchange.tick(100.0)
    exchange.interrupt(Cancelled("cancelled"), 100.0)
    assert exchange.outgoing() == []


def test_reported_progress_is_not_repeated() -> None:
    def telling() -> Dialogue[None]:
        yield Tell(Count(1))

    exchange = Exchange(telling(), 0.0, SPECIFIED)
    assert exchange.outgoing() == [Count(1)]
    exchange.tick(SPECIFIED.silence_s - 0.01)
    assert exchange.outgoing() == []
    with pytest.raises(NoAnswer):
        exchange.tick(SPECIFIED.silence_s)


def test_a_pause_ends_with_nothing_heard() -> None:
    heard: list[object] = []

    def pausing() -> Dialogue[None]:
        answer = yield Pause(2.0)
        while answer is not None:
            heard.append(answer)
            answer = yield None
        heard.append("over")

    exchange = Exchange(pausing(), 0.0, SPECIFIED)
    exchange.receive(BEAT, 1.0)
    exchange.tick(1.9)
    assert heard == [BEAT]
    exchange.tick(2.0)
    assert heard == [BEAT, "over"]


def test_a_remark_is_said_without_disturbing_what_is_awaited() -> None:
    def remarking() -> Dialogue[Message | None]:
        heard = yield Ask(Count(2))
        yield SendOnce(Ack(13))
        heard = yield None
        yield SendOnce(Ack(0))
        return heard

    exchange = Exchange(remarking(), 0.0, SPECIFIED)
    exchange.outgoing()
    exchange.receive(BEAT, 0.5)
    assert exchange.outgoing() == [Ack(13)]
    assert exchange.deadline == 1.5  # the question is still awaited
    exchange.receive(Request(0), 0.6)
    assert exchange.outgoing() == [Ack(0)]
    assert exchange.result == Request(0)


def answering() -> Dialogue[None]:
    heard = yield Ask(Count(9))
    while heard:
        heard = yield Tell(Ack(0))


def test_the_echo_of_a_question_is_not_answered_again() -> None:
    exchange = Exchange(answering(), 0.0, SPECIFIED)
    exchange.outgoing()
    exchange.receive(Request(0), 0.05)
    exchange.receive(Request(0), 0.12)
    assert exchange.outgoing() == [Ack(0)]
    exchange.receive(Request(0), 0.3)
    assert exchange.outgoing() == [Ack(0)]


def test_request_repeated_before_its_answer_is_answered_once() -> None:
    exchange = Exchange(answering(), 0.0, SPECIFIED)
    exchange.receive(Request(0), 0.4)  # so long is the round trip
    exchange.outgoing()
    exchange.receive(Request(0), 0.65)  # PX4 asks every quarter of a second
    assert exchange.outgoing() == []
    exchange.receive(Request(1), 0.8)
    exchange.receive(Request(1), 1.3)  # after a loss
    exchange.receive(Request(1), 1.45)
    assert exchange.outgoing() == [Ack(0)] * 3


def test_a_dialogue_may_catch_silence_and_try_another_way() -> None:
    def stubborn() -> Dialogue[str]:
        try:
            yield Tell(Count(1))
        except NoAnswer:
            yield Ask(Count(2))
        return "heard"

    exchange = Exchange(stubborn(), 0.0, SPECIFIED)
    exchange.tick(SPECIFIED.silence_s)
    assert exchange.outgoing() == [Count(1), Count(2)]
    exchange.receive(BEAT, 10.0)
    assert exchange.result == "heard"


def test_a_dialogue_may_end_well_when_it_is_cancelled() -> None:
    def yielding() -> Dialogue[str]:
        try:
            yield Ask(Count(1))
        except Cancelled:
            return "gave in"
        return "went on"

    exchange = Exchange(yielding(), 0.0, SPECIFIED)
    exchange.interrupt(Cancelled("cancelled"), 0.1)
    assert exchange.result == "gave in"


def test_a_dialogue_without_a_word_is_over_at_once() -> None:
    def mute() -> Dialogue[int]:
        return 7
        yield

    assert Exchange(mute(), 0.0, SPECIFIED).result == 7


def test_the_timer_follows_the_measured_round_trip() -> None:
    rtt = RoundTrip(SPECIFIED)
    assert (rtt.wait_s(item=False), rtt.wait_s(item=True)) == (1.5, 0.25)
    for _ in range(50):
        rtt.sample(0.6)
    assert 0.6 < rtt.wait_s(item=True) < 0.7
    for _ in range(50):
        rtt.sample(0.001)
    assert rtt.wait_s(item=True) == RoundTrip.FASTEST_S


def test_losing_packets_slows_the_timer_little_and_a_slow_link_much() -> None:
    lossy = RoundTrip(SPECIFIED)
    lossy.sample(0.5)
    usual = lossy.wait_s(item=True)
    for _ in range(10):
        lossy.repeated()
    assert lossy.wait_s(item=True) == RoundTrip.LONGEST_BACKOFF * usual
    for _ in range(RoundTrip.SLOW_LINK_REPEATS):
        lossy.doubts += 1
    for _ in range(10):
        lossy.repeated()
    assert lossy.wait_s(item=True) == RoundTrip.SLOWEST_S
    lossy.sample(0.5)
    assert lossy.wait_s(item=True) < usual


def test_fixed_timers_do_not_adapt() -> None:
    rtt = RoundTrip(RetryPolicy(adapt=False))
    rtt.sample(10.0)
    rtt.repeated()
    assert rtt.wait_s(item=False) == 1.5


def test_an_answer_to_a_repeated_question_is_no_measure() -> None:
    rtt = RoundTrip(SPECIFIED)
    exchange = Exchange(asking(), 0.0, SPECIFIED, rtt)
    exchange.tick(1.5)
    exchange.receive(Request(0), 1.6)
    assert rtt.wait_s(item=True) == pytest.approx(0.25 * 1.5)


def test_the_same_words_in_answer_to_a_new_question_are_no_echo() -> None:
    def asking_twice() -> Dialogue[int]:
        for n in range(2):
            heard = yield Ask(Request(n))
            while heard != Ack(0):
                heard = yield None
        return 2

    exchange = Exchange(asking_twice(), 0.0, SPECIFIED)
    exchange.receive(Ack(0), 0.01)
    exchange.receive(Ack(0), 0.02)
    assert exchange.finished
    assert exchange.outgoing() == [Request(0), Request(1)]
