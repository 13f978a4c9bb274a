import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from ipoa_mission.autopilot.autopilot import Autopilot, VehicleKind, with_article
from ipoa_mission.errors import MissionError
from ipoa_mission.link import messages as m
from ipoa_mission.link.vehicle_words import VehicleTexts, words_in

log = logging.getLogger(__name__)
ON_GROUND = 1  # MAV_LANDED_STATE
PREARM_CHECK = 0x10000000  # MAV_SYS_STATUS_PREARM_CHECK, in the present mode
SETTLED_S = 1.0  # a mode this long has replaced the mission's
IN_AIR_HEIGHT = 0.5  # [m] above home, if nothing better is known


class NotReady(MissionError, code="not-ready"):
    """The vehicle's state does not permit an order; with the reason."""


class NotFlown(MissionError, code="not-flown"):
    """Not a supported multicopter: nothing is changed on it."""

    def __init__(self, kind: VehicleKind, name: str = "the vehicle") -> None:
        super().__init__(
            f"{name} is {with_article(str(kind))}; missions and orders are for multicopters of ArduPilot and PX4",
            hint="any vehicle can be read: its mission by `ipoa-mission download`",
        )


class OtherKind(NotFlown, code="other-kind"):
    def __init__(self, before: VehicleKind, kind: VehicleKind) -> None:
        MissionError.__init__(
            self,
            f"the vehicle is {with_article(str(kind))}, and was {with_article(str(before))}: nothing is sent to it",
            hint="do two vehicles use its system id? give each its own",
        )


@dataclass
class VehicleState:
    """All that a vehicle reported; None is unknown. `other_kind`: another kind of vehicle with these ids, ignored."""

    autopilot: Autopilot
    kind: VehicleKind | None = None
    booted: bool = False
    armed: bool | None = None
    custom_mode: int | None = None
    replaced_mode: int | None = None  # by `prepare`
    landed_state: int | None = None
    position: m.Position | None = None
    current: m.Current | None = None
    may_arm: bool | None = None
    battery_left: float | None = None  # share, first battery
    heard: set[type[m.Message]] = field(default_factory=set)
    warnings: VehicleTexts = field(default_factory=lambda: VehicleTexts(m.WARNING))
    other_kind: VehicleKind | None = None

    def note(self, message: m.Message) -> None:
        self.heard.add(type(message))
        self.warnings.note(message)
        match message:
            case m.SystemStatus(battery_remaining=left) | m.BatteryStatus(id=0, battery_remaining=left) if left >= 0:
                self.battery_left = left / 100.0
        match message:
            case m.Heartbeat() if not self.owns(message):
                self.other_kind = self.other_kind or message.vehicle
            case m.Heartbeat():
                self.kind = message.vehicle
                self.booted = message.system_status >= m.STANDBY
                if self.armed and not message.armed:
                    self.landed_state = None  # of the flight
                self.armed = message.armed
                self.custom_mode = message.custom_mode
            case m.ExtendedState(landed_state) if landed_state:
                self.landed_state = landed_state
            case m.Position():
                self.position = message
            case m.Current():
                self.current = message
            case m.SystemStatus(present, _, health):
                self.may_arm = bool(health & PREARM_CHECK) if present & PREARM_CHECK else None

    def expect_flown(self) -> None:
        """Raise NotFlown unless all heartbeats were of one supported vehicle."""
        if self.kind is not None and not self.kind.is_flown:
            raise NotFlown(self.kind)
        if self.kind is not None and self.other_kind is not None:
            raise OtherKind(self.kind, self.other_kind)

    def expect_on_ground(self) -> None:
        """Raise NotReady if armed, unknown, or reported off the ground."""
        is_on_ground = self.landed_state in (None, ON_GROUND)
        if self.armed is not False or not is_on_ground:
            where = "" if is_on_ground else ", and does not report to be on the ground"
            words = f"expected a vehicle disarmed and on the ground: {self}{where}"
            hint = "is its heartbeat heard?" if self.armed is None else "land and disarm it first"
            raise NotReady(words, hint=hint, code="not-on-ground")

    def expect_mode(self, order: str, *modes: int | None) -> None:
        if self.armed and self.custom_mode is not None and None not in modes and self.custom_mode not in modes:
            mode = self.autopilot.modes.name(self.custom_mode)
            raise NotReady(f"{order} was ordered, and the pilot or the autopilot took over, in {mode}")

    def owns(self, message: m.Message) -> bool:
        if not isinstance(message, m.Heartbeat):
            return True
        reported = message.vehicle
        if reported is None:
            return False
        return self.kind in (None, reported) or (reported.is_flown and reported.autopilot is self.autopilot)

    @contextmanager
    def with_state_as_hint(self) -> Iterator[None]:
        try:
            yield
        except MissionError as error:
            error.hint = f"when last heard, {self}"
            raise

    @property
    def in_air(self) -> bool | None:
        if self.armed is False:
            return False
        if self.landed_state is not None:
            return self.landed_state != ON_GROUND
        return None if self.position is None else self.position.height > IN_AIR_HEIGHT

    @property
    def is_paused(self) -> bool:
        """Return whether it reports a pause within its mission."""
        is_reported = self.current is not None and self.current.mission_state == m.MissionState.PAUSED
        can = self.autopilot.protocol_profile.pauses_in_mission
        return can and is_reported and self.custom_mode == self.autopilot.modes.mission

    def __str__(self) -> str:
        if self.armed is None:
            return "the vehicle has not reported its state"
        if self.custom_mode is None:
            return f"the vehicle is {'armed' if self.armed else 'disarmed'}"
        mode = self.autopilot.modes.name(self.custom_mode)
        if not self.armed:
            return f"the vehicle is disarmed, in {mode}"
        if not self.in_air:
            where = "on the ground" if self.in_air is False else "perhaps in the air"
            return f"the vehicle is armed, {where}, in {mode}"
        height = "" if self.position is None else f" {self.position.height:.0f} m above home"
        item = "" if self.current is None else f", at item {self.current.seq + 1 - self.autopilot.seq_offset}"
        after = "it is paused" if self.is_paused else self.autopilot.modes.does_next(self.custom_mode)
        return f"the vehicle is armed and in the air{height}, in {mode}{item}: {after}"


@dataclass
class ModeWatch:
    """`words`: how the vehicle has left its mission. `was_away`: its reason may have been missed."""

    state: VehicleState
    words: str = ""
    was_away: bool = False
    _modes: frozenset[int] = frozenset()
    _seen: tuple[int, bool] | None = None
    _since_s: float = 0.0
    _is_reported: bool = False
    _warnings: list[tuple[float, str]] = field(default_factory=list)

    @contextmanager
    def watched(self, modes: frozenset[int]) -> Iterator[None]:
        self.words = ""
        self._seen = None
        self._modes = modes
        self._warnings.clear()
        try:
            yield
        finally:
            self._modes = frozenset()

    def note(self, message: m.Message, now_s: float) -> None:
        words = words_in(message)
        if words:
            self._warnings.append((now_s, words))
        mode = self.state.custom_mode
        if not self._modes or mode is None or not self.state.armed or not self.state.in_air:
            return
        is_paused = self.state.is_paused
        if (mode, is_paused) != self._seen:
            self._seen = (mode, is_paused)
            self._since_s = now_s
            self._is_reported = False
        if mode in self._modes and not is_paused:
            if self.words:
                log.warning("the vehicle continues its mission")
            self.words = ""
            self.was_away = False
        elif now_s - self._since_s >= SETTLED_S and not self._is_reported:
            self._is_reported = True
            self.words = self._left()
            modes = self.state.autopilot.modes
            hint = "a pilot or a ground station can take it over"
            if mode not in modes.returns | {modes.landing}:
                hint += "; or stop watching by Ctrl-C, then `resume` or `rtl` orders it on"
            log.warning("%s (%s)", self.words, hint)

    def _left(self) -> str:
        if self.state.is_paused:
            return f"a pilot or a station paused the mission: {self.state}"
        since_s = self._since_s - 3.0  # warnings this old may be the reason
        warnings = list(dict.fromkeys(text for when, text in self._warnings if when >= since_s))
        why = "its reason may not have been heard" if self.was_away else "does not say why"
        reason = f"; it says: {'; '.join(warnings)}" if warnings else f", and {why}"
        return f"the vehicle has left its mission: {self.state}{reason}"
