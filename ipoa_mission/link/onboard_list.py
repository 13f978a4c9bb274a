"""What a vehicle was seen to hold, and whether it still does: proved before the arming, heard of afterwards."""

import logging
import math
from collections.abc import Iterable
from dataclasses import dataclass

from ipoa_mission.errors import MissionError
from ipoa_mission.link.consistent_download import KeepsChanging, read_consistent
from ipoa_mission.link.conversations import MissionRefused, list_name, open_list
from ipoa_mission.link.dialogue import Dialogue, NoAnswer, Remark, until
from ipoa_mission.link.file_transfer import checksum_in, checksum_question, list_checksum
from ipoa_mission.link.messages import NO_MISSION, Current, Message, MissionType
from ipoa_mission.link.upload import Replaced, Upload
from ipoa_mission.link.vehicle_state import NotReady, VehicleState

log = logging.getLogger(__name__)
NO_TOTAL = 65535  # MISSION_CURRENT.total where there is no mission
TOLD_S = 1.5  # how long MISSION_CURRENT is waited for
LOOK_S = 10.0  # between two looks in flight, on the vehicle's clock


@dataclass
class OnboardList:
    """A list that a vehicle was seen to hold, and its id or checksum there (0: neither is known).

    `changed`: what it has since said of another list, in words; `is_told`: the user knows.
    """

    job: Upload
    list_id: int = 0
    changed: str = ""
    is_told: bool = False

    @property
    def is_watched(self) -> bool:
        """Whether the vehicle itself tells of any other list in its place."""
        return self.list_id != 0 and not self.job.has_checksum

    def note(self, message: Message, is_flying: bool = False) -> None:
        """Hear the vehicle: a mission with another id, or with another number of items, is somebody else's.

        In flight a change is told as soon as it is known, once.
        """
        if self.job.kind == MissionType.MISSION and isinstance(message, Current):
            self.changed = self.changed or self._other(message)
        if self.changed and is_flying and not self.is_told:
            self.is_told = True
            log.warning("%s", ReplacedSince(self))

    def is_told_by(self, current: Current | None) -> bool:
        """Whether this message says that it is the very list that was sent."""
        is_ours = current is not None and self.list_id != 0 and current.mission_id == self.list_id
        return is_ours and current is not None and not self._other(current)

    def _other(self, current: Current) -> str:
        if self.list_id and current.mission_id not in (0, self.list_id):
            return f"it has the id {current.mission_id}, and ours has {self.list_id}"
        total = current.total
        sent = len(self.job.items) - self.job.autopilot.counts_home
        if total in (0, NO_TOTAL) and current.mission_state == NO_MISSION:
            return "there is none any more"
        return f"it has {total} items, and ours has {sent}" if total not in (0, NO_TOTAL, sent) else ""


class ReplacedSince(MissionError):
    """The vehicle holds another list than that which it was proved to hold before it was armed."""

    def __init__(self, holding: OnboardList) -> None:
        super().__init__(f"the {list_name(holding.job.kind)} on the vehicle is no longer ours: {holding.changed}")


def prove(holdings: Iterable[OnboardList], state: VehicleState) -> Dialogue[None]:
    """See that the vehicle holds each of these lists now: by the id or the checksum that it gave, else item by item.

    Raises:
        Replaced: it does not.
        NotReady: it does not tell.
    """
    for holding in holdings:
        if not (holding.list_id and (yield from _is_named(holding, state))):
            holding.list_id = (yield from _read_again(holding.job)) or holding.list_id
        holding.changed, holding.is_told = "", False


def _is_named(holding: OnboardList, state: VehicleState) -> Dialogue[bool]:
    """Whether the vehicle gives its list the same id, or the same checksum, as when it was seen."""
    if (numbers := holding.job.numbers) is not None:
        try:
            yield from open_list(holding.job.kind)  # refused while another one is being sent
            return (yield from list_checksum(holding.job.kind, numbers)) == holding.list_id
        except (MissionRefused, NoAnswer) as nothing:
            raise _unknown(holding.job, nothing) from None
    state.current = None
    yield from until(lambda: state.current is not None, TOLD_S)
    return holding.is_told_by(state.current)


def read_again(holding: OnboardList, state: VehicleState) -> Dialogue[None]:
    """Look once more, after a flight, at a list without an id: one of the same length may have come in its place."""
    if holding.is_watched or holding.changed:
        return
    try:
        yield from prove([holding], state)
    except Replaced as replaced:
        holding.changed = f"when it was read after the flight, {replaced.difference}"


class ListWatcher:
    """In flight, now and then, looks whether a list is still ours that the vehicle gives no id, but a checksum.

    Arming moves home, and home is summed up too: another checksum is no other list until the list has been read.
    """

    def __init__(self, holding: OnboardList) -> None:
        self._holding = holding
        self._due_s = -math.inf
        self._asked: set[int] = set()

    def look(self, heard: Message, now_s: float) -> Dialogue[None]:
        """Make of one message what it tells of the list, and ask again when it is time."""
        holding, numbers = self._holding, self._holding.job.numbers
        if holding.changed or numbers is None:
            return
        if (checksum := checksum_in(heard, self._asked)) is not None:
            self._asked.clear()
            if checksum != holding.list_id:
                yield from self._read_again()
        elif now_s >= self._due_s:
            self._due_s = now_s + LOOK_S
            question = checksum_question(holding.job.kind, numbers, self._asked)
            yield Remark(question)

    def _read_again(self) -> Dialogue[None]:
        try:
            self._holding.list_id = (yield from _read_again(self._holding.job)) or self._holding.list_id
        except Replaced as replaced:
            self._holding.changed = str(replaced.difference)
        except NotReady:  # somebody may be sending it one just now: the next look will tell
            return


def expect_unchanged(holdings: Iterable[OnboardList]) -> None:
    """Raise ReplacedSince where the vehicle has spoken of another list since it was proved to hold ours."""
    for holding in holdings:
        if holding.changed:
            raise ReplacedSince(holding)


def _read_again(job: Upload) -> Dialogue[int]:
    """Read a list once more, and see that it is ours; its checksum, if it has one."""
    try:
        stored, checksum = yield from read_consistent(job.kind, job.numbers)
    except (MissionRefused, NoAnswer, KeepsChanging) as nothing:
        raise _unknown(job, nothing) from None
    if (difference := job.difference(stored)) is not None:
        raise Replaced(job.kind, difference)
    return checksum


def _unknown(job: Upload, nothing: MissionError) -> NotReady:
    return NotReady(
        f"nobody knows whether the vehicle still holds the {list_name(job.kind)} that was sent: {nothing}",
        hint="is another station sending it one?",
        code="list-unproven",
    )
