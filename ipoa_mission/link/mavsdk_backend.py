"""The same verbs through MAVSDK, for those who trust it more: `pip install 'ipoa-mission[mavsdk]'`.

MAVSDK reports success when it has the Ack; here as elsewhere an upload counts when it was read back and compared. It
has no clock of the vehicle's, so times of a flight are the computer's.
"""

import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import Any

from ipoa_mission.errors import BadInput
from ipoa_mission.link.address import Address, Transport, parse_address
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.conversations import MissionRefused, Progress, list_name, silent
from ipoa_mission.link.dialogue import Cancelled, NoAnswer
from ipoa_mission.link.interrupt import Interrupt, noted_interrupts
from ipoa_mission.link.logbook import FlightRecord, Sample, brings_down
from ipoa_mission.link.messages import MissionType, Result
from ipoa_mission.link.orders import CommandRefused
from ipoa_mission.link.upload import ReadBackDiffers, Unflyable
from ipoa_mission.link.wire import coordinate, degrees
from ipoa_mission.mission.fence_items import fence_from_wire, fence_to_wire, rally_from_wire, rally_to_wire
from ipoa_mission.mission.firmware import compare, from_wire, to_wire
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.vehicle import Autopilot
from ipoa_mission.world.frame import Geodetic

PRESENCE_S = 10.0
ARMING_S = 60.0
LOST_S = 15.0
POLL_S = 0.05
VERDICT_S = 0.6  # how long PX4 may take to find a mission unflyable
#: MAVSDK's names for what a vehicle answers, where MAVLink has one.
_RESULTS = {
    "TOO_MANY_MISSION_ITEMS": Result.NO_SPACE,
    "UNSUPPORTED": Result.UNSUPPORTED,
    "DENIED": Result.DENIED,
    "INVALID_ARGUMENT": Result.INVALID,
    "INVALID_SEQUENCE": Result.INVALID_SEQUENCE,
    "TRANSFER_CANCELLED": Result.OPERATION_CANCELLED,
}


def connect(url: str, system: int | None = None, log: str | Path | None = None) -> "MavsdkVehicle":
    """Find the vehicle on a link, through MAVSDK.

    Raises:
        BadInput: MAVSDK keeps no `.tlog`, or the link is no connection string.
        LinkDown, NoAnswer: there is no such link, or no vehicle on it.
    """
    if log is not None:
        raise BadInput("log: the mavsdk backend writes no .tlog; leave it out, or use the built-in backend")
    try:
        mavsdk = import_module("mavsdk")
    except ModuleNotFoundError:
        raise LinkDown("MAVSDK is not installed", hint="pip install 'ipoa-mission[mavsdk]'") from None
    address = parse_address(url)
    instance = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION))
    result = instance.add_any_connection(_spelled(address))
    if result.name != "SUCCESS":
        instance.destroy()
        raise LinkDown(f"{address}: cannot be opened: {result.name}")
    until = time.monotonic() + PRESENCE_S
    while time.monotonic() < until:
        for found in instance.get_systems():
            if found.has_autopilot() and found.is_connected() and system in (None, found.get_system_id()):
                return MavsdkVehicle(instance, found)
        time.sleep(POLL_S)
    instance.destroy()
    raise NoAnswer(f"{url}: no autopilot is heard", hint="is it running, and does it send to this address?")


def _spelled(address: Address) -> str:
    if address.transport is Transport.SERIAL:
        return f"serial://{address.device}:{address.baud}"
    scheme = "tcpout" if address.transport is Transport.TCP_OUT else str(address.transport)
    return f"{scheme}://{address.host}:{address.port}"


class MavsdkVehicle:
    """One vehicle, through MAVSDK; `close` it, or use it with `with`."""

    def __init__(self, instance: Any, system: Any) -> None:
        self._instance = instance
        plugins = "mavsdk.plugins"
        mission_raw = import_module(f"{plugins}.mission_raw")
        self._raw, self._broken_off = mission_raw.MissionRaw(system), mission_raw.MissionRawError
        self._action = import_module(f"{plugins}.action").Action(system)
        self._telemetry = import_module(f"{plugins}.telemetry").Telemetry(system)
        self._item = mission_raw.MissionItem
        self._refused = import_module("mavsdk").MavsdkError
        self.system = int(system.get_system_id())
        is_ardupilot = system.autopilot_type().name == "ARDUPILOT"
        self.autopilot = Autopilot.ARDUPILOT if is_ardupilot else Autopilot.PX4
        self._words: list[str] = []
        self._expected: tuple[Item, ...] = ()
        self._started = 0.0
        self._critical: list[str] = []
        self._telemetry.subscribe_status_text(lambda text, _: self._note(text))

    def upload(self, mission: Mission, progress: Progress = silent) -> None:
        """Put a mission with its fence and rally points on the vehicle, and verify each list by reading back.

        Raises:
            MissionRefused, NoAnswer, ReadBackDiffers, Unflyable, Cancelled.
        """
        items = to_wire(replace(mission, autopilot=self.autopilot))
        self.upload_items(items, MissionType.MISSION)
        progress(len(items), len(items))
        if mission.fence:
            self.upload_items(fence_to_wire(mission.fence), MissionType.FENCE)
        if mission.rally:
            self.upload_items(rally_to_wire(mission.rally), MissionType.RALLY)
        self._expected = mission.items

    def upload_items(self, items: Sequence[Item], kind: int) -> None:
        """Put one list on the vehicle as it stands on the wire, and verify it."""
        name = list_name(kind)
        with noted_interrupts() as interrupt:
            rows = [self._spell(seq, item, kind) for seq, item in enumerate(items)]
            self._critical.clear()
            try:
                self._transfer(kind, lambda: self._upload(rows, kind, interrupt))
            except MissionRefused as refusal:
                if refusal.result != Result.OPERATION_CANCELLED or not interrupt.take():
                    raise
                raise Cancelled(f"cancelled: the vehicle keeps the {name} it had") from None
            difference = compare(items, self.download_items(kind), self.autopilot)
            if difference is not None:
                raise ReadBackDiffers(kind, difference)
            if interrupt.take():
                raise Cancelled(f"cancelled too late: the vehicle holds the whole new {name}")
        if self.autopilot is Autopilot.PX4 and kind == MissionType.MISSION and items:
            time.sleep(VERDICT_S)
            if self._critical:
                why = "; ".join(self._critical)
                raise Unflyable(f"the vehicle stored the mission but finds it unflyable: {why}")

    def _upload(self, rows: Sequence[Any], kind: int, interrupt: Interrupt) -> None:
        """MAVSDK's upload; Ctrl-C ends it where the vehicle then keeps its old list: PX4, and only its mission."""
        raw = self._raw
        begin = (raw.upload_mission_async, raw.upload_geofence_async, raw.upload_rally_points_async)[kind]
        results: queue.SimpleQueue[Any] = queue.SimpleQueue()
        begin(list(rows), lambda result, _: results.put(result))
        was_cancelled = False
        while True:
            if interrupt.is_pending and not was_cancelled and self.autopilot is Autopilot.PX4 and kind == 0:
                was_cancelled = True
                raw.cancel_mission_upload()
            try:
                result = results.get(timeout=POLL_S)
            except queue.Empty:
                continue
            if result.name != "SUCCESS":
                raise self._broken_off(result, "upload")
            return

    def download(self) -> Mission:
        """The mission on the vehicle, with its fence and rally points."""
        items = self.download_items(MissionType.MISSION)
        fence = fence_from_wire(self.download_items(MissionType.FENCE))
        rally = rally_from_wire(self.download_items(MissionType.RALLY))
        mission = from_wire(items, self.autopilot, self.home())
        self._expected = mission.items
        return replace(mission, fence=fence, rally=rally)

    def download_items(self, kind: int) -> tuple[Item, ...]:
        """One list as it stands on the wire."""
        read = (self._raw.download_mission, self._raw.download_geofence, self._raw.download_rallypoints)[kind]
        return tuple(_read(item) for item in self._transfer(kind, read))

    def clear(self) -> None:
        """Have the vehicle forget its mission."""
        self._transfer(MissionType.MISSION, self._raw.clear_mission)

    def set_current(self, index: int) -> None:
        """Go on with item `index` of `Mission.items`."""
        self._transfer(MissionType.MISSION, lambda: self._raw.set_current_mission_item(index + self._first))

    def home(self) -> Geodetic | None:
        """Where the vehicle's home is; None while it does not know."""
        home = self._telemetry.home()
        altitude = float(home.absolute_altitude_m)
        return None if altitude != altitude else Geodetic(home.latitude_deg, home.longitude_deg, altitude)

    def arm(self) -> None:
        """Let the motors run; a vehicle that is still starting up is asked once a second."""
        self._order("arm", self._action.arm, ARMING_S)

    def start(self) -> None:
        """Fly the mission: time zero of the flight record."""
        self._order("start the mission", self._raw.start_mission, 0.0)
        self._started = time.monotonic()

    def watch(self, progress: Callable[[int], None] = lambda done: None) -> FlightRecord:
        """Wait until the mission is flown; `progress` is told how many items are done.

        Raises:
            NoAnswer: the vehicle is not heard any more.
        """
        reached: dict[int, float] = {}
        path: list[Sample] = []
        over = threading.Event()
        was_armed = threading.Event()
        heard = [time.monotonic()]
        lands = bool(self._expected) and brings_down(self._expected[-1].command)

        def note_progress(told: Any, _: Any) -> None:
            done = min(max(int(told.current) - self._first, 0), len(self._expected))
            for index in range(done):
                reached.setdefault(index, time.monotonic() - self._started)
            progress(done)
            if told.current == told.total and not lands:
                over.set()

        def note_armed(armed: bool, _: Any) -> None:
            if armed:
                was_armed.set()
            elif was_armed.is_set():
                over.set()

        def note_position(at: Any, _: Any) -> None:
            heard[0] = time.monotonic()
            place = (at.latitude_deg, at.longitude_deg, at.absolute_altitude_m, at.relative_altitude_m, 0.0)
            path.append(Sample(heard[0] - self._started, *place))

        handles = (
            (self._raw.unsubscribe_mission_progress, self._raw.subscribe_mission_progress(note_progress)),
            (self._telemetry.unsubscribe_armed, self._telemetry.subscribe_armed(note_armed)),
            (self._telemetry.unsubscribe_position, self._telemetry.subscribe_position(note_position)),
        )
        try:
            while not over.wait(POLL_S):
                if time.monotonic() - heard[0] > LOST_S:
                    raise NoAnswer("the vehicle is not heard any more")
        finally:
            for unsubscribe, handle in handles:
                unsubscribe(handle)
        total_s = time.monotonic() - self._started
        if lands:
            reached[len(self._expected) - 1] = total_s
        return FlightRecord(reached, total_s, tuple(path), tuple(self._words), True)

    def close(self) -> None:
        """Let MAVSDK end its threads."""
        self._instance.destroy()

    def __enter__(self) -> "MavsdkVehicle":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def _first(self) -> int:
        return 1 if self.autopilot is Autopilot.ARDUPILOT else 0

    def _note(self, text: Any) -> None:
        words = str(text.text).rstrip("\t ")
        self._words.append(words)
        if text.type.name in ("CRITICAL", "ALERT", "EMERGENCY"):
            self._critical.append(words)

    def _transfer(self, kind: int, act: Callable[[], Any]) -> Any:
        self._words.clear()
        try:
            return act()
        except self._refused as refusal:
            name = refusal.result.name
            if name == "NO_MISSION_AVAILABLE":
                return []
            if name in ("TIMEOUT", "NO_SYSTEM"):
                raise NoAnswer("the vehicle does not answer") from refusal
            words = "; ".join(self._words) or f"MAVSDK calls it {name}"
            raise MissionRefused(_RESULTS.get(name, Result.ERROR), kind, words=words) from refusal

    def _order(self, what: str, act: Callable[[], Any], patience_s: float) -> None:
        until = time.monotonic() + patience_s
        while True:
            try:
                act()
            except self._refused as refusal:
                if time.monotonic() >= until:
                    words = "; ".join(self._words) or f"MAVSDK calls it {refusal.result.name}"
                    raise CommandRefused(what, 4, words) from refusal
                time.sleep(1.0)
            else:
                return

    def _spell(self, seq: int, item: Item, kind: int) -> Any:
        x, y = coordinate(item.latitude_deg, item.frame), coordinate(item.longitude_deg, item.frame)
        current = int(seq == 0)
        return self._item(
            seq, item.frame, item.command, current, int(item.autocontinue), *item.params, x, y, item.altitude, int(kind)
        )


def _read(raw: Any) -> Item:
    return Item(
        raw.command,
        raw.frame,
        (raw.param1, raw.param2, raw.param3, raw.param4),
        degrees(raw.x, raw.frame),
        degrees(raw.y, raw.frame),
        raw.z,
        bool(raw.autocontinue),
    )
