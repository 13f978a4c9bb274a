"""Handle Ctrl-C: exit code 130, and a message of changes on the vehicle and in files.

An `interruptible` verb has one `ChangesMade` and hands it down. On a link, `link/line.converse` raises `Cancelled` at
the first Ctrl-C, and the vehicle keeps a whole mission; a second ends at once.
"""

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Concatenate, ParamSpec

from ipoa_mission.errors import MissionError
from ipoa_mission.files import recorded_writes
from ipoa_mission.terminal import progress_bar

if TYPE_CHECKING:
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.progress import Progress

P = ParamSpec("P")


class ChangeKind(Enum):
    """The change that a state describes, in the order of `fly`; a later state replaces that of the same change."""

    VERB = auto()  # of a verb other than `fly`, or a file
    PARAMETERS = auto()  # parameters written on the vehicle
    MISSION = auto()  # the list on the vehicle
    START = auto()  # armed or started
    FLIGHT = auto()  # in the air
    FLOWN = auto()  # a flight that ended, by name


class Interrupted(MissionError):
    """The message reports the state left behind."""

    exit_code = 130


@dataclass
class ChangesMade:
    """The changes that a verb made, or perhaps made: states by change and name of a flown flight, and files."""

    states: dict[tuple[ChangeKind, str], str] = field(default_factory=dict)
    written: list[Path] = field(default_factory=list)

    @property
    def files(self) -> list[str]:
        return [str(path) for path in self.written if path.exists()]

    def note(self, change: ChangeKind, state: str, flight: str = "") -> None:
        self.states.pop((change, flight), None)
        if state:
            self.states[change, flight] = state

    def note_flown(self, flight: str, is_armed: bool) -> None:
        """Replace the state at the start, for Ctrl-C after the flight."""
        self.note(ChangeKind.MISSION, "")
        self.note(ChangeKind.START, "")
        state = "is armed, and no longer watched" if is_armed else "is disarmed"
        self.note(ChangeKind.FLOWN, f"{flight}: the vehicle {state}", flight)

    @contextmanager
    def reporting(
        self, if_interrupted: str, hint: str | None = None, after: str = "", change: ChangeKind = ChangeKind.VERB
    ) -> Iterator[None]:
        """On Ctrl-C raise `if_interrupted`, or a more exact message of the link; note the state `after` at the end."""
        before = self.states.get((change, ""), "")
        self.note(change, if_interrupted)
        try:
            yield
        except KeyboardInterrupt:
            raise self.report(hint, if_interrupted) from None
        except MissionError as error:
            if (ended := self.as_interrupted(error, hint, if_interrupted)) is not error:
                raise ended from None
            raise
        self.note(change, after or before)

    @contextmanager
    def planning(self) -> "Iterator[Progress]":
        with self.reporting("nothing was written"), progress_bar("planning") as show:
            yield show

    @contextmanager
    def stage(self, stage: "Stage", link: str = "") -> "Iterator[Progress]":
        """Show a bar; on an interruption report the state left behind."""
        from ipoa_mission.flight.procedure import Stage
        from ipoa_mission.progress import silent

        stored = "the new mission is on the vehicle"
        change, if_interrupted, after = {
            Stage.UPLOAD: (ChangeKind.MISSION, "the mission on the vehicle may be the old or the new one", stored),
            Stage.RECHECK: (ChangeKind.MISSION, stored, stored),
            Stage.READY: (ChangeKind.START, "the vehicle was not armed", ""),  # START replaces it
            Stage.START: (ChangeKind.START, "the start may have been completed", "the vehicle was started"),
            Stage.FLIGHT: (ChangeKind.FLIGHT, "the vehicle flies on, unwatched", ""),
        }.get(stage, (ChangeKind.MISSION, "the mission was not sent", ""))  # POSITION, PARAMETERS, CHECK
        hint = "look at the vehicle: it may be flying" if stage is Stage.START else None
        if stage is Stage.FLIGHT:
            hint = f"to command it: `ipoa-mission pause --link {link}`, or `rtl`"
        waits = stage in (Stage.POSITION, Stage.READY, Stage.START)
        is_long = stage not in (Stage.CHECK, Stage.RECHECK)
        title = "starting" if stage is Stage.START else stage
        with (
            self.reporting(if_interrupted, hint, after, change),
            progress_bar(title, is_waiting=waits) if is_long else nullcontext(silent) as show,
        ):

            def show_parameters(share: float, names: str) -> None:
                done = "parameters were" if share == 1.0 else "some parameters may be"
                self.note(ChangeKind.PARAMETERS, f"{done} written: {names}")
                show(share, names)

            yield show_parameters if stage is Stage.PARAMETERS else show

    def report(self, hint: str | None = None, if_interrupted: str = "", exact: str = "") -> Interrupted:
        states = [state for state in self.states.values() if state != if_interrupted]
        if exact and not states:
            return Interrupted(exact, hint)
        if last := exact or if_interrupted:
            states.append(last)
        if not states and (count := len(self.files)):
            return Interrupted(f"stopped; files written: {count}", hint)
        return Interrupted(f"stopped: {'; '.join(states) or 'nothing was done'}", hint)

    def as_interrupted(self, error: MissionError, hint: str | None = None, if_interrupted: str = "") -> MissionError:
        from ipoa_mission.link.dialogue import Cancelled

        if isinstance(error, Cancelled):
            exact = "" if error.list_on_vehicle is None else str(error)
            ended = self.report(error.hint or hint, if_interrupted, exact)
            ended.known = error.known
            error = ended
        if isinstance(error, Interrupted) and (files := self.files):
            error.known["written"] = files
        return error


def interruptible(verb: Callable[Concatenate[ChangesMade, P], None]) -> Callable[P, None]:
    """Hand `ChangesMade` to a verb; at Ctrl-C raise Interrupted with all changes until then."""

    @wraps(verb)
    def called(*arguments: P.args, **options: P.kwargs) -> None:
        changes = ChangesMade()
        with recorded_writes(changes.written):
            try:
                verb(changes, *arguments, **options)
            except MissionError as error:
                raise changes.as_interrupted(error) from None
            except (KeyboardInterrupt, SystemExit) as ended:
                if isinstance(ended, SystemExit) and ended.code != Interrupted.exit_code:  # Typer's at Ctrl-C
                    raise
                raise changes.as_interrupted(changes.report()) from None

    _, *parameters = inspect.signature(verb).parameters.values()
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called
