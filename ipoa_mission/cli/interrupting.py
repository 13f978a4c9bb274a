"""Handle Ctrl-C: end with exit code 130."""

from collections.abc import Iterator
from contextlib import contextmanager

from ipoa_mission.errors import MissionError


class Interrupted(MissionError):
    """The message reports the state left behind."""

    exit_code = 130


@contextmanager
def reporting_interrupt(words: str, hint: str | None = None) -> Iterator[None]:
    """On Ctrl-C raise `words`, or a more exact message of the link."""
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
