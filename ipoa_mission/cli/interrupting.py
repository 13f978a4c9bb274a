"""Handle Ctrl-C: end with 130 and report what was done; a second press ends at once."""

from collections.abc import Iterator
from contextlib import contextmanager

import typer

from ipoa_mission.errors import MissionError
from ipoa_mission.files import written

#: The changes that the verb has made, or may have made.
done: dict[str, str] = {}


class Interrupted(MissionError):
    """The message reports the state left behind."""

    exit_code = 130


@contextmanager
def reporting_interrupt(words: str, hint: str | None = None, after: str = "") -> Iterator[None]:
    """On Ctrl-C raise `words`, or a more exact message of the link; note `after` at the end."""
    done[words] = words
    try:
        yield
    except KeyboardInterrupt:
        raise stopped(hint, words) from None
    except MissionError as error:
        if (ended := interrupted(error, hint, words)) is not error:
            raise ended from None
        raise
    done.pop(words, None)
    if after:
        done[after] = after


def interrupted(error: MissionError, hint: str | None = None, words: str = "") -> MissionError:
    from ipoa_mission.link.dialogue import Cancelled

    if isinstance(error, Cancelled):
        found = stopped(error.hint or hint, words)
        if error.holds is not None:
            done.pop(words, None)
            words = str(error)
            found = stopped(found.hint, words) if any(done.values()) else Interrupted(words, found.hint)
        found.known = error.known
        error = found
    if isinstance(error, Interrupted) and (written := files_written()):
        error.known["written"] = written
    return error


def stopped(hint: str | None = None, words: str = "") -> Interrupted:
    """Return the error of Ctrl-C; it reports `words` last."""
    left = [one for one in (*(one for one in done.values() if one != words), words) if one]
    if not left and not files_written():
        left = ["nothing was done"]
    return Interrupted(": ".join(["stopped", "; ".join(left)] if left else ["stopped"]), hint)


def confirm(question: str) -> bool:
    try:
        return typer.confirm(question, err=True)
    except typer.Abort:
        raise KeyboardInterrupt from None


def files_written() -> list[str]:
    return [str(path) for path in written if path.exists()]
