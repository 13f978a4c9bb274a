from dataclasses import dataclass


@dataclass(frozen=True)
class JumpProfile:
    """DO_JUMP and DO_JUMP_TAG, read in the source."""

    most: int = 65_535
    """Jumps with a counter; others are ignored, unless endless."""
    most_small: int = 65_535
    """With little memory."""
    at_once: int = 1_000
    """Consecutive jumps; one more ends the mission."""
    most_repeats: int = 65_535
    repeats_without_end: bool = False
    """A count of -1."""
    resets: bool = False
    """A finished jump jumps again."""
    kept_by: tuple[str, int] = ("", 0)
    """A parameter's bit that keeps a finished jump's counter."""
    looks_past_jumps: bool = False
    """For the next navigation item, past a jump to another item."""
    queues_actions: bool = False
    """Only the first action is looked up before the next navigation item, the others after it.

    The counters of that moment count: an action after a finished jump comes one pass early.
    """
