"""Follow the mission transfers in a log, to know the items that the vehicle holds."""

from dataclasses import dataclass, field

from ipoa_mission.errors import MissionError
from ipoa_mission.link import messages as m
from ipoa_mission.link.mavftp import MISSION_FILE, Opcode, unpack
from ipoa_mission.link.mission_upload_file import unpack_mission
from ipoa_mission.mission.items import Item

Items = tuple[Item, ...]


@dataclass
class _List:
    count: int
    to_vehicle: bool
    items: dict[int, Item] = field(default_factory=dict)

    @property
    def whole(self) -> Items | None:
        return tuple(self.items[n] for n in range(self.count)) if len(self.items) == self.count else None


class Transfers:
    """`note` returns the items that the vehicle then holds."""

    def __init__(self) -> None:
        self._held: Items = ()
        self._list: _List | None = None
        self._file: dict[int, bytes] | None = None  # mission.dat: data by offset
        self._written = False

    def note(self, message: m.Message, by_vehicle: bool) -> Items | None:
        held = self._note_file(message, by_vehicle) if isinstance(message, m.FileTransfer) else None
        match message:
            case m.Count(count, m.MissionType.MISSION):
                if self._list is None or (self._list.count, self._list.to_vehicle) != (count, not by_vehicle):
                    self._list = _List(count, not by_vehicle)
                held = () if by_vehicle and not count else None
            case m.WritePartialList(first, _, m.MissionType.MISSION) if first < len(self._held):
                self._list = _List(len(self._held), True, dict(enumerate(self._held)))
            case m.ClearAll(m.MissionType.MISSION | m.MissionType.ALL):
                self._list = _List(0, True)
            case m.ItemAt(seq, item, m.MissionType.MISSION) if self._list and seq < self._list.count:
                if by_vehicle != self._list.to_vehicle:
                    self._list.items[seq] = item
                    held = self._list.whole if by_vehicle else None
            case m.Ack(result, m.MissionType.MISSION | m.MissionType.ALL) if by_vehicle and self._list:
                held = self._list.whole if self._list.to_vehicle and result == m.Result.ACCEPTED else None
        if held is not None:
            self._held, self._list = held, None
        return held

    def _note_file(self, message: m.FileTransfer, by_vehicle: bool) -> Items | None:
        request = unpack(message)
        match request.opcode:
            case Opcode.OPEN_FILE_RO | Opcode.CREATE_FILE | Opcode.OPEN_FILE_WO:
                ours = request.data.rstrip(b"\0").decode("utf-8", "replace") == MISSION_FILE
                self._file = {} if ours else None
                self._written = request.opcode != Opcode.OPEN_FILE_RO
            case Opcode.WRITE_FILE if self._file is not None:
                self._file[request.offset] = request.data
            case Opcode.ACK if self._file is not None and request.request in (Opcode.READ_FILE, Opcode.BURST_READ_FILE):
                self._file[request.offset] = request.data
                return None if self._written else self._whole_file()
            case Opcode.ACK if self._written and request.request == Opcode.TERMINATE_SESSION:
                return self._whole_file()
        return None

    def _whole_file(self) -> Items | None:
        data = b"".join(chunk for _, chunk in sorted((self._file or {}).items()))
        try:
            return unpack_mission(data)
        except MissionError:
            return None
