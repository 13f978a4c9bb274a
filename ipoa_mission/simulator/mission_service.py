"""Serve the three mission lists, as measured (see `mock_profile`) or by the firmware's source."""

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ipoa_mission.autopilot.commands import PLAIN_FRAME
from ipoa_mission.errors import MissionError
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.conversations import MissionRefused, fetch, offer
from ipoa_mission.link.dialogue import Exchange, NoAnswer, Tell
from ipoa_mission.link.item_run import ItemsRead
from ipoa_mission.link.messages import (
    INFO,
    WARNING,
    Ack,
    ClearAll,
    Count,
    ItemAt,
    Message,
    MissionType,
    Request,
    RequestList,
    Result,
    Text,
    WritePartialList,
)
from ipoa_mission.mission.fence_items import fence_from_wire
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import home_item
from ipoa_mission.simulator.judgement import judge
from ipoa_mission.simulator.mock_profile import Answer, MockProfile
from ipoa_mission.simulator.store import Store
from ipoa_mission.world.frame import Geodetic

INT_FRAMES = {int(plain): int(whole) for whole, plain in PLAIN_FRAME.items()}
KINDS = (MissionType.MISSION, MissionType.FENCE, MissionType.RALLY)
MOST_READERS = 16
#: Orders in `current` outside guided mode: 2 ("go there now"), 3 ("change altitude").
ORDERS: Mapping[int, int] = {2: Result.ERROR, 3: Result.ACCEPTED}


@dataclass
class Incoming:
    client: Target
    kind: int
    count: int
    received: int
    exchange: Exchange[int]


class MissionService:
    """`say` sends a message, `changed` gets each replaced list."""

    def __init__(
        self,
        mock_profile: MockProfile,
        home: Callable[[], Geodetic],
        say: Callable[[Message, Target], None],
        changed: Callable[[int], None],
        nak_at: int | None = None,
    ) -> None:
        self.booted = False
        self.stores = {
            kind: Store(mock_profile.autopilot, mock_profile.firmware.version, kind in mock_profile.truncating)
            for kind in KINDS
        }
        self._habits = mock_profile
        self._home = home
        self._say = say
        self._changed = changed
        self._nak_at = nak_at
        self._incoming: dict[int, Incoming] = {}
        self._readers: dict[tuple[Target, int], Exchange[int | None]] = {}
        self._last_done: tuple[Target, int, int] | None = None
        self._named: dict[int, tuple[tuple[Item, ...], int]] = {}  # by kind

    def receive(self, message: Message, client: Target, now: float) -> bool:
        """Return whether a message belongs to the mission protocol."""
        match message:
            case Count(count, kind):
                self._begin(count, kind, client, now)
            case ItemAt():
                self._take(message, client, now)
            case RequestList(kind):
                self._list(kind, client, now)
            case Request(seq, kind):
                self._read(seq, kind, message, client, now)
            case Ack():
                self._acknowledge(message, client)
            case ClearAll(kind):
                self._clear(kind, client)
            case WritePartialList(first, last, kind):
                self._begin_partial(first, last, kind, client, now)
            case _:
                return False
        return True

    def tick(self, now: float) -> None:
        for incoming in [*self._incoming.values()]:
            self._drive(incoming, now, lambda one: one.exchange.tick(now))
        for reader, exchange in [*self._readers.items()]:
            try:
                exchange.tick(now)
            except MissionError:
                del self._readers[reader]
                continue
            self._flush_reader(reader, exchange)

    @property
    def deadline(self) -> float:
        if not self._incoming and not self._readers:
            return math.inf
        uploads = [one.exchange.deadline for one in self._incoming.values()]
        return min((*uploads, *(reader.deadline for reader in self._readers.values())), default=math.inf)

    def is_under_way(self, client: Target) -> bool:
        return any(one.client == client for one in self._incoming.values()) or any(
            reader == client for reader, _ in self._readers
        )

    def listed(self, kind: int) -> tuple[Item, ...]:
        items = self.stores[MissionType(kind)].items
        if kind == MissionType.MISSION and self._habits.autopilot.counts_home and items:
            return (home_item(self._home()), *items[1:])
        return items

    def replace(self, items: tuple[Item, ...]) -> bool:
        """Return False if an item is refused."""
        kind = MissionType.MISSION
        results = [judge(self._habits.autopilot, self._habits.firmware, item, kind, len(items)) for item in items]
        if not self.booted or self._slot(kind) in self._incoming or len(items) > self._habits.limits[kind]:
            return False
        if any(result != Result.ACCEPTED for result in results):
            return False
        self.stores[kind].begin(len(items))
        for seq, item in enumerate(items):
            self.stores[kind].keep(seq, item)
        self.stores[kind].commit()
        self._changed(kind)
        return True

    def _begin(self, count: int, kind: int, client: Target, now: float) -> None:
        if kind not in KINDS:
            self._say(Ack(Result.UNSUPPORTED, kind), client)
            return
        if not self.booted:
            self._say(Ack(Result.NO_SPACE, kind), client)
            return
        busy = self._incoming.get(self._slot(kind))
        if busy:
            answer = self._habits.count_from_stranger
            if busy.client == client:
                answer = Answer.OBEY if busy.received == 0 and busy.kind == kind else self._habits.count_again
            if answer is not Answer.OBEY:
                self._reply(answer, kind, client, "mission transfer busy")
                return
        elif not self._habits.separate_lists and self._readers:
            self._say(Ack(Result.ERROR, kind), client)
            return
        limit = self._habits.limits[kind]
        if count > limit:
            self._say(Ack(Result.NO_SPACE, kind), client)
            self._say(Text(WARNING, f"Only {limit} items are supported"), client)
            return
        self._incoming.pop(self._slot(kind), None)
        self.stores[MissionType(kind)].begin(count)
        if count == 0:
            self._say(Ack(Result.ACCEPTED, kind), client)
            self.stores[MissionType(kind)].clear()
            self._changed(kind)
            return
        self._open(kind, client, 0, count, now)

    def _begin_partial(self, first: int, last: int, kind: int, client: Target, now: float) -> None:
        if not self._habits.partial_lists or kind not in KINDS:
            return
        if self._slot(kind) in self._incoming:
            self._say(Ack(Result.DENIED, kind), client)
        elif not 0 <= first <= last < len(self.stores[MissionType(kind)].items):
            self._say(Ack(Result.ERROR, kind), client)
            self._say(Text(WARNING, "Flight plan update rejected"), client)
        else:
            self._open(kind, client, first, last + 1, now)

    def _open(self, kind: int, client: Target, first: int, count: int, now: float) -> None:
        dialogue = fetch(
            count, kind, self._taker(kind, count), self._habits.protocol_profile, ItemsRead(kind, count, at=first)
        )
        incoming = Incoming(client, kind, count, 0, Exchange(dialogue, now, self._habits.patience))
        self._incoming[self._slot(kind)] = incoming
        self._flush(incoming)

    def _taker(self, kind: int, count: int) -> Callable[[int, ItemAt], int]:
        firmware = self._habits.firmware

        def take(seq: int, heard: ItemAt) -> int:
            result = (
                Result.ERROR
                if seq == self._nak_at
                else judge(self._habits.autopilot, firmware, heard.item, kind, count)
            )
            if result == Result.ACCEPTED:
                self.stores[MissionType(kind)].keep(seq, heard.item)
                self._incoming[self._slot(kind)].received += 1
            return result

        return take

    def _take(self, message: ItemAt, client: Target, now: float) -> None:
        if message.current in ORDERS and self._habits.takes_orders_as_items:
            self._say(Ack(ORDERS[message.current], message.kind), client)
            return
        incoming = self._incoming.get(self._slot(message.kind))
        if incoming is None or incoming.client != client:
            if self._habits.confirms_last_item_again and self._last_done == (client, message.kind, message.seq):
                self._say(Ack(Result.ACCEPTED, message.kind), client)
            else:
                self._reply(self._habits.stray_item, message.kind, client)
        elif incoming.kind != message.kind:
            self._reply(self._habits.wrong_list, message.kind, client)
        else:
            self._drive(incoming, now, lambda one: one.exchange.receive(message, now))

    def _drive(self, incoming: Incoming, now: float, step: Callable[[Incoming], None]) -> None:
        try:
            step(incoming)
        except (NoAnswer, MissionRefused):
            self._drop(incoming)
            if self._habits.timeout_result is not None:
                self._say(Ack(self._habits.timeout_result, incoming.kind), incoming.client)
            self._say(Text(WARNING, self._habits.timeout_text), incoming.client)
            return
        self._flush(incoming)
        if incoming.exchange.finished:
            self._drop(incoming)
            self._conclude(incoming, incoming.exchange.result)

    def _conclude(self, incoming: Incoming, result: int) -> None:
        store = self.stores[MissionType(incoming.kind)]
        if result == Result.ACCEPTED and incoming.kind == MissionType.FENCE and not self._is_fence(store):
            result = Result.ERROR
        if result == Result.ACCEPTED:
            store.commit()
            self._last_done = (incoming.client, incoming.kind, incoming.count - 1)
        number = self.list_id(incoming.kind) if result == Result.ACCEPTED else 0
        self._say(Ack(result, incoming.kind, number), incoming.client)
        if result == Result.ACCEPTED:
            if words := self._habits.stored_text.get(incoming.kind):
                self._say(Text(INFO, words), EVERYONE)
            self._changed(incoming.kind)

    @staticmethod
    def _is_fence(store: Store) -> bool:
        try:
            fence_from_wire(store.staged)
        except MissionError:
            return False
        return True

    def _drop(self, incoming: Incoming) -> None:
        if self._incoming.get(self._slot(incoming.kind)) is incoming:
            del self._incoming[self._slot(incoming.kind)]

    def _flush(self, incoming: Incoming) -> None:
        for message in incoming.exchange.outgoing():
            self._say(message, incoming.client)

    def _list(self, kind: int, client: Target, now: float) -> None:
        if kind not in KINDS:
            self._say(Ack(Result.UNSUPPORTED, kind), client)
        elif self._slot(kind) in self._incoming:
            self._reply(self._habits.read_during_upload, kind, client, "mission transfer busy")
        elif self._habits.reads_item_by_item:
            self._say(Count(len(self.listed(kind)), kind), client)
        else:
            exchange = Exchange(offer(self._read_back(kind), kind, Tell), now, self._habits.patience)
            self._readers.pop((client, kind), None)
            self._readers[client, kind] = exchange
            while len(self._readers) > MOST_READERS:
                del self._readers[next(iter(self._readers))]
            self._flush_reader((client, kind), exchange)

    def _read_back(self, kind: int) -> tuple[Item, ...]:
        """Apply the flags and frames that this firmware reports."""
        items = self.listed(kind)
        if kind not in self._habits.flags_kept:
            items = tuple(replace(item, autocontinue=False) for item in items)
        if self._habits.int_frames:
            items = tuple(replace(item, frame=INT_FRAMES.get(item.frame, item.frame)) for item in items)
        return items

    def list_id(self, kind: int) -> int:
        items = self.stores[MissionType(kind)].items
        if not items or not self._habits.reports_list_id:
            return 0
        if self._named.get(kind, ((), 0))[0] is not items:
            self._named[kind] = items, zlib.crc32(repr(items).encode())
        return self._named[kind][1]

    def _read(self, seq: int, kind: int, message: Request, client: Target, now: float) -> None:
        if kind not in KINDS:
            return
        if self._slot(kind) in self._incoming:
            self._reply(self._habits.read_during_upload, kind, client, "mission transfer busy")
        elif reader := self._readers.get((client, kind)):
            reader.receive(message, now)
            self._flush_reader((client, kind), reader)
        elif self._habits.reads_item_by_item:
            self._read_one(seq, kind, message.legacy, client)

    def _read_one(self, seq: int, kind: int, legacy: bool, client: Target) -> None:
        """Send an item as it is now, even if the list has changed."""
        items = self._read_back(kind)
        if seq < len(items):
            self._say(ItemAt(seq, items[seq], kind), client)
            return
        if not legacy:
            self._say(Count(len(items), kind), client)
        self._say(Ack(Result.INVALID_SEQUENCE, kind), client)

    def _acknowledge(self, message: Ack, client: Target) -> None:
        incoming = self._incoming.get(self._slot(message.kind))
        if incoming and incoming.client == client and message.result == Result.OPERATION_CANCELLED:
            if self._habits.obeys_cancel:
                self._drop(incoming)
            return
        self._readers.pop((client, message.kind), None)

    def _flush_reader(self, reader: tuple[Target, int], exchange: Exchange[int | None]) -> None:
        for message in exchange.outgoing():
            self._say(message, reader[0])
        if exchange.finished:
            self._readers.pop(reader, None)

    def _clear(self, kind: int, client: Target) -> None:
        kinds = KINDS if kind == MissionType.ALL else tuple(one for one in KINDS if one == kind)
        if kind not in KINDS and not self._habits.clears_all:
            self._say(Ack(Result.UNSUPPORTED, kind), client)
            return
        busy = {self._slot(one) for one in kinds} & set(self._incoming)
        if busy and self._habits.clear_during_upload is not Answer.OBEY:
            self._reply(self._habits.clear_during_upload, kind, client, "mission transfer busy")
            return
        for slot in busy:
            del self._incoming[slot]
        for one in kinds:
            self.stores[one].clear()
            self._changed(one)
        self._say(Ack(Result.ACCEPTED, kind), client)

    def _slot(self, kind: int) -> int:
        """Return the key of transfers that exclude each other."""
        return kind if self._habits.separate_lists else 0

    def _reply(self, answer: Answer, kind: int, client: Target, words: str = "") -> None:
        match answer:
            case Answer.TEXT:
                self._say(Text(WARNING, words), client)
            case Answer.DENIED:
                self._say(Ack(Result.DENIED, kind), client)
            case Answer.ERROR:
                self._say(Ack(Result.ERROR, kind), client)
