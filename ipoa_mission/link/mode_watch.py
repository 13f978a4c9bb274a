import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from ipoa_mission.link.messages import WARNING, Message, Text
from ipoa_mission.link.vehicle_state import VehicleState

log = logging.getLogger(__name__)
#: A mode this long has replaced the mission's [s].
SETTLED_S = 1.0
#: Warnings this old may be the reason [s].
REASON_AGE_S = 3.0
RETURN_HINT = "a pilot or a ground station can take it over"
HOLD_HINT = (
    "a pilot or a ground station can take it over; or stop watching by Ctrl-C, then `resume` or `rtl` orders it on"
)


@dataclass
class ModeWatch:
    """`words`: how the vehicle has left its mission. `was_away`: its reason may have been missed."""

    state: VehicleState
    words: str = ""
    was_away: bool = False
    _modes: frozenset[int] = frozenset()
    _mode: int | None = None
    _since_s: float = 0.0
    _is_reported: bool = False
    _warnings: list[tuple[float, str]] = field(default_factory=list)

    @contextmanager
    def watched(self, modes: frozenset[int]) -> Iterator[None]:
        self.words, self._mode, self._modes = "", None, modes
        self._warnings.clear()
        try:
            yield
        finally:
            self._modes = frozenset()

    def note(self, message: Message, now_s: float) -> None:
        """`state` has noted the message already."""
        if isinstance(message, Text) and message.severity <= WARNING:
            self._warnings.append((now_s, message.text.strip()))
        mode = self.state.custom_mode
        if not self._modes or mode is None or not self.state.armed or not self.state.in_air:
            return
        if mode != self._mode:
            self._mode, self._since_s, self._is_reported = mode, now_s, False
        if mode in self._modes:
            if self.words:
                log.warning("the vehicle goes on with its mission")
            self.words, self.was_away = "", False
        elif now_s - self._since_s >= SETTLED_S and not self._is_reported:
            self._is_reported, self.words = True, self._left()
            modes = self.state.autopilot.modes
            log.warning("%s (%s)", self.words, RETURN_HINT if mode in modes.returns | modes.lands else HOLD_HINT)

    def _left(self) -> str:
        warnings = list(dict.fromkeys(text for when, text in self._warnings if when >= self._since_s - REASON_AGE_S))
        why = "its reason may not have been heard" if self.was_away else "does not say why"
        reason = f"; it says: {'; '.join(warnings)}" if warnings else f", and {why}"
        return f"the vehicle has left its mission: {self.state}{reason}"
