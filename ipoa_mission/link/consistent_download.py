"""A list read while nobody changed it: read item by item, it may have been replaced between two answers."""

from collections.abc import Iterator

from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import list_name, read_list
from ipoa_mission.link.dialogue import Dialogue, NoAnswer
from ipoa_mission.link.file_transfer import list_checksum
from ipoa_mission.link.item_payloads import unpack_items
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, silent

READINGS = 5  # of a list that is changed, or seems to be, each time that it is read


class KeepsChanging(MissionError):
    """The vehicle holds what it was sent, and keeps speaking of another list."""

    def __init__(self, kind: int) -> None:
        super().__init__(
            f"the vehicle speaks of another {list_name(kind)} each time that the one on it is read",
            hint="is another station sending it one? upload again when it is done",
        )


def read_consistent(
    kind: int, numbers: Iterator[int] | None, progress: Progress = silent
) -> Dialogue[tuple[list[Item | bytes], int]]:
    """The list that the vehicle holds, and its checksum, which was the same before it was read (0: it makes none).

    `numbers` of the questions for it, where it may make one; without that nothing shows that the list was read whole.

    Raises:
        Unsettled: it was another list each time.
        MissionRefused, NoAnswer.
    """
    before = None if numbers is None else (yield from _first_checksum(kind, numbers))
    for _ in range(READINGS):
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
    """Read the list that the vehicle holds, as it stands on the wire; raises as `read_consistent` does."""
    stored, _ = yield from read_consistent(kind, numbers, progress)
    return tuple(one if isinstance(one, Item) else unpack_items(one)[0] for one in stored)


def _first_checksum(kind: int, numbers: Iterator[int]) -> Dialogue[int | None]:
    """One that is asked for so often in vain is not made."""
    try:
        return (yield from list_checksum(kind, numbers))
    except NoAnswer:
        return None
