"""Use a vehicle through MAVSDK: it carries the messages of our dialogues."""

import json
import math
import queue
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ipoa_mission.autopilot.autopilot import QUADROTOR, VehicleKind, default_autopilot, registered
from ipoa_mission.errors import BadInput, MissionError, imported
from ipoa_mission.link import messages as m
from ipoa_mission.link import wire
from ipoa_mission.link.channel import Address, LinkDown, Transport, parse_address
from ipoa_mission.link.codec import EVERYONE, Heard, LongTexts, Target
from ipoa_mission.link.connection import MessageLink
from ipoa_mission.link.dialogue import NoAnswer, until
from ipoa_mission.link.discovery import FoundVehicle
from ipoa_mission.link.vehicle import ConnectionOptions, Vehicle
from ipoa_mission.link.vehicle_state import NotFlown

PRESENCE_S = 10.0
POLL_S = 0.05


def connect(
    url: str, system: int | None = None, log: str | Path | None = None, options: ConnectionOptions | None = None
) -> "MavsdkVehicle":
    """Connect, and raise, as `link.connect.connect` does; BadInput for a `.tlog`."""
    _expect_no_log(log)
    options = options or ConnectionOptions()
    mavsdk = imported("mavsdk", "MAVSDK is not installed", "mavsdk", LinkDown)
    address = parse_address(url)
    instance = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION))
    try:
        result = instance.add_any_connection(_mavsdk_url(address))
        if result.name != "SUCCESS":
            raise LinkDown(f"cannot be opened: {result.name}", code="link-not-opened", place=address)
        until = time.monotonic() + min(PRESENCE_S, options.retry_policy.total_s)
        while time.monotonic() < until:
            for found in instance.get_systems():
                if found.has_autopilot() and found.is_connected() and system in (None, found.get_system_id()):
                    return MavsdkVehicle(instance, found, options)
            time.sleep(POLL_S)
        hint = "check that it is running, and sends to this address"
        raise NoAnswer("no autopilot is heard", hint=hint, code="not-heard", place=url)
    except MissionError:
        instance.destroy()
        raise


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


class MavsdkConnection(MessageLink):
    """MAVSDK's plugin for messages in JSON, which sends with MAVSDK's ids and passes on messages to them."""

    def __init__(self, instance: Any, system: Any) -> None:
        direct = import_module("mavsdk.plugins.mavlink_direct")
        self._instance = instance
        self._system = int(system.get_system_id())
        self._message = direct.MavlinkMessage
        self._direct = direct.MavlinkDirect(system)
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._texts = LongTexts()
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
            heard = []
        while not self._queue.empty():
            heard.append(self._queue.get())
        read = (self._read(raw) for raw in heard if raw.system_id == self._system)
        return list(self._texts.joined(read, self.now()))

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
    def __init__(self, instance: Any, system: Any, options: ConnectionOptions | None = None) -> None:
        connection = MavsdkConnection(instance, system)
        reported = system.autopilot_type().name
        likely = next((each for each in registered() if each.firmware_name.upper() == reported), default_autopilot())
        kind = VehicleKind(likely.mav_autopilot, QUADROTOR)  # until its first heartbeat
        found = FoundVehicle(int(system.get_system_id()), kind, armed=False, is_ready=True)
        super().__init__(connection, found, options)
        presence_s = min(PRESENCE_S, self._retry_policy.total_s)
        if not self._run(until(lambda: m.Heartbeat in self.state.heard, presence_s)):
            raise NoAnswer("no heartbeat is heard", code="not-heard", place=f"vehicle {self.system}")
        if not self._options.reading and self.state.kind is not None and not self.state.kind.is_flown:
            raise NotFlown(self.state.kind, f"vehicle {self.system}")

    def _checksum_numbers(self) -> Iterator[int] | None:
        return None
