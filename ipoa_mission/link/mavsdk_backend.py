"""Use a vehicle through MAVSDK, which transfers the lists; all else are our dialogues."""

import json
import math
import queue
import time
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ipoa_mission.autopilot.autopilot import default_autopilot, registered
from ipoa_mission.autopilot.vehicle_kind import QUADROTOR, VehicleKind
from ipoa_mission.errors import BadInput, MissionError, imported
from ipoa_mission.link import messages as m
from ipoa_mission.link import upload, wire
from ipoa_mission.link.channel import Address, LinkDown, Transport, parse_address
from ipoa_mission.link.codec import EVERYONE, Heard, Target
from ipoa_mission.link.conversations import MissionRefused, list_name
from ipoa_mission.link.dialogue import Cancelled, NoAnswer, until
from ipoa_mission.link.discovery import FoundVehicle
from ipoa_mission.link.line import Carrier, Interrupt, noted_interrupts
from ipoa_mission.link.onboard_list import OnboardList
from ipoa_mission.link.upload import ReadBackDiffers, Replaced, Unflyable, Upload
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotFlown
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import compare
from ipoa_mission.progress import Progress, count, silent

PRESENCE_S = 10.0
POLL_S = 0.05


def connect(
    url: str, system: int | None = None, log: str | Path | None = None, reading: bool = False
) -> "MavsdkVehicle":
    """`reading`: accept any vehicle and change nothing.

    Raises:
        BadInput: MAVSDK writes no `.tlog`, or `url` is not a connection string.
        LinkDown, NoAnswer: there is no such link, or no vehicle on it.
        NotFlown: it is not a multicopter of ArduPilot or PX4.
    """
    _expect_no_log(log)
    mavsdk = imported("mavsdk", "MAVSDK is not installed", "mavsdk", LinkDown)
    address = parse_address(url)
    instance = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION))
    result = instance.add_any_connection(_mavsdk_url(address))
    if result.name != "SUCCESS":
        instance.destroy()
        raise LinkDown(f"cannot be opened: {result.name}", code="link-not-opened", place=address)
    until = time.monotonic() + PRESENCE_S
    while time.monotonic() < until:
        for candidate in instance.get_systems():
            if candidate.has_autopilot() and candidate.is_connected() and system in (None, candidate.get_system_id()):
                try:
                    return MavsdkVehicle(instance, candidate, reading)
                except MissionError:
                    instance.destroy()
                    raise
        time.sleep(POLL_S)
    instance.destroy()
    message = "no autopilot is heard"
    raise NoAnswer(message, hint="check that it is running, and sends to this address", code="not-heard", place=url)


def borrow(system: Any, log: object = None) -> "MavsdkVehicle":
    """A program's own System stays open. Raise BadInput for a `.tlog`, or NoAnswer."""
    _expect_no_log(log)
    return MavsdkVehicle(None, system)


def _expect_no_log(log: object) -> None:
    if log is not None:
        words = "the mavsdk backend writes no .tlog; leave it out, or use the built-in backend"
        raise BadInput(words, code="backend-cannot", place="log")


def _mavsdk_url(address: Address) -> str:
    if address.transport is Transport.SERIAL:
        return f"serial://{address.device}:{address.baud}"
    scheme = "tcpout" if address.transport is Transport.TCP_OUT else str(address.transport)
    return f"{scheme}://{address.host}:{address.port}"


class MavsdkLine(Carrier):
    """By MAVSDK's plugin for messages in JSON; MAVSDK does not report senders."""

    def __init__(self, instance: Any, system: Any) -> None:
        direct = import_module("mavsdk.plugins.mavlink_direct")
        self._instance = instance
        self._system = int(system.get_system_id())
        self._message = direct.MavlinkMessage
        self._direct = direct.MavlinkDirect(system)
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._handle = self._direct.subscribe_message("", lambda message, _: self._queue.put(message))

    def now(self) -> float:
        return time.monotonic()

    def send(self, message: m.Message, target: Target = EVERYONE) -> None:
        name, fields = wire.write(message)
        addressed = {"target_system": target.system, "target_component": target.component, **fields}
        text = json.dumps({key: _to_json(value) for key, value in addressed.items()}, allow_nan=False)
        ids = (m.STATION_SYSTEM, m.STATION_COMPONENT, target.system, target.component)
        self._direct.send_message(self._message(name, *ids, text))

    def receive(self, until: float) -> list[Heard]:
        try:
            heard = [self._queue.get(timeout=max(until - self.now(), 0.0))] if until > self.now() else []
        except queue.Empty:
            return []
        while not self._queue.empty():
            heard.append(self._queue.get())
        return [self._read(raw) for raw in heard if raw.system_id == self._system]

    def close(self) -> None:
        self._direct.unsubscribe_message(self._handle)
        if self._instance is not None:
            self._instance.destroy()

    def _read(self, raw: Any) -> Heard:
        target = Target(raw.target_system_id, raw.target_component_id)
        message = None
        if wire.is_read(raw.message_name):
            fields = json.loads(raw.fields_json)
            numbers = {key: math.nan if value is None else value for key, value in fields.items()}
            message = wire.read(raw.message_name, SimpleNamespace(**numbers))
        return Heard(raw.system_id, raw.component_id, target, message, b"")


def _to_json(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return None if isinstance(value, float) and not math.isfinite(value) else value


class MavsdkVehicle(Vehicle):
    def __init__(self, instance: Any, system: Any, reading: bool = False) -> None:
        mission_raw = import_module("mavsdk.plugins.mission_raw")
        self._raw, self._transfer_error = mission_raw.MissionRaw(system), mission_raw.MissionRawError
        self._item = mission_raw.MissionItem
        self._refused = import_module("mavsdk").MavsdkError
        line = MavsdkLine(instance, system)
        reported = system.autopilot_type().name
        likely = next((each for each in registered() if each.firmware_name.upper() == reported), default_autopilot())
        kind = VehicleKind(likely.mav_autopilot, QUADROTOR)  # until its first heartbeat
        super().__init__(line, FoundVehicle(int(system.get_system_id()), kind, armed=False, is_ready=True))
        if not self._hold(until(lambda: m.Heartbeat in self.state.heard, PRESENCE_S)):
            raise NoAnswer("no heartbeat is heard", code="not-heard", place=f"vehicle {self.system}")
        if not reading and self.state.kind is not None and not self.state.kind.is_flown:
            raise NotFlown(self.state.kind, f"vehicle {self.system}")

    def upload_items(self, items: Sequence[Item], kind: int, progress: Progress = silent) -> None:
        name = list_name(kind)
        self.state.expect_flown()
        self._onboard_lists.pop(kind, None)
        with noted_interrupts() as interrupt:
            rows = [self._mavsdk_item(seq, item, kind) for seq, item in enumerate(items)]
            self._listen()
            self.state.warnings.clear()
            try:
                self._transfer(kind, lambda: self._upload(rows, kind, interrupt))
            except MissionRefused as refusal:
                if refusal.result != m.Result.OPERATION_CANCELLED or not interrupt.take():
                    raise
                raise Cancelled(f"cancelled: the vehicle keeps the {name} it had", list_on_vehicle="old") from None
            difference = compare(items, self.download_items(kind), self.autopilot)
            if difference is not None:
                raise ReadBackDiffers(kind, difference)
            count(progress, len(items), len(items))
            if interrupt.take():
                raise Cancelled(f"cancelled too late: the vehicle holds the whole new {name}", list_on_vehicle="new")
        if self.autopilot.protocol_profile.judges_later and kind == m.MissionType.MISSION and items:
            self._expect_flyable()
            again = compare(items, self.download_items(kind), self.autopilot)
            if again is not None:
                raise Replaced(kind, again)
        self._onboard_lists[kind] = OnboardList(Upload(items, self.autopilot, kind))

    def _expect_flyable(self) -> None:
        """PX4 reports it in MISSION_CURRENT after a while."""
        self._listen()
        state, none = self.state, m.NO_MISSION
        state.current = None
        if self._hold(
            until(lambda: state.current is not None and state.current.mission_state > none, upload.VERDICT_S)
        ):
            return
        if state.current is not None and state.current.mission_state == none:
            raise Unflyable("; ".join(state.warnings))

    def _upload(self, rows: Sequence[Any], kind: int, interrupt: Interrupt) -> None:
        """Ctrl-C ends it only where the vehicle keeps its old list (PX4's mission)."""
        raw = self._raw
        begin = (raw.upload_mission_async, raw.upload_geofence_async, raw.upload_rally_points_async)[kind]
        results: queue.SimpleQueue[Any] = queue.SimpleQueue()
        begin(list(rows), lambda result, _: results.put(result))
        was_cancelled = False
        while True:
            keeps_old = self.autopilot.protocol_profile.judges_later and kind == m.MissionType.MISSION
            if interrupt.is_pending and not was_cancelled and keeps_old:
                was_cancelled = True
                raw.cancel_mission_upload()
            try:
                result = results.get(timeout=POLL_S)
            except queue.Empty:
                continue
            if result.name != "SUCCESS":
                raise self._transfer_error(result, "upload")
            return

    def download_items(self, kind: int, progress: Progress = silent) -> tuple[Item, ...]:
        read = (self._raw.download_mission, self._raw.download_geofence, self._raw.download_rallypoints)[kind]
        items = tuple(map(wire.read_item, self._transfer(kind, read)))
        count(progress, len(items), len(items))
        return items

    def _checksum_numbers(self) -> Iterator[int] | None:
        """MAVSDK hides the messages of file transfers."""
        return None

    def _transfer(self, kind: int, act: Callable[[], Any]) -> Any:
        try:
            return act()
        except self._refused as refusal:
            name = refusal.result.name
            if name == "NO_MISSION_AVAILABLE":
                return []
            if name in ("TIMEOUT", "NO_SYSTEM"):
                raise NoAnswer("the vehicle does not answer") from refusal
            self._listen()
            words = "; ".join(self.state.warnings) or f"MAVSDK calls it {name}"
            results = {
                "TOO_MANY_MISSION_ITEMS": m.Result.NO_SPACE,
                "UNSUPPORTED": m.Result.UNSUPPORTED,
                "DENIED": m.Result.DENIED,
                "INVALID_ARGUMENT": m.Result.INVALID,
                "INVALID_SEQUENCE": m.Result.INVALID_SEQUENCE,
                "TRANSFER_CANCELLED": m.Result.OPERATION_CANCELLED,
            }
            raise MissionRefused(results.get(name, m.Result.ERROR), kind, words=words) from refusal

    def _listen(self) -> None:
        while heard := self.line.receive(self.line.now()):
            for message in (frame.message for frame in heard):
                if message is not None:
                    self._overhear(message)

    def _mavsdk_item(self, seq: int, item: Item, kind: int) -> Any:
        place = (wire.coordinate(degrees, item.frame) for degrees in (item.latitude_deg, item.longitude_deg))
        numbers = (seq, item.frame, item.command, int(seq == 0), int(item.autocontinue), *item.params)
        return self._item(*numbers, *place, item.altitude, int(kind))
