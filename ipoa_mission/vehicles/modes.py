"""Flight modes by an autopilot's own numbers and names, and what a vehicle in each does by itself."""

from collections.abc import Mapping
from dataclasses import dataclass


def mode_number(main: int, sub: int = 0) -> int:
    """HEARTBEAT.custom_mode of a main mode and a sub mode, where an autopilot has both."""
    return main << 16 | sub << 24


@dataclass(frozen=True)
class Modes:
    """The custom modes of one autopilot.

    `mission` flies the mission, `arming` is what a vehicle is armed for it in, `hold` keeps its place without a pilot,
    `returning` comes home; `returns` and `lands` are all modes that come home, or land where it is.
    """

    mission: int
    arming: int
    hold: int
    returning: int
    returns: frozenset[int]
    lands: frozenset[int]
    names: Mapping[int, str]
    has_sub_modes: bool = False

    def name(self, custom_mode: int) -> str:
        """The autopilot's name of HEARTBEAT.custom_mode, or its number."""
        return self.names.get(custom_mode, f"mode {custom_mode}")

    def does_next(self, custom_mode: int) -> str:
        """What a flying vehicle in this mode does if nobody tells it otherwise."""
        if custom_mode == self.mission:
            return "it flies on with its mission"
        if custom_mode in self.returns:
            return "it returns home and lands"
        if custom_mode in self.lands:
            return "it lands where it is"
        return "it stays in this mode"

    def numbers(self, custom_mode: int) -> tuple[float, ...]:
        """How DO_SET_MODE spells a mode: its number, or main and sub mode."""
        return (custom_mode >> 16 & 0xFF, custom_mode >> 24) if self.has_sub_modes else (custom_mode,)

    def ordered(self, main: float, sub: float) -> int:
        """The mode that the numbers of a DO_SET_MODE mean."""
        return mode_number(int(main) & 0xFF, int(sub) & 0xFF) if self.has_sub_modes else int(main)
