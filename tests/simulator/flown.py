"""A built-in autopilot without a link."""

from collections.abc import Sequence
from dataclasses import replace

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.messages import CommandAck, CommandLong, Count, Current, ItemAt, Message
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from tests.link_pair import CLIENT, HOME, items_of, plain


class Flown:
    def __init__(self, autopilot: Autopilot, items: Sequence[Item], mock: Mock | None = None) -> None:
        self.mock = mock or Mock(autopilot, HOME)
        self.now = 1.0
        self.first = 1 if autopilot is Autopilot.ARDUPILOT else 0
        if autopilot is Autopilot.ARDUPILOT:
            self.command(511, 42.0, 200_000.0)  # its current item, on request only
        self.uploaded = self.upload(items) if items else []

    def upload(self, items: Sequence[Item]) -> list[Message]:
        wire = [*items_of(Autopilot.ARDUPILOT, 1), *items] if self.first else [*items]
        messages = self.hear(Count(len(wire)))
        return messages + [plain(answer) for seq, item in enumerate(wire) for answer in self.hear(ItemAt(seq, item))]

    @property
    def current(self) -> Current:
        return next(replace(each, mission_mode=0, mission_id=0) for each in self.fly(1.1) if isinstance(each, Current))

    def hear(self, message: Message) -> list[Message]:
        self.mock.receive(message, CLIENT, self.now)
        return [message for message, _ in self.mock.outgoing()]

    def command(self, number: int, *params: float) -> int:
        answers = self.hear(CommandLong(number, (*params, *(0.0,) * (7 - len(params)))))  # type: ignore[arg-type]
        return next(answer.result for answer in answers if isinstance(answer, CommandAck))

    def fly(self, seconds: float) -> list[Message]:
        messages: list[Message] = []
        until = self.now + seconds
        while self.now < until:
            self.now += 0.05
            self.mock.tick(self.now)
            messages += [message for message, _ in self.mock.outgoing()]
        return messages
