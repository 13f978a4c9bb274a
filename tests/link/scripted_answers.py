from collections.abc import Callable, Sequence
from typing import TypeVar

from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange
from ipoa_mission.link.messages import Message

T = TypeVar("T")


def lead(dialogue: Dialogue[T], answers: dict[type[Message], list[list[Message]]]) -> Exchange[T]:
    """Answer each kind of message from a script, then with silence."""

    def answer(message: Message) -> Sequence[Message]:
        script = answers.get(type(message))
        return script.pop(0) if script else []

    return lead_by(dialogue, answer)


def lead_by(dialogue: Dialogue[T], answer: Callable[[Message], Sequence[Message]]) -> Exchange[T]:
    """Answer each message, 0.2 s apart; in silence time passes to the next deadline."""
    exchange, now = Exchange(dialogue, 0.0, SPECIFIED), 0.0
    while not exchange.finished:
        requests = exchange.outgoing()
        for message in requests:
            for answered in answer(message):
                now += 0.2
                exchange.receive(answered, now)
        if not requests:
            now = max(now, exchange.deadline)
            exchange.tick(now)
    return exchange
