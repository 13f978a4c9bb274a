"""Serve and judge the three mission lists, as measured (see `mock_profile`) or by the firmware's source."""

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import PLAIN_FRAME, Command
from ipoa_mission.autopilot.firmware_tables import Firmware
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.conversations import MissionRefused, fetch, offer
from ipoa_mission.link.dialogue import Exchange, NoAnswer, Tell
from ipoa_mission.link.vehicle_words import event
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import as_stored, fence_from_wire, home_item, values_of
from ipoa_mission.simulator.mock_profile import Answer, MockProfile

KINDS = (m.MissionType.MISSION, m.MissionType.FENCE, m.MissionType.RALLY)


@dataclass
class Store:
    """`truncating`: drop the old items at a transfer's start; a failed one leaves a mixture."""

    profile: MockProfile
    truncating: bool
    items: tuple[Item, ...] = ()
    staged: tuple[Item, ...] = ()  # the list after a complete transfer

    def begin(self, count: int) -> None:
        self.staged = ()
        if self.truncating:
            self.items = self.items[:count]

    def keep(self, item: Item) -> None:
        self.staged += as_stored((item,), self.profile.autopilot, self.profile.firmware.version)
        if self.truncating:
            self.items = (*self.staged, *self.items[len(self.staged) :])

    def put(self, items: tuple[Item, ...]) -> None:
        self.begin(len(items))
        for item in items:
            self.keep(item)
        self.items = self.staged


@lru_cache(maxsize=8)
def checksum_of(items: tuple[Item, ...]) -> int:
    return zlib.crc32(repr(items).encode())


@dataclass
class Incoming:
    client: Target
    kind: int
    count: int
    received: int
    exchange: Exchange[int]


@dataclass
class MissionService:
    """The vehicle's mission lists; `say` sends a message, `changed` gets each replaced list."""

    profile: MockProfile
    home: Callable[[], Geodetic]
    say: Callable[[m.Message, Target], None]
    changed: Callable[[int], None]
    booted: bool = False
    _incoming: dict[int, Incoming] = field(default_factory=dict)
    _readers: dict[tuple[Target, int], Exchange[int | None]] = field(default_factory=dict)
    _last_done: tuple[Target, int, int] | None = None

    def __post_init__(self) -> None:
        self.stores = {kind: Store(self.profile, kind in self.profile.truncating) for kind in KINDS}

    def receive(self, message: m.Message, client: Target, now: float) -> bool:
        """Return whether a message belongs to the mission protocol."""
        match message:
            case m.Count(count, kind):
                self._begin(count, kind, client, now)
            case m.ItemAt():
                self._take(message, client, now)
            case m.RequestList(kind):
                self._list(kind, client, now)
            case m.Request():
                self._read(message, client, now)
            case m.Ack():
                self._acknowledge(message, client)
            case m.ClearAll(kind):
                self._clear(kind, client)
            case _:
                return False
        return True

    def tick(self, now: float) -> None:
        for incoming in [*self._incoming.values()]:
            self._advance(incoming, lambda exchange: exchange.tick(now))
        for reader, exchange in [*self._readers.items()]:
            try:
                exchange.tick(now)
            except MissionError:
                del self._readers[reader]
                continue
            self._flush_reader(reader, exchange)

    @property
    def deadline(self) -> float:
        uploads = [incoming.exchange.deadline for incoming in self._incoming.values()]
        return min((*uploads, *(reader.deadline for reader in self._readers.values())), default=math.inf)

    def listed(self, kind: int) -> tuple[Item, ...]:
        items = self.stores[m.MissionType(kind)].items
        if kind == m.MissionType.MISSION and self.profile.autopilot.seq_offset and items:
            return (home_item(self.home()), *items[1:])
        return items

    def replace(self, items: tuple[Item, ...]) -> bool:
        """Return False if an item is refused."""
        kind = m.MissionType.MISSION
        if not self.booted or self._slot(kind) in self._incoming or len(items) > self.profile.limits[kind]:
            return False
        if any(self._judge(item, kind, len(items)) != m.Result.ACCEPTED for item in items):
            return False
        self.stores[kind].put(items)
        self.changed(kind)
        return True

    def _begin(self, count: int, kind: int, client: Target, now: float) -> None:
        profile = self.profile
        busy = self._incoming.get(self._slot(kind))
        if kind not in KINDS:
            return self._ack(m.Result.UNSUPPORTED, kind, client)
        if not self.booted:
            return self._ack(m.Result.NO_SPACE, kind, client)
        if busy:
            answer = profile.count_from_stranger
            if busy.client == client:
                answer = Answer.OBEY if busy.received == 0 and busy.kind == kind else profile.count_again
            if answer is not Answer.OBEY:
                return self._reply(answer, kind, client)
        elif not profile.separate_lists and self._readers:
            return self._ack(m.Result.ERROR, kind, client)
        limit = profile.limits[kind]
        if count > limit:
            self._ack(m.Result.NO_SPACE, kind, client)
            return self.say(m.Text(m.WARNING, f"Only {limit} items are supported"), client)
        self._incoming.pop(self._slot(kind), None)
        store = self.stores[m.MissionType(kind)]
        store.begin(count)
        if count == 0:
            self._ack(m.Result.ACCEPTED, kind, client)
            store.put(())
            return self.changed(kind)
        return self._open(count, kind, client, now)

    def _open(self, count: int, kind: int, client: Target, now: float) -> None:
        profile = self.profile
        store = self.stores[m.MissionType(kind)]

        def take(seq: int, item: Item) -> int:
            result = self._judge(item, kind, count)
            if result == m.Result.ACCEPTED:
                store.keep(item)
                incoming.received += 1
            return result

        dialogue = fetch(kind, count, take, legacy=profile.requests_legacy)
        incoming = Incoming(client, kind, count, 0, Exchange(dialogue, now, profile.retry_policy))
        self._incoming[self._slot(kind)] = incoming
        self._flush(incoming.exchange, client)

    def _judge(self, item: Item, kind: int, count: int) -> m.Result:
        return judge(self.profile.autopilot, self.profile.firmware, item, kind, count)

    def _take(self, message: m.ItemAt, client: Target, now: float) -> None:
        incoming = self._incoming.get(self._slot(message.kind))
        if incoming is None or incoming.client != client:
            if self.profile.confirms_last_item_again and self._last_done == (client, message.kind, message.seq):
                self._ack(m.Result.ACCEPTED, message.kind, client)
            else:
                self._reply(self.profile.stray_item, message.kind, client)
        elif incoming.kind != message.kind:
            self._ack(m.Result.ERROR, message.kind, client)
        else:
            self._advance(incoming, lambda exchange: exchange.receive(message, now))

    def _advance(self, incoming: Incoming, step: Callable[[Exchange[int]], None]) -> None:
        try:
            step(incoming.exchange)
        except (NoAnswer, MissionRefused):
            self._drop(incoming)
            if self.profile.timeout_result is not None:
                self._ack(self.profile.timeout_result, incoming.kind, incoming.client)
            self.say(m.Text(m.WARNING, self.profile.timeout_text), incoming.client)
            return
        self._flush(incoming.exchange, incoming.client)
        if incoming.exchange.finished:
            self._drop(incoming)
            self._conclude(incoming, incoming.exchange.result)

    def _conclude(self, incoming: Incoming, result: int) -> None:
        client = incoming.client
        kind = incoming.kind
        store = self.stores[m.MissionType(kind)]
        if result == m.Result.ACCEPTED and kind == m.MissionType.FENCE:
            try:
                fence_from_wire(store.staged)
            except MissionError:
                result = m.Result.ERROR
        if result != m.Result.ACCEPTED:
            self._ack(result, kind, client)
            return
        store.items = store.staged
        self._last_done = (client, kind, incoming.count - 1)
        self.say(m.Ack(result, kind, self.list_id(kind)), client)
        if text := self.profile.stored_text.get(kind):
            self.say(m.Text(m.INFO, text), EVERYONE)
        self.changed(kind)

    def _drop(self, incoming: Incoming) -> None:
        if self._incoming.get(self._slot(incoming.kind)) is incoming:
            del self._incoming[self._slot(incoming.kind)]

    def _flush(self, exchange: Exchange[Any], client: Target) -> None:
        for message in exchange.outgoing():
            self.say(message, client)

    def _list(self, kind: int, client: Target, now: float) -> None:
        if kind not in KINDS:
            self._ack(m.Result.UNSUPPORTED, kind, client)
        elif self._slot(kind) in self._incoming:
            self._reply(self.profile.read_during_upload, kind, client)
        elif self.profile.reads_item_by_item:
            self.say(m.Count(len(self.listed(kind)), kind), client)
        else:
            exchange = Exchange(offer(self._read_back(kind), kind, Tell), now, self.profile.retry_policy)
            self._readers.pop((client, kind), None)
            self._readers[client, kind] = exchange
            self._flush_reader((client, kind), exchange)

    def _read_back(self, kind: int) -> tuple[Item, ...]:
        items = self.listed(kind)
        if kind not in self.profile.flags_kept:
            items = tuple(replace(item, autocontinue=False) for item in items)
        if self.profile.int_frames:
            int_frames = {plain: int_frame for int_frame, plain in PLAIN_FRAME.items()}
            items = tuple(replace(item, frame=int_frames.get(item.frame, item.frame)) for item in items)
        return items

    def list_id(self, kind: int) -> int:
        items = self.stores[m.MissionType(kind)].items
        return checksum_of(items) if items and self.profile.reports_list_id else 0

    def _read(self, message: m.Request, client: Target, now: float) -> None:
        seq = message.seq
        kind = message.kind
        reader = self._readers.get((client, kind))
        if kind not in KINDS:
            return
        if self._slot(kind) in self._incoming:
            self._reply(self.profile.read_during_upload, kind, client)
        elif reader is not None:
            reader.receive(message, now)
            self._flush_reader((client, kind), reader)
        elif self.profile.reads_item_by_item:
            items = self._read_back(kind)  # even if the list has changed
            if seq < len(items):
                self.say(m.ItemAt(seq, items[seq], kind), client)
                return
            if not message.legacy:
                self.say(m.Count(len(items), kind), client)
            self._ack(m.Result.INVALID_SEQUENCE, kind, client)

    def _acknowledge(self, message: m.Ack, client: Target) -> None:
        incoming = self._incoming.get(self._slot(message.kind))
        if incoming and incoming.client == client and message.result == m.Result.OPERATION_CANCELLED:
            if self.profile.obeys_cancel:
                self._drop(incoming)
            return
        self._readers.pop((client, message.kind), None)

    def _flush_reader(self, reader: tuple[Target, int], exchange: Exchange[int | None]) -> None:
        self._flush(exchange, reader[0])
        if exchange.finished:
            self._readers.pop(reader, None)

    def _clear(self, kind: int, client: Target) -> None:
        kinds = KINDS if kind == m.MissionType.ALL else tuple(known for known in KINDS if known == kind)
        if kind not in KINDS and not self.profile.clears_all:
            self._ack(m.Result.UNSUPPORTED, kind, client)
            return
        busy = {self._slot(each) for each in kinds} & set(self._incoming)
        if busy and self.profile.clear_during_upload is not Answer.OBEY:
            self._reply(self.profile.clear_during_upload, kind, client)
            return
        for slot in busy:
            del self._incoming[slot]
        for each in kinds:
            self.stores[each].put(())
            self.changed(each)
        self._ack(m.Result.ACCEPTED, kind, client)

    def _ack(self, result: int, kind: int, client: Target) -> None:
        self.say(m.Ack(result, kind), client)

    def _slot(self, kind: int) -> int:
        return kind if self.profile.separate_lists else 0

    def _reply(self, answer: Answer, kind: int, client: Target) -> None:
        if answer is Answer.TEXT:
            self.say(m.Text(m.WARNING, "mission transfer busy"), client)
        elif answer is not Answer.SILENCE:
            self._ack(m.Result[answer.value], kind, client)


def judge(autopilot: Autopilot, firmware: Firmware, item: Item, kind: int, count: int) -> m.Result:
    refusals = autopilot.refusals
    about = (firmware, item.command, item.frame, values_of(item))
    if kind == m.MissionType.MISSION:
        refusal = refusals.mission(*about, count)
    else:
        refusal = (refusals.fence if kind == m.MissionType.FENCE else refusals.rally)(*about)
    return m.Result.ACCEPTED if refusal is None else m.Result[refusal.result]


def infeasibility(
    autopilot: Autopilot, firmware: Firmware, items: Sequence[Item], home: Geodetic, parameters: Parameters
) -> m.Event | None:
    """Return PX4's verdict, which it sends as an event alone; None if it can be flown."""
    moving = [item for item in items if not autopilot.guidance.may_precede_takeoff(item.command)]
    for seq, item in enumerate(items):
        if item.command in firmware.never_flown:
            return event("navigator_mis_unsup_cmd", seq + 1, item.command)
        if seq == 0 and item.command == Command.NAV_LAND:
            return event("navigator_mis_starts_w_landing")
        if item.command == Command.NAV_TAKEOFF:
            if item.height(home) <= 0.0:
                return event("navigator_mis_takeoff_too_low")
            if item is not moving[0]:
                return event("navigator_mis_takeoff_not_first")
    wrong = autopilot.refusals.ends({item.command for item in items}, parameters)
    return None if wrong is None else event(f"navigator_mis_{wrong.result}")
