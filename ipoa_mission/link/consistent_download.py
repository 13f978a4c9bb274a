"""Read a list that nobody changes meanwhile."""

from collections.abc import Iterator

from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import list_name, read_list
from ipoa_mission.link.dialogue import Dialogue, NoAnswer
from ipoa_mission.link.file_transfer import list_checksum
from ipoa_mission.link.item_payloads import unpack_items
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, silent

READ_ATTEMPTS = 5


class KeepsChanging(MissionError):
    """The vehicle holds what was sent, but keeps reporting another list."""

    def __init__(self, kind: int) -> None:
        super().__init__(
            f"the vehicle reports another {list_name(kind)} each time that its list is read",
            hint="is another station uploading? upload again when it is done",
        )


def read_consistent(
    kind: int, numbers: Iterator[int] | None, progress: Progress = silent
) -> Dialogue[tuple[list[Item | bytes], int]]:
    """Return the list and its checksum (0: none), equal before and after the reading.

    Without `numbers` for the checksum, a change goes unnoticed.

    Raises:
        KeepsChanging: the list differed each time.
        MissionRefused, NoAnswer.
    """
    before = None if numbers is None else (yield from _first_checksum(kind, numbers))
    for _ in range(READ_ATTEMPTS):
        stored = yield from read_list(kind, progress)
        if before is None or numbers is None:
            return stored, 0
        after = yield from list_checksum(kind, numbers)
        if after == before:
            return stored, after
        before = after
    raise KeepsChanging(kind)


def download(
    kind: int, progress: Progress = silent, numbers: Iterator[int] | None = None
) -> Dialogue[tuple[Item, ...]]:
    stored, _ = yield from read_consistent(kind, numbers, progress)
    return tuple(one if isinstance(one, Item) else unpack_items(one)[0] for one in stored)


def _first_checksum(kind: int, numbers: Iterator[int]) -> Dialogue[int | None]:
    try:
        return (yield from list_checksum(kind, numbers))
    except NoAnswer:
        return None
