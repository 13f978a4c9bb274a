"""Handle Ctrl-C: exit code 130, and a message of changes on the vehicle and in files.

The first Ctrl-C ends a dialogue by `Cancelled`; the vehicle keeps a whole mission. A second ends at once. Each stage
of `fly` adds the state that it leaves (`showing_stage`). A vehicle in flight flies on, unwatched.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import TYPE_CHECKING

from ipoa_mission.cli.output import progress_bar
from ipoa_mission.errors import MissionError
from ipoa_mission.files import written

if TYPE_CHECKING:
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.progress import Progress

#: The changes that the verb has made, or may have made; `run_interruptible` empties it.
done: dict[str, str] = {}


class Interrupted(MissionError):
    """The message reports the state left behind."""

    exit_code = 130


def run_interruptible(command: Callable[[], object]) -> None:
    """Run a command line; at Ctrl-C raise Interrupted with all changes until then."""
    done.clear()
    written.clear()
    try:
        command()
    except SystemExit as ended:
        if ended.code == Interrupted.exit_code:  # Typer ends this way
            raise as_interrupted(interruption_report()) from None
        raise
    except KeyboardInterrupt:
        raise as_interrupted(interruption_report()) from None
    except MissionError as error:
        raise as_interrupted(error) from None


@contextmanager
def reporting_interrupt(words: str, hint: str | None = None, after: str = "") -> Iterator[None]:
    """On Ctrl-C raise `words`, or a more exact message of the link; note `after` at the end."""
    done[words] = words
    try:
        yield
    except KeyboardInterrupt:
        raise interruption_report(hint, words) from None
    except MissionError as error:
        if (ended := as_interrupted(error, hint, words)) is not error:
            raise ended from None
        raise
    done.pop(words, None)
    if after:
        done[after] = after


@contextmanager
def showing_stage(stage: "Stage") -> "Iterator[Progress]":
    """Show a bar; on an interruption report the state left behind."""
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.progress import silent

    left, after = {
        Stage.POSITION: ("the mission was not sent", ""),
        Stage.PARAMETERS: ("the mission was not sent", ""),
        Stage.CHECK: ("the mission was not sent", ""),
        Stage.UPLOAD: ("the mission on the vehicle may be the old or the new one", str(Stage.STORED)),
        Stage.STORED: (str(Stage.STORED), str(Stage.STORED)),
        Stage.READY: ("the vehicle was not armed", ""),
        Stage.START: ("the start may have been completed", "the vehicle was started"),
        Stage.FLIGHT: ("the vehicle flies on, unwatched", ""),
    }[stage]
    hint = "look at the vehicle: it may be flying" if stage is Stage.START else None
    if stage is Stage.FLIGHT:
        hint = "`ipoa-mission pause` and `rtl` with the same --link command it"
    waits = stage in (Stage.POSITION, Stage.READY, Stage.START)
    is_long = stage not in (Stage.CHECK, Stage.STORED)
    words = "starting" if stage is Stage.START else stage
    with (
        reporting_interrupt(left, hint, after),
        progress_bar(words, is_waiting=waits) if is_long else nullcontext(silent) as show,
    ):
        yield partial(_show_parameters, show) if stage is Stage.PARAMETERS else show


def _show_parameters(show: "Progress", share: float, names: str) -> None:
    done["parameters"] = f"{'parameters were' if share == 1.0 else 'some parameters may be'} written: {names}"
    show(share, names)


def note_flown(name: str, is_armed: bool) -> None:
    """Replace the state at the start, for Ctrl-C after the flight."""
    from ipoa_mission.flight.procedure import Stage

    for before in (str(Stage.STORED), "the vehicle was started"):
        done.pop(before, None)
    done[name] = f"{name}: the vehicle {'is armed, and no longer watched' if is_armed else 'is disarmed'}"


def as_interrupted(error: MissionError, hint: str | None = None, words: str = "") -> MissionError:
    from ipoa_mission.link.dialogue import Cancelled

    if isinstance(error, Cancelled):
        ended = interruption_report(error.hint or hint, words)
        if error.holds is not None:
            done.pop(words, None)
            words = str(error)
            ended = interruption_report(ended.hint, words) if any(done.values()) else Interrupted(words, ended.hint)
        ended.known = error.known
        error = ended
    if isinstance(error, Interrupted) and (files := _files_written()):
        error.known["written"] = files
    return error


def interruption_report(hint: str | None = None, words: str = "") -> Interrupted:
    """Return the error of Ctrl-C; it reports `words` last."""
    left = [*filter(None, (change for change in done.values() if change != words)), *filter(None, [words])]
    if not left and not _files_written():
        left = ["nothing was done"]
    return Interrupted(": ".join(["stopped", *filter(None, ["; ".join(left)])]), hint)


def _files_written() -> list[str]:
    return [str(path) for path in written if path.exists()]
