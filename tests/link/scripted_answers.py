"""A dialogue with nobody but a script."""

from typing import TypeVar

from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange
from ipoa_mission.link.messages import (
    Message,
)

T = TypeVar("T")


def lead(dialogue: Dialogue[T], answers: dict[type[Message], list[list[Message]]]) -> Exchange[T]:
    """Answer each kind of message from a script, then with silence."""
    exchange, now = Exchange(dialogue, 0.0, SPECIFIED), 0.0
    while not exchange.finished:
        said = exchange.outgoing()
        for message in said:
            script = answers.get(type(message))
            for answer in script.pop(0) if script else []:
                now += 0.2
                exchange.receive(answer, now)
        if not said:
            now = max(now, exchange.deadline)
            exchange.tick(now)
    return exchange
