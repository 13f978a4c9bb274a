from collections.abc import Mapping
from dataclasses import dataclass


def mode_number(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


@dataclass(frozen=True)
class Modes:
    """Custom modes of one autopilot.

    `arming`: armed in it. `hold`: keeps its place without a pilot. `returning`: RTL. `returns`, `lands`: all such
    modes.
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
        return self.names.get(custom_mode, f"mode {custom_mode}")

    def does_next(self, custom_mode: int) -> str:
        if custom_mode == self.mission:
            return "it continues its mission"
        if custom_mode in self.returns:
            return "it returns home and lands"
        if custom_mode in self.lands:
            return "it lands where it is"
        return "it stays in this mode"

    def numbers(self, custom_mode: int) -> tuple[float, ...]:
        return (custom_mode >> 16 & 0xFF, custom_mode >> 24) if self.has_sub_modes else (custom_mode,)

    def ordered(self, main: float, sub: float) -> int:
        return mode_number(int(main) & 0xFF, int(sub) & 0xFF) if self.has_sub_modes else int(main)
