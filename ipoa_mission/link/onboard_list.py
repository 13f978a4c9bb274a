"""Prove before arming that a vehicle holds a list, and watch it afterwards."""

import logging
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import KeepsChanging, MissionRefused, list_name, open_list, read_consistent
from ipoa_mission.link.dialogue import Dialogue, ListAboard, NoAnswer, SendOnce, until
from ipoa_mission.link.mavftp import answer_in, checksum_question, list_checksum
from ipoa_mission.link.messages import Current, Message, MissionState, MissionType
from ipoa_mission.link.upload import Replaced, Upload
from ipoa_mission.link.vehicle_state import NotReady, VehicleState
from ipoa_mission.mission.item_words import count_words

log = logging.getLogger(__name__)
CHECK_INTERVAL_S = 10.0  # [s] of the vehicle's clock


@dataclass
class OnboardList:
    """`changed`: later reports of another list."""

    job: Upload
    list_id: int = 0
    changed: str = ""
    is_reported: bool = False
    _asked: set[int] = field(default_factory=set)
    _due_s: float = -math.inf

    def note(self, message: Message, is_flying: bool = False) -> None:
        """Another id or number of items is a replacement; warn once in flight."""
        if self.job.kind == MissionType.MISSION and isinstance(message, Current):
            self.changed = self.changed or self._replacement(message)
        if self.changed and is_flying and not self.is_reported:
            self.is_reported = True
            log.warning("%s", ReplacedSince(self))

    def observe(self, heard: Message, now_s: float) -> Dialogue[None]:
        """Ask for the checksum at intervals; another one means to read again, because arming moves home."""
        numbers = self.job.numbers
        if self.changed or numbers is None:
            return
        answer = answer_in(heard, self._asked)
        if answer is not None and answer.checksum is not None:
            self._asked.clear()
            if answer.checksum != self.list_id:
                try:
                    self.list_id = (yield from _compare_list(self.job)) or self.list_id
                except Replaced as replaced:
                    self.changed = str(replaced.difference)
                except NotReady:  # another station may be uploading
                    return
        elif now_s >= self._due_s:
            self._due_s = now_s + CHECK_INTERVAL_S
            yield SendOnce(checksum_question(self.job.kind, numbers, self._asked))

    def is_confirmed_by(self, current: Current | None) -> bool:
        """Return whether the report is of our id and length."""
        if current is None or self.list_id == 0 or current.mission_id != self.list_id:
            return False
        return not self._replacement(current)

    def _replacement(self, current: Current) -> str:
        if self.list_id and current.mission_id not in (0, self.list_id):
            return f"it has the id {current.mission_id}, and ours has {self.list_id}"
        total = current.total
        is_unknown = total in (0, 65535)
        if is_unknown and current.mission_state == MissionState.NO_MISSION:
            return "there is none any more"
        sent = len(self.job.items) - self.job.autopilot.seq_offset
        return "" if is_unknown or total == sent else f"it has {count_words(total)}, and ours has {sent}"


class ReplacedSince(MissionError, code="replaced-since"):
    def __init__(self, onboard: OnboardList) -> None:
        super().__init__(f"the {list_name(onboard.job.kind)} on the vehicle is no longer ours: {onboard.changed}")


def prove(onboard_lists: Iterable[OnboardList], state: VehicleState) -> Dialogue[None]:
    """Prove each list by its id or checksum, else item by item; raise Replaced or NotReady."""
    for onboard in onboard_lists:
        if not (onboard.list_id and (yield from _is_named(onboard, state))):
            onboard.list_id = (yield from _compare_list(onboard.job)) or onboard.list_id
        onboard.changed = ""
        onboard.is_reported = False
        onboard._due_s = -math.inf


def _is_named(onboard: OnboardList, state: VehicleState) -> Dialogue[bool]:
    numbers = onboard.job.numbers
    if numbers is not None:
        try:
            yield from open_list(onboard.job.kind)  # refused while another station uploads
            return (yield from list_checksum(onboard.job.kind, numbers)) == onboard.list_id
        except (MissionRefused, NoAnswer) as nothing:
            raise _unknown(onboard.job, nothing) from None
    state.current = None
    yield from until(lambda: state.current is not None, 1.5)
    return onboard.is_confirmed_by(state.current)


def prove_after_flight(onboard: OnboardList, state: VehicleState) -> Dialogue[None]:
    """A replacement may have the length of a list without an id."""
    is_watched = onboard.list_id != 0 and onboard.job.numbers is None
    if is_watched or onboard.changed:
        return
    try:
        yield from prove([onboard], state)
    except Replaced as replaced:
        onboard.changed = f"when it was read after the flight, {replaced.difference}"


def with_lists(failed: MissionError, kind: int, sent: Sequence[int]) -> MissionError:
    """Add each list's state after a failure in the list `kind`."""
    names = [list_name(each) for each in sent]
    at = list(sent).index(kind)
    new = f"it holds the new {' and the new '.join(names[:at])}" if at > 0 else ""
    old = f"it keeps the {' and the '.join(names[at + 1 :])} that it had" if names[at + 1 :] else ""
    failed.args = ("; ".join(filter(None, (*failed.args, new, old))),)
    its_own = failed.known.get("list_on_vehicle", ListAboard.UNKNOWN)
    states = [ListAboard.NEW] * at + [its_own] + [ListAboard.OLD] * (len(names) - at - 1)
    failed.known["lists_on_vehicle"] = dict(zip(names, states, strict=True))
    return failed


def expect_unchanged(onboard_lists: Iterable[OnboardList]) -> None:
    for onboard in onboard_lists:
        if onboard.changed:
            raise ReplacedSince(onboard)


def _compare_list(job: Upload) -> Dialogue[int]:
    try:
        stored, checksum = yield from read_consistent(job.kind, job.numbers)
    except (MissionRefused, NoAnswer, KeepsChanging) as nothing:
        raise _unknown(job, nothing) from None
    difference = job.difference(stored)
    if difference is not None:
        raise Replaced(job.kind, difference)
    return checksum


def _unknown(job: Upload, nothing: MissionError) -> NotReady:
    return NotReady(
        f"it is unknown whether the vehicle still holds the {list_name(job.kind)} that was sent: {nothing}",
        hint="check whether another station is uploading",
        code="list-unproven",
    )
