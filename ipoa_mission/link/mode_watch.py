"""Whether a vehicle in the air flies its mission: told at once when it is held, or sent elsewhere, and when it goes on.

Its own fence, a failsafe, its pilot or another station may take it out of its mission; whoever watches should know.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from ipoa_mission.link.messages import WARNING, Message, Text
from ipoa_mission.link.vehicle_state import VehicleState

log = logging.getLogger(__name__)
#: So long in another mode it has left its mission; meanwhile it says why [s].
SETTLED_S = 1.0
#: What it said so long before is why, too [s].
SAID_S = 3.0
BY_ITSELF = "a pilot or a ground station can take it over"
HELD = "a pilot or a ground station can take it over; or stop watching by Ctrl-C, then `resume` or `rtl` orders it on"


@dataclass
class ModeWatch:
    """Hears a vehicle, and says while it is watched that it leaves its mission or goes on with it.

    `words`: how it has left it; nothing if it has not. `was_away`: what it has said of that may not have been heard.
    """

    state: VehicleState
    words: str = ""
    was_away: bool = False
    _modes: frozenset[int] = frozenset()
    _mode: int | None = None
    _since_s: float = 0.0
    _is_told: bool = False
    _said: list[tuple[float, str]] = field(default_factory=list)

    @contextmanager
    def watched(self, modes: frozenset[int]) -> Iterator[None]:
        """In here the vehicle flies its mission in one of these modes, or has left it."""
        self.words, self._mode, self._modes = "", None, modes
        self._said.clear()
        try:
            yield
        finally:
            self._modes = frozenset()

    def note(self, message: Message, now_s: float) -> None:
        """Something was heard, and `state` knows it already."""
        if isinstance(message, Text) and message.severity <= WARNING:
            self._said.append((now_s, message.text.strip()))
        mode = self.state.custom_mode
        if not self._modes or mode is None or not self.state.armed or not self.state.in_air:
            return
        if mode != self._mode:
            self._mode, self._since_s, self._is_told = mode, now_s, False
        if mode in self._modes:
            if self.words:
                log.warning("the vehicle goes on with its mission")
            self.words, self.was_away = "", False
        elif now_s - self._since_s >= SETTLED_S and not self._is_told:
            self._is_told, self.words = True, self._left()
            modes = self.state.autopilot.modes
            log.warning("%s (%s)", self.words, BY_ITSELF if mode in modes.returns | modes.lands else HELD)

    def _left(self) -> str:
        said = list(dict.fromkeys(text for when, text in self._said if when >= self._since_s - SAID_S))
        why = "what it said of that was not heard" if self.was_away else "does not say why"
        reason = f"; it says: {'; '.join(said)}" if said else f", and {why}"
        return f"the vehicle has left its mission: {self.state}{reason}"
