"""Handle Ctrl-C: exit code 130, and a message of changes on the vehicle and in files.

The first Ctrl-C ends a dialogue by `Cancelled`; the vehicle keeps a whole mission. A second ends at once. Each stage
of `fly` adds the state that it leaves (`showing_stage`).
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING

from ipoa_mission.cli.output import progress_bar
from ipoa_mission.errors import MissionError
from ipoa_mission.files import written

if TYPE_CHECKING:
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.progress import Progress

Change = Enum("Change", "VERB PARAMETERS MISSION START FLIGHT")


class Interrupted(MissionError):
    """The message reports the state left behind."""

    exit_code = 130


@dataclass
class ChangesMade:
    """The changes made, or perhaps made; flights by name."""

    states: dict[Change | str, str] = field(default_factory=dict)

    def note(self, change: Change | str, state: str) -> None:
        self.states.pop(change, None)
        if state:
            self.states[change] = state

    def report(self, hint: str | None = None, words: str = "", exact: str = "") -> Interrupted:
        """Report `words` last, or their more exact form."""
        states = [state for state in self.states.values() if state != words]
        if exact and not states:
            return Interrupted(exact, hint)
        if last := exact or words:
            states.append(last)
        if not states and (files := len(_files_written())):
            return Interrupted(f"stopped; files written: {files}", hint)
        return Interrupted(f"stopped: {'; '.join(states) or 'nothing was done'}", hint)


CHANGES: ContextVar[ChangesMade] = ContextVar("changes", default=ChangesMade())  # noqa: B039


def run_interruptible(command: Callable[[], object]) -> None:
    """Run a command line; at Ctrl-C raise Interrupted with all changes until then."""
    CHANGES.set(changes := ChangesMade())
    written.clear()
    try:
        command()
    except SystemExit as ended:
        if ended.code == Interrupted.exit_code:  # Typer ends this way
            raise as_interrupted(changes.report()) from None
        raise
    except KeyboardInterrupt:
        raise as_interrupted(changes.report()) from None
    except MissionError as error:
        raise as_interrupted(error) from None


@contextmanager
def reporting_interrupt(
    words: str, hint: str | None = None, after: str = "", change: Change = Change.VERB
) -> Iterator[None]:
    """On Ctrl-C raise `words`, or a more exact message of the link; note `after` at the end."""
    changes = CHANGES.get()
    before = changes.states.get(change, "")
    changes.note(change, words)
    try:
        yield
    except KeyboardInterrupt:
        raise changes.report(hint, words) from None
    except MissionError as error:
        if (ended := as_interrupted(error, hint, words)) is not error:
            raise ended from None
        raise
    changes.note(change, after or before)


@contextmanager
def showing_planning() -> "Iterator[Progress]":
    with reporting_interrupt("nothing was written"), progress_bar("planning") as show:
        yield show


@contextmanager
def showing_stage(stage: "Stage", link: str = "") -> "Iterator[Progress]":
    """Show a bar; on an interruption report the state left behind."""
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.progress import silent

    change, left, after = {
        Stage.UPLOAD: (Change.MISSION, "the mission on the vehicle may be the old or the new one", str(Stage.STORED)),
        Stage.STORED: (Change.MISSION, str(Stage.STORED), str(Stage.STORED)),
        Stage.READY: (Change.START, "the vehicle was not armed", ""),  # START replaces it
        Stage.START: (Change.START, "the start may have been completed", "the vehicle was started"),
        Stage.FLIGHT: (Change.FLIGHT, "the vehicle flies on, unwatched", ""),
    }.get(stage, (Change.MISSION, "the mission was not sent", ""))
    hint = "look at the vehicle: it may be flying" if stage is Stage.START else None
    if stage is Stage.FLIGHT:
        hint = f"to command it: `ipoa-mission pause --link {link}`, or `rtl`"
    waits = stage in (Stage.POSITION, Stage.READY, Stage.START)
    is_long = stage not in (Stage.CHECK, Stage.STORED)
    words = "starting" if stage is Stage.START else stage
    with (
        reporting_interrupt(left, hint, after, change),
        progress_bar(words, is_waiting=waits) if is_long else nullcontext(silent) as show,
    ):
        yield partial(_show_parameters, show) if stage is Stage.PARAMETERS else show


def _show_parameters(show: "Progress", share: float, names: str) -> None:
    words = f"{'parameters were' if share == 1.0 else 'some parameters may be'} written: {names}"
    CHANGES.get().note(Change.PARAMETERS, words)
    show(share, names)


def note_flown(name: str, is_armed: bool) -> None:
    """Replace the state at the start, for Ctrl-C after the flight."""
    changes = CHANGES.get()
    changes.note(Change.MISSION, "")
    changes.note(Change.START, "")
    changes.note(name, f"{name}: the vehicle {'is armed, and no longer watched' if is_armed else 'is disarmed'}")


def as_interrupted(error: MissionError, hint: str | None = None, words: str = "") -> MissionError:
    from ipoa_mission.link.dialogue import Cancelled

    if isinstance(error, Cancelled):
        exact = "" if error.list_on_vehicle is None else str(error)
        ended = CHANGES.get().report(error.hint or hint, words, exact)
        ended.known = error.known
        error = ended
    if isinstance(error, Interrupted) and (files := _files_written()):
        error.known["written"] = files
    return error


def _files_written() -> list[str]:
    return [str(path) for path in written if path.exists()]
