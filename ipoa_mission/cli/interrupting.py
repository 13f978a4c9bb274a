"""Ctrl-C: the command ends quietly, with exit code 130, and says what state it leaves things in."""

from collections.abc import Iterator
from contextlib import contextmanager

from ipoa_mission.errors import MissionError


class Interrupted(MissionError):
    """The user took it back; the message says what is left behind."""

    exit_code = 130


@contextmanager
def left_behind(words: str, hint: str | None = None) -> Iterator[None]:
    """Whoever presses Ctrl-C in here is told `words`, or what the link knows better."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(f"stopped: {words}", hint) from None
    except MissionError as error:
        from ipoa_mission.link.dialogue import Cancelled

        if not isinstance(error, Cancelled):
            raise
        interrupted = Interrupted(f"stopped: {words}" if error.holds is None else str(error), error.hint or hint)
        interrupted.known = error.known
        raise interrupted from None
