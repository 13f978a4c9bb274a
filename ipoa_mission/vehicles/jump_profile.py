"""How a firmware follows the jumps of a mission, read in its source."""

from dataclasses import dataclass


@dataclass(frozen=True)
class JumpProfile:
    """Counters and bounds of DO_JUMP and DO_JUMP_TAG."""

    most: int = 65_535
    """Jumps with a counter; further ones are not taken, unless they repeat without end."""
    most_small: int = 65_535
    """The same on a board of little memory."""
    at_once: int = 1_000
    """Jumps between two other items; one more ends the mission."""
    most_repeats: int = 65_535
    repeats_without_end: bool = False
    """-1 repeats without end."""
    resets: bool = False
    """The counter of a finished jump starts anew, so a second visit jumps again."""
    kept_by: tuple[str, int] = ("", 0)
    """The parameter, and its bit, with which a finished jump's counter stays."""
    looks_past_jumps: bool = False
    """Looking ahead for where to fly on to, it goes on behind a jump that leads to an item that does not move it."""
    queues_actions: bool = False
    """Before the next item that moves it, it does the first item that does not; the others are looked up after it.

    That look-up follows jumps by their counters of this moment: an item behind a finished jump is done a pass early.
    """
