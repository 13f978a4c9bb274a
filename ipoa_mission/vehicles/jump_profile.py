"""Properties of a firmware's DO_JUMP, read in its source."""

from dataclasses import dataclass


@dataclass(frozen=True)
class JumpProfile:
    """Counters and limits of DO_JUMP and DO_JUMP_TAG."""

    most: int = 65_535
    """Jumps with a counter; further ones are ignored, unless they repeat without end."""
    most_small: int = 65_535
    """The same on a board with little memory."""
    at_once: int = 1_000
    """Consecutive jumps between two other items; one more ends the mission."""
    most_repeats: int = 65_535
    repeats_without_end: bool = False
    """A repeat count of -1 has no end."""
    resets: bool = False
    """A finished jump resets its counter, so a second visit jumps again."""
    kept_by: tuple[str, int] = ("", 0)
    """The parameter and its bit that keep a finished jump's counter."""
    looks_past_jumps: bool = False
    """Look-ahead for the next navigation item continues after a jump to an item that is not one."""
    queues_actions: bool = False
    """It executes the first non-navigation item before the next navigation item, and looks up the others after it.

    That look-up uses the jump counters of this moment: an item after a finished jump is executed one pass early.
    """
