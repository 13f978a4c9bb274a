"""A vehicle on a link, and what it can be told: upload, download, clear, set_current, prepare, start, watch, pause.

Each verb is one dialogue, held by `converse`; nothing here knows about bytes or timers.
"""

import itertools
import logging
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial

from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.start import begun_at, check_start
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.checks.version_check import check_aboard
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link import consistent_download, conversations, orders
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.conformance_watch import Conformance
from ipoa_mission.link.departure import (
    LIMITS,
    NEEDED,
    Departure,
    depart_when_ready,
    expect_on_ground,
    prepare,
    subscribe,
    unsubscribe,
)
from ipoa_mission.link.dialogue import SPECIFIED, Cancelled, Dialogue, NoAnswer, Patience, Silence, TimeUp, until
from ipoa_mission.link.discovery import FoundVehicle, await_booted
from ipoa_mission.link.file_transfer import FileRefused
from ipoa_mission.link.flight_order import SHOWN_S, FlightOrder, pause, resume, return_to_launch
from ipoa_mission.link.interrupt import noted_interrupts
from ipoa_mission.link.line import Carrier
from ipoa_mission.link.logbook import Aside, FlightRecord, Logbook, watch
from ipoa_mission.link.messages import Heartbeat, Message, MissionType
from ipoa_mission.link.mission_upload_file import upload_by_file
from ipoa_mission.link.mode_watch import ModeWatch
from ipoa_mission.link.onboard_list import ListWatcher, OnboardList, ReplacedSince, read_again
from ipoa_mission.link.reconnect import AGAIN_S, SILENT_S, KnownVehicle, LinkLoss
from ipoa_mission.link.remote_vehicle import RemoteVehicle
from ipoa_mission.link.upload import ReadBackDiffers, Unflyable, Unplaced, Upload, upload
from ipoa_mission.link.vehicle_state import NotReady, VehicleState
from ipoa_mission.mission.commands import LAST_NAV
from ipoa_mission.mission.fence_items import fence_from_wire, fence_to_wire, rally_from_wire, rally_to_wire
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.stored_mission import from_wire, to_wire
from ipoa_mission.progress import Progress, count, silent
from ipoa_mission.world.frame import Geodetic

log = logging.getLogger(__name__)
STARTUP_S = 60.0
LISTS = (MissionType.MISSION, MissionType.FENCE, MissionType.RALLY)


class Vehicle(RemoteVehicle):
    """One vehicle on a line; `connect` finds it. `close` it, or use it with `with`.

    Example:
        >>> from ipoa_mission import connect
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     vehicle.home().altitude
        488.0
    """

    def __init__(
        self,
        line: Carrier,
        heard: FoundVehicle,
        patience: Patience = SPECIFIED,
        fast: bool = True,
        round_trip_s: float | None = None,
        anyway: bool = False,
    ) -> None:
        super().__init__(line, heard, patience, round_trip_s)
        self._fast, self._anyway = fast, anyway
        self._mission: Mission | None = None
        self._holdings: dict[int, OnboardList] = {}
        self._logbook = Logbook((), self.autopilot)
        self._leaving = ModeWatch(self.state)
        self.order = FlightOrder(self.state, line.now)
        """Has a vehicle that is watched hold its place, go on, or end its flight."""
        self.conformance = Conformance(self.state, self.order)
        """Compares a vehicle that is watched with the forecast of its flight, and what is ordered if it deviates."""
        self.absence = LinkLoss(line)
        """Whether the link to a vehicle that is watched is lost, for how long, and what it does meanwhile."""
        self._numbers = itertools.count(2 * round(1e3 * line.now()), 2)  # not those of the last session

    def upload(self, mission: Mission, progress: Progress = silent, checked: bool = True) -> None:
        """Put a mission on the vehicle, with its fence and rally points if it has some, and verify each list.

        Args:
            mission: for this vehicle's autopilot.
            progress: told how far that is.
            checked: whether it is checked first as this vehicle's firmware would meet it.

        Raises:
            NotFlown: the vehicle is no multicopter.
            BadInput: the mission is for none, or for another autopilot.
            Unsafe: the check found errors, and nothing was sent.
            MissionRefused, NoAnswer, ReadBackDiffers, Replaced, Unflyable, TimeUp, Cancelled: it is not on the vehicle,
                or cannot be flown.
        """
        self.state.expect_flown()
        if mission.other_vehicle or mission.autopilot is not self.autopilot:
            own = "a multicopter" if mission.other_vehicle else self.autopilot
            words = f"the mission is for {mission.other_vehicle or mission.autopilot}, and the vehicle is {own}"
            raise BadInput(words, code="other-vehicle")
        with noted_interrupts() as interrupt, self._in_time():
            if checked:
                aboard, unsaid = check_aboard(mission, self.autopilot, self.firmware_version())
                refuse_errors((*unsaid, *check_mission(aboard)))
            try:
                self.upload_items(to_wire(mission), MissionType.MISSION, progress)
            except Unflyable as unflyable:
                if unflyable.why or self.home() is not None:
                    raise
                raise Unplaced from None
            try:
                if mission.fence:
                    self.upload_items(fence_to_wire(mission.fence), MissionType.FENCE)
                if mission.rally:
                    self.upload_items(rally_to_wire(mission.rally), MissionType.RALLY)
            except Cancelled as cancelled:
                words = f"{cancelled}; its mission is the new one"
                raise Cancelled(words, cancelled.hint, holds=cancelled.holds) from None
            if interrupt.take():
                raise Cancelled("cancelled too late: the vehicle holds everything that was sent", holds="new")
        self._expect(mission)

    def upload_items(self, items: Sequence[Item], kind: int, progress: Progress = silent) -> None:
        """Put one list, `items` of MAV_MISSION_TYPE `kind`, on the vehicle as it stands on the wire, and verify it."""
        with noted_interrupts(), self._in_time():
            self._await_ready()
            job = Upload(items, self.autopilot, kind, self._checksum_numbers())
            self._holdings.pop(kind, None)
            list_id = None
            if self._fast and job.has_checksum and kind == MissionType.MISSION:
                with suppress(FileRefused, NoAnswer, ReadBackDiffers):  # the ordinary transfer says what is wrong
                    list_id = self._tell(upload_by_file(job, progress))
            self._holdings[kind] = OnboardList(job, self._tell(upload(job, progress)) if list_id is None else list_id)

    def download(self, progress: Progress = silent) -> Mission:
        """The mission on the vehicle, with its fence and rally points.

        Raises:
            MissionRefused, NoAnswer, TimeUp: it did not come whole.
        """
        with self._in_time():
            lists = {kind: self.download_items(kind, progress if kind == 0 else silent) for kind in LISTS}
            items, fenced, rallied = (lists[kind] for kind in LISTS)
            fence, rally = fence_from_wire(fenced), rally_from_wire(rallied)
            mission = from_wire(items, self.autopilot, self.home())
        self._holdings = {k: OnboardList(Upload(lists[k], self.autopilot, k, self._checksum_numbers())) for k in LISTS}
        self._expect(mission)
        return replace(mission, fence=fence, rally=rally, firmware_version=self.firmware_version())

    def download_items(self, kind: int, progress: Progress = silent) -> tuple[Item, ...]:
        """The list of MAV_MISSION_TYPE `kind` as it stands on the wire."""
        with self._in_time():
            self._await_ready()
            return self._hold(consistent_download.download(kind, progress, self._checksum_numbers()))

    def clear(self, kind: int = MissionType.MISSION) -> None:
        """Have the vehicle forget a list. 255: all three, one by one, because ArduPilot knows no "all"."""
        with self._in_time():
            for one in LISTS if kind == MissionType.ALL else (kind,):
                self._holdings.pop(one, None)
                self._tell(conversations.clear(one))

    def set_current(self, index: int) -> None:
        """Make item `index` of `Mission.items` the one to go on with; `state` tells whether the vehicle does."""
        with self._in_time():
            self._tell(orders.set_current(index + self.autopilot.counts_home))
            self._hold(until(lambda: self.state.custom_mode is not None, SHOWN_S))

    def pause(self) -> None:
        """Have the flying vehicle stop and hold its place; `resume` or `return_to_launch` ends that.

        Raises:
            NotReady, NoAnswer, TimeUp: it flies on, or does not fly.
        """
        self._tell_flying(pause)

    def resume(self) -> None:
        """Have the flying vehicle go on with its mission; raises as `pause` does."""
        self._tell_flying(resume)

    def return_to_launch(self) -> None:
        """Have the flying vehicle come home and land; raises as `pause` does."""
        self._tell_flying(return_to_launch)

    def expect_on_ground(self) -> None:
        """Raise NotReady for a vehicle that is armed already."""
        expect_on_ground(self.state)

    def prepare(
        self, first: int = 0, progress: Progress = silent, permit: Callable[[Geodetic], object] | None = None
    ) -> None:
        """Bring a vehicle on the ground to where it can be armed and will begin with item `first` of `Mission.items`.

        Args:
            first: the index of the item to begin with.
            progress: told what is waited for.
            permit: told where the vehicle stands, and raises an error if no flight may begin there; left out, that is
                `check_start` without a scenario.

        Raises:
            NotReady: armed already, not ready in time, or elsewhere; with the vehicle's own reasons.
            NotFlown: it is no multicopter.
            Contested: another vehicle has come that uses its system id.
            CommandRefused, NoAnswer, LinkDown, TimeUp, Cancelled: it is not to be armed.
        """
        mission = self._mission
        climb = 0.0 if mission is None or first == 0 else begun_at(mission, first).items[first - 1].altitude
        items = () if mission is None else mission.items
        moving = next((n for n, item in enumerate(items) if n >= first and item.command < LAST_NAV), first)
        holdings, home = tuple(self._holdings.values()), self.autopilot.counts_home
        self._departure = Departure(self.state, first + home, moving + home, climb, holdings, progress)
        if not self._anyway:
            self.line.expect_alone(self.system)
        with self._in_time():
            self._tell(prepare(self._departure, self.ready_s))
        permit = permit or (None if mission is None else partial(check_start, Forecast(mission), first))
        if permit is not None and (at := self.state.position) is not None:
            permit(Geodetic(at.latitude_deg, at.longitude_deg, at.altitude))

    def start(self, progress: Progress = silent) -> None:
        """Arm a prepared vehicle and let it fly its mission; time zero of the flight is the vehicle's arming.

        Directly before the arming the vehicle is proved to hold the lists that were uploaded to it, or downloaded.
        One that is refused for a reason that passes is prepared again, proved and armed; `progress` is told of it.

        Raises:
            NotReady, TimeUp: it could not be armed for as long as it is waited for; with its own reasons.
            Replaced, ReplacedSince: it holds others.
            CommandRefused, NoAnswer, NotReady, LinkDown, Cancelled: with the vehicle's state as the hint; it was
                disarmed again if it said that it was still on the ground.
        """
        until_s, given = min(self._until, self.line.now() + self.ready_s), self._until
        departure = replace(self._departure, progress=progress)
        self._until = math.inf  # what is half started is ended first
        try:
            with self.state.told():
                self._tell(depart_when_ready(departure, lambda: until_s - self.line.now()))
        finally:
            self._until = given

    def watch(self, progress: Progress = silent) -> FlightRecord:
        """Wait until the flight is over, or the vehicle holds because it deviated from its forecast (`conformance`).

        `progress` is told of items done, and for how long the link is lost.

        A vehicle that leaves its mission in the air, and a mission that is replaced, are logged as warnings at once.
        So is a link that is lost: it is opened anew, and the flight watched on when the same vehicle is heard again,
        with the same mission; nothing is told to any other, and nothing that was ordered before is said again.

        Raises:
            NoAnswer, LinkDown: the vehicle is not heard any more; with its last known state as the hint.
            NotTheSameVehicle, NotFlown: another one is heard in its place, or one with another mission.
            TimeUp: the time given by `give_up_after` is up; the vehicle may be in the air.
        """
        holding, is_back, record = self._holdings.get(MissionType.MISSION), False, None
        compared = self.conformance.of(self._logbook)
        with self.state.told(), self._in_flight_time(), self._leaving.watched(self._logbook.modes):
            while record is None:
                lookouts = () if holding is None else (ListWatcher(holding),)
                asides: tuple[Aside, ...] = (self.order, compared, *lookouts)
                try:
                    if is_back:
                        self._subscribe_again()
                    dialogue = watch(self._logbook, progress, *asides, is_over=lambda: compared.is_over)
                    record = self._hold(dialogue, SILENT_S)
                except (Silence, LinkDown) as lost:
                    self._meet_again(lost, progress)
                    is_back = True
        with suppress(MissionError):  # the flight is over and known; a stream too many hurts nobody
            self._hold(unsubscribe())
        if holding is not None:
            with suppress(MissionError):  # it does not tell
                self._hold(read_again(holding, self.state))
        return self.record()

    @contextmanager
    def _in_flight_time(self) -> Iterator[None]:
        """Leave the vehicle to itself when the user's time is up."""
        try:
            yield
        except TimeUp:
            words = ("the time is up: nobody watches the vehicle any more, and it flies on", self.absence.meanwhile)
            raise TimeUp("; ".join(filter(None, words))) from None

    def _meet_again(self, lost: MissionError, progress: Progress) -> None:
        """Go on where the vehicle is, once it is known again."""
        logbook, holding = self._logbook, self._holdings.get(MissionType.MISSION)
        proved = None if holding is None or holding.changed else holding
        known = KnownVehicle(self.system, self.state, logbook.clock_s, self._about, proved)
        self.order.cut(True)
        tell = partial(count, progress, logbook.done, logbook.total, "item ")
        kept = self.absence.end(lost, known, self._patience, tell, self._until)
        self.order.cut(False)
        logbook.note_return()
        for message in sorted(kept, key=lambda one: isinstance(one, Heartbeat)):  # where it is, before whether it ended
            self._overhear(message)
        self._leaving.was_away = True
        if logbook.disarmed_s is not None:
            log.warning("it stands disarmed: it landed unheard, at the latest %.1f s after arming", logbook.disarmed_s)

    def _subscribe_again(self) -> None:
        """Ask for the streams anew where a vehicle, or what carries its link, has forgotten them."""
        self.state.heard -= set(NEEDED.values())
        if not self._hold(until(lambda: self.state.heard >= set(NEEDED.values()), AGAIN_S), SILENT_S):
            with suppress(NotReady, NoAnswer):
                self._tell(subscribe(self.state))

    def record(self) -> FlightRecord:
        """The flight so far; not complete if a deviation ended it, or the vehicle came to hold another mission."""
        record, why_not = self._logbook.record(), self.changed or self.conformance.why_not
        record = replace(record, deviations=tuple(self.conformance.deviations))
        return replace(record, completed=False, why_not=why_not) if why_not else record

    @property
    def ready_s(self) -> float:
        """How long it is waited for until it can be armed [s]: the user's limit for everything, if there is one."""
        total_s = self._patience.total_s
        return LIMITS.ready_s if total_s == SPECIFIED.total_s else total_s

    @property
    def changed(self) -> str:
        """What the vehicle has said of another mission since it was proved to hold ours, in words; else nothing."""
        holding = self._holdings.get(MissionType.MISSION)
        return "" if holding is None or not holding.changed else str(ReplacedSince(holding))

    @property
    def interrupted(self) -> str:
        """How the vehicle, watched in the air, has left its mission, in words; nothing where it flies it."""
        return self._leaving.words

    @property
    def mode(self) -> str:
        """The mode that it was last heard in, by the autopilot's name."""
        return "no mode" if self.state.custom_mode is None else self.autopilot.modes.name(self.state.custom_mode)

    def home(self) -> Geodetic | None:
        """Where the vehicle's home is; None while it does not know."""
        return self._hold(orders.home())

    def parameters(self, wanted: Iterable[str | Sequence[str]]) -> Mapping[str, float]:
        """The vehicle's values of these parameters; those that it does not have are left out.

        A parameter that goes by several names is asked for by all of them at once.
        """
        names = [(one,) if isinstance(one, str) else tuple(one) for one in wanted]
        return {name: one.param_value for name, one in self._hold(orders.parameters(names, self.autopilot)).items()}

    def set_parameter(self, name: str, value: float) -> None:
        """Give the parameter `name` another `value`, and see that the vehicle took it.

        Raises:
            NoAnswer: there is no such parameter.
            MissionError: it keeps another value.
        """
        self._tell(orders.set_parameter(name, value, self.autopilot))

    def _tell_flying(self, order: Callable[[VehicleState], Dialogue[None]]) -> None:
        with self._in_time(), self.state.told():
            self._tell(order(self.state))

    def _heed(self, message: Message) -> None:
        self._logbook.note(message)
        for holding in self._holdings.values():
            holding.note(message, self._logbook.armed)
        self._leaving.note(message, self.line.now())

    def _checksum_numbers(self) -> Iterator[int] | None:
        """Numbers for questions, where the vehicle keeps its lists as files, of which it makes a checksum."""
        has = self.autopilot.protocol_profile.takes_mission_file and self._told().capabilities & orders.FILE_TRANSFER
        return self._numbers if has else None

    def _expect(self, mission: Mission) -> None:
        self._mission, armed = mission, self._logbook.armed
        self._logbook = Logbook(mission.items, self.autopilot)
        self._logbook.armed = armed

    def _await_ready(self) -> None:
        if self.autopilot.protocol_profile.boots_slowly:
            await_booted(self.line, self.system, self.state, min(self.line.now() + STARTUP_S, self._until))
