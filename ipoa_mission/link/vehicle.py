import itertools
import logging
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial

from ipoa_mission.autopilot.commands import LAST_NAV
from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.firmware_check import check_aboard
from ipoa_mission.checks.unsafe import begun_at, check_start, refuse_errors
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.interrupts import noted_interrupts
from ipoa_mission.link import conversations, departure, orders
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.connection import MessageLink
from ipoa_mission.link.dialogue import (
    SPECIFIED,
    Cancelled,
    Dialogue,
    ListAboard,
    NoAnswer,
    RetryPolicy,
    Silence,
    TimeUp,
    until,
)
from ipoa_mission.link.discovery import FoundVehicle, VehicleSession
from ipoa_mission.link.flight_order import SHOWN_S, Conformance, FlightOrder, enter, go_on, hold, in_flight
from ipoa_mission.link.logbook import Logbook, Observer, watch
from ipoa_mission.link.messages import Heartbeat, Message, MissionType
from ipoa_mission.link.onboard_list import OnboardList, ReplacedSince, prove_after_flight, with_lists
from ipoa_mission.link.reconnect import RETRY_S, SILENT_S, KnownVehicle, LinkLoss
from ipoa_mission.link.upload import Upload, UploadState, upload
from ipoa_mission.link.vehicle_state import ModeWatch, NotReady
from ipoa_mission.mission import stored_mission
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.progress import Progress, count, silent

log = logging.getLogger(__name__)
STARTUP_S = 60.0
LISTS = (MissionType.MISSION, MissionType.FENCE, MissionType.RALLY)


@dataclass(frozen=True)
class ConnectionOptions:
    """As `connect` explains them."""

    retry_policy: RetryPolicy = SPECIFIED
    fast: bool = True
    anyway: bool = False
    reading: bool = False


class Vehicle(VehicleSession):
    """One vehicle on a connection, found by `connect`.

    Example:
        >>> from ipoa_mission import connect
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     vehicle.home().altitude
        488.0
    """

    def __init__(
        self,
        connection: MessageLink,
        heard: FoundVehicle,
        options: ConnectionOptions | None = None,
        trip_s: float | None = None,
    ) -> None:
        self._options = options or ConnectionOptions()
        super().__init__(connection, heard, self._options.retry_policy, trip_s)
        self.overhearing: Callable[[Message], None] = lambda message: None
        """Called with every message of the vehicle while a dialogue is held."""
        self._mission: Mission | None = None
        self._onboard_lists: dict[int, OnboardList] = {}
        self._departure: departure.Departure | None = None
        self._logbook = Logbook((), self.autopilot)
        self._mode_watch = ModeWatch(self.state)
        self.order = FlightOrder(self.state, connection.now)
        """Orders a watched vehicle to hold, resume, or end its flight."""
        self.conformance = Conformance(self.state, self.order)
        """Compares a watched vehicle with its forecast, and orders the reaction to a deviation."""
        self.link_loss = LinkLoss(connection)
        """State of the link to a watched vehicle: lost or not, for how long, and what the vehicle does meanwhile."""
        self._numbers = itertools.count(2 * round(1e3 * connection.now()), 2)  # differ from the last session's

    def upload(self, mission: Mission, progress: Progress = silent, checked: bool = True) -> None:
        """Upload a mission, after its fence and rally points, and verify each list.

        Args:
            mission: for this vehicle's autopilot.
            progress: called with the share done.
            checked: whether to check it first for this firmware.

        Raises:
            NotFlown: the vehicle is not a multicopter.
            BadInput: the mission is for another autopilot or vehicle.
            Unsafe: the check found errors; nothing was sent.
            MissionRefused, NoAnswer, ReadBackDiffers, Replaced, Unflyable, TimeUp, Cancelled: it is not on the vehicle,
                or cannot be flown; `known["lists_on_vehicle"]` has the state of each list.
        """
        self.state.expect_flown()
        if mission.other_vehicle or mission.autopilot is not self.autopilot:
            kind_aboard = "a multicopter" if mission.other_vehicle else self.autopilot
            words = f"the mission is for {mission.other_vehicle or mission.autopilot}, and the vehicle is {kind_aboard}"
            raise BadInput(words, code="other-vehicle")
        with noted_interrupts() as interrupt, self._in_time():
            if checked:
                aboard, unsaid = check_aboard(mission, self.autopilot, self.firmware_version())
                refuse_errors((*unsaid, *check_mission(aboard)))
            lists = {}
            if mission.fence:  # by which PX4 judges the mission
                lists[MissionType.FENCE] = stored_mission.fence_to_wire(mission.fence)
            if mission.rally:
                lists[MissionType.RALLY] = stored_mission.rally_to_wire(mission.rally)
            lists[MissionType.MISSION] = stored_mission.to_wire(mission)
            for kind, items in lists.items():
                try:
                    self.upload_items(items, kind, progress if kind == MissionType.MISSION else silent)
                except MissionError as error:
                    raise with_lists(error, kind, list(lists)) from None
            if interrupt.take():
                words = "cancelled too late: the vehicle holds everything that was sent"
                raise Cancelled(words, known={"list_on_vehicle": ListAboard.NEW})
        self._set_mission(mission)

    def upload_items(self, items: Sequence[Item], kind: int, progress: Progress = silent) -> None:
        """Upload and verify `items` of MAV_MISSION_TYPE `kind` in wire form; each Ctrl-C raises Cancelled."""
        with noted_interrupts(), self._in_time():
            self._await_ready()
            job = self._job(items, kind)
            self._onboard_lists.pop(kind, None)
            state = UploadState()
            try:
                list_id = self._run_order(upload(job, progress, state, by_file=self._options.fast))
            except KeyboardInterrupt:  # a second Ctrl-C ends a dialogue at once
                raise state.explained(Cancelled("cancelled"), job) from None
            self._onboard_lists[kind] = OnboardList(job, list_id)

    def download(self, progress: Progress = silent) -> Mission:
        """Return the mission, with fence and rally points.

        Raises:
            MissionRefused, NoAnswer, TimeUp: it is not complete.
        """
        with self._in_time():
            lists = {kind: self.download_items(kind, progress if kind == 0 else silent) for kind in LISTS}
            fence = stored_mission.fence_from_wire(lists[MissionType.FENCE])
            rally = stored_mission.rally_from_wire(lists[MissionType.RALLY])
            mission = stored_mission.from_wire(lists[MissionType.MISSION], self.autopilot, self.home())
        self._onboard_lists = {kind: OnboardList(self._job(lists[kind], kind)) for kind in LISTS}
        self._set_mission(mission)
        return replace(mission, fence=fence, rally=rally, firmware_version=self.firmware_version())

    def download_items(self, kind: int, progress: Progress = silent) -> tuple[Item, ...]:
        """Return the list of MAV_MISSION_TYPE `kind` in wire form."""
        with self._in_time():
            self._await_ready()
            return self._run(conversations.download(kind, progress, self._checksum_numbers()))

    def clear(self, kind: int = MissionType.MISSION) -> None:
        """Clear a list; 255: each one, because ArduPilot does not support "all"."""
        with self._in_time():
            for cleared in LISTS if kind == MissionType.ALL else (kind,):
                self._onboard_lists.pop(cleared, None)
                self._run_order(conversations.clear(cleared))

    def set_current(self, index: int) -> None:
        """Make item `index` of `Mission.items` the current one; see `state`."""
        with self._in_time():
            self._run_order(orders.set_current(index + self.autopilot.seq_offset, self.autopilot.seq_offset))
            self._run(until(lambda: self.state.custom_mode is not None, SHOWN_S))

    def pause(self) -> None:
        """Hold the flying vehicle's position; as `resume` and `return_to_launch`, verify the mode.

        Raises:
            NotReady, NoAnswer, TimeUp: it does not obey, or does not fly.
        """
        self._run_in_flight(hold(self.state))

    def resume(self) -> None:
        self._run_in_flight(go_on(self.state, self.state.is_paused))

    def return_to_launch(self) -> None:
        self._run_in_flight(enter(self.state, self.autopilot.modes.returning))

    def prepare(
        self, first: int = 0, progress: Progress = silent, permit: Callable[[Geodetic], object] | None = None
    ) -> None:
        """Prepare a vehicle on the ground for arming; after an error restore its mode, or add the present one.

        Args:
            first: index of the item of `Mission.items` to begin with.
            progress: called with the reason for the wait.
            permit: raises an error if no flight may begin at this position (default: `check_start`, no scenario).

        Raises:
            NotReady: armed already, not ready in time, or at another place; with the vehicle's reasons.
            NotFlown: it is not a multicopter.
            Contested: another vehicle uses its system id.
            CommandRefused, NoAnswer, LinkDown, TimeUp, Cancelled: it cannot be armed.
        """
        mission = self._mission
        climb = 0.0 if mission is None or first == 0 else begun_at(mission, first).items[first - 1].altitude
        items = () if mission is None else mission.items
        moving = next((n for n, item in enumerate(items) if n >= first and item.command < LAST_NAV), first)
        onboard_lists = tuple(self._onboard_lists.values())
        seqs = (first + self.autopilot.seq_offset, moving + self.autopilot.seq_offset)
        if not self._options.anyway:
            self.connection.expect_alone(self.system)
        permit = permit or (None if mission is None else partial(check_start, mission, None, first))
        prepared = departure.Departure(self.state, *seqs, climb, onboard_lists, progress, permit)
        with departure.restored_mode(self.state, self._run_unlimited):
            with self._in_time():
                self._run_order(departure.prepare(prepared, self.ready_s))
            prepared.expect_permitted()
        self._departure = prepared

    def count_down(self, progress: Progress, departs_s: float, until_s: float = 0.0) -> None:
        """Listen until `until_s` before a departure at `departs_s` on the connection's clock [s]; show `progress`."""
        with self._in_time():
            self._run(departure.count_down(progress, lambda: departs_s - self.connection.now(), until_s))

    def start(self, progress: Progress = silent, departs_s: float = math.inf) -> None:
        """Arm a prepared vehicle, at most 3 s after `departs_s`, and start its mission; time zero is the arming.

        Before, prove that it holds our lists. After a temporary refusal begin again; `progress` reports that.

        Raises:
            NotReady, TimeUp: it was not prepared, or could not be armed in time; with its reasons.
            Replaced, ReplacedSince: it holds other lists.
            CommandRefused, NoAnswer, NotReady, LinkDown, Cancelled: the hint is its state; on ground it is disarmed.
        """
        if self._departure is None:
            raise NotReady("the vehicle was not prepared", hint="call `prepare` first")
        latest_s = departs_s + departure.Departure.LATE_S
        until_s = min(self._until, self.connection.now() + self.ready_s, latest_s)
        prepared = replace(self._departure, progress=progress, left_s=lambda: latest_s - self.connection.now())
        with self.state.with_state_as_hint(), departure.restored_mode(self.state, self._run_unlimited):
            self._run_unlimited(departure.depart_when_ready(prepared, lambda: until_s - self.connection.now()))
        self.state.replaced_mode = None

    def watch(self, progress: Progress = silent) -> FlightRecord:
        """Wait until the flight is over, or a deviation (`conformance`) holds the vehicle.

        `progress` counts items done, and reports a link loss. Warn at once of a left or replaced mission. After a link
        loss, continue when the same vehicle is heard with the same mission; repeat no order.

        Raises:
            NoAnswer, LinkDown: the vehicle is not heard any more; the hint is its last state.
            NotTheSameVehicle, NotFlown: another vehicle is heard in its place, or it holds another mission.
            TimeUp: at the limit of `give_up_after`; the vehicle may be in the air.
        """
        onboard = self._onboard_lists.get(MissionType.MISSION)
        is_back = False
        record = None
        compared = self.conformance
        compared.logbook = self._logbook
        observers: list[Observer] = [self.order, compared, *([] if onboard is None else [onboard])]
        with self.state.with_state_as_hint(), self._in_flight_time(), self._mode_watch.watched(self._logbook.modes):
            while record is None:
                try:
                    if is_back:
                        self._subscribe_again()
                    dialogue = watch(
                        self._logbook, progress, *observers, is_over=lambda: compared.ends_held and compared.is_held
                    )
                    record = self._run(dialogue, SILENT_S)
                except (Silence, LinkDown) as lost:
                    self._reconnect(lost, progress)
                    is_back = True
        with suppress(MissionError):
            self._run(departure.unsubscribe())
        if onboard is not None:
            with suppress(MissionError):  # its list is not reported
                self._run(prove_after_flight(onboard, self.state))
        return self.record()

    @contextmanager
    def _in_flight_time(self) -> Iterator[None]:
        try:
            yield
        except TimeUp:
            words = ("the time is up: the vehicle flies on, and is not watched any more", self.link_loss.meanwhile)
            raise TimeUp("; ".join(filter(None, words))) from None

    def _reconnect(self, lost: MissionError, progress: Progress) -> None:
        logbook = self._logbook
        onboard = self._onboard_lists.get(MissionType.MISSION)
        proved = None if onboard is None or onboard.changed else onboard
        known = KnownVehicle(self.system, self.state, logbook.clock_s, self._about, proved, self._retry_policy)
        self.order.cut(True)
        report = partial(count, progress, logbook.done, logbook.total, "item ")
        messages = self.link_loss.end(lost, known, report, self._until)
        self.order.cut(False)
        logbook.note_return()
        for message in sorted(messages, key=lambda message: isinstance(message, Heartbeat)):
            self._overhear(message)
        self._mode_watch.was_away = True
        if logbook.disarmed_s is not None:
            log.warning(
                "it is disarmed: it landed while the link was lost, at the latest %.1f s after arming",
                logbook.disarmed_s,
            )

    def _subscribe_again(self) -> None:
        """The vehicle or a relay may have forgotten them."""
        self.state.heard -= set(departure.NEEDED_STREAMS.values())
        if not self._run(until(lambda: self.state.heard >= set(departure.NEEDED_STREAMS.values()), RETRY_S), SILENT_S):
            with suppress(NotReady, NoAnswer):
                self._run_order(departure.subscribe(self.state))

    def record(self) -> FlightRecord:
        """Return the flight; incomplete after a deviation, a replaced mission, or a lack of positions."""
        record = replace(self._logbook.record(), deviations=tuple(self.conformance.deviations))
        reasons = (self.changed or self.conformance.why_not or record.why_not, self.conformance.positions.words)
        why_not = "; ".join(filter(None, reasons))
        return replace(record, completed=not why_not, why_not=why_not)

    @property
    def ready_s(self) -> float:
        total_s = self._retry_policy.total_s
        return departure.Departure.READY_S if total_s == SPECIFIED.total_s else total_s

    @property
    def changed(self) -> str:
        """Return reports of another mission since the proof."""
        onboard = self._onboard_lists.get(MissionType.MISSION)
        return "" if onboard is None or not onboard.changed else str(ReplacedSince(onboard))

    @property
    def mode_change(self) -> str:
        """Return how the vehicle has left its mission in the air."""
        return self._mode_watch.words

    @property
    def mode(self) -> str:
        return "no mode" if self.state.custom_mode is None else self.autopilot.modes.name(self.state.custom_mode)

    def home(self) -> Geodetic | None:
        """Return home; None while unknown."""
        return self._run(orders.request_home())

    def parameters(self, wanted: Iterable[str | Sequence[str]]) -> Mapping[str, float]:
        """Return the vehicle's values, without unknown ones. Several names of a parameter are requested at once."""
        names = [(name,) if isinstance(name, str) else tuple(name) for name in wanted]
        values = self._run(orders.request_parameters(names, self.autopilot))
        return {name: value.param_value for name, value in values.items()}

    def set_parameter(self, name: str, value: float) -> None:
        """Set the parameter `name` to `value`, and verify it.

        Raises:
            NoAnswer: there is no such parameter.
            MissionError: the vehicle keeps another value.
        """
        self._run_order(orders.set_parameter(name, value, self.autopilot))

    def _run_in_flight(self, order: Dialogue[bool]) -> None:
        with self._in_time(), self.state.with_state_as_hint():
            self._run_order(in_flight(self.state, order))

    def _overhear(self, message: Message) -> None:
        super()._overhear(message)
        if not self.state.owns(message):
            return
        self._logbook.note(message)
        for onboard in self._onboard_lists.values():
            onboard.note(message, self._logbook.armed)
        self._mode_watch.note(message, self.connection.now())
        self.overhearing(message)

    def _job(self, items: Sequence[Item], kind: int) -> Upload:
        """An unknown firmware version may change items as any known one does."""
        numbers = self._checksum_numbers()
        version = self.version_heard
        is_known = version is not None and version.series in self.autopilot.tables.series
        return Upload(items, self.autopilot, kind, numbers, version if is_known else None)

    def _checksum_numbers(self) -> Iterator[int] | None:
        if not self.autopilot.protocol_profile.takes_mission_file:
            return None
        return self._numbers if self._read_version().capabilities & orders.FILE_TRANSFER else None

    def _set_mission(self, mission: Mission) -> None:
        self._mission = mission
        self._logbook = Logbook(mission.items, self.autopilot, self._logbook.armed)

    def _await_ready(self) -> None:
        """Wait until an ArduPilot has booted: before, it answers NO_SPACE."""
        if self.autopilot.protocol_profile.boots_slowly:
            wait_s = min(STARTUP_S, self._until - self.connection.now())
            if not self._run(until(lambda: self.state.booted, wait_s)):
                raise NoAnswer("the vehicle has not finished its start-up", code="not-started-up")
