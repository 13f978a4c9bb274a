"""Handle Ctrl-C, SIGTERM and SIGHUP: exit code 130, and a message of changes on the vehicle and in files.

An `interruptible` verb has one `ChangesMade` and hands it down. On a link, `link/connection.run_dialogue` raises
`Cancelled` at the first Ctrl-C, and the vehicle keeps a whole mission; a second ends at once.
"""

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Concatenate, NamedTuple, ParamSpec

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


class Interrupted(MissionError, code="interrupted"):
    """The message reports the state left behind."""

    exit_code = 130


class StageState(NamedTuple):
    """Arguments of `reporting` for a stage."""

    if_interrupted: str
    hint: str | None = None
    after: str = ""
    change: ChangeKind = ChangeKind.MISSION


def _state_in(stage: "Stage", link: str) -> StageState:
    from ipoa_mission.flight.procedure import Stage

    either = "the mission on the vehicle may be the old one, the new one or a mixture: upload again, or clear it"
    stored = "the new mission is on the vehicle"
    look = "look at the vehicle: it may be flying"
    command = f"to command it: `ipoa-mission pause --link {link}`, or `rtl`"
    states = {
        Stage.UPLOAD: StageState(either, after=stored),
        Stage.RECHECK: StageState(stored, after=stored),
        Stage.READY: StageState("the vehicle was not armed", change=ChangeKind.START),  # START replaces it
        Stage.START: StageState("the start may have been completed", look, "the vehicle was started", ChangeKind.START),
        Stage.FLIGHT: StageState("the vehicle flies on, unwatched", command, change=ChangeKind.FLIGHT),
    }
    return states.get(stage, StageState("the mission was not sent"))


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
        """On Ctrl-C raise `if_interrupted` after the other states; at the end note the state `after`."""
        before = self.states.get((change, ""), "")
        self.note(change, if_interrupted)
        try:
            yield
        except (KeyboardInterrupt, MissionError) as error:
            if _is_ctrl_c(error):
                raise self.interrupted_by(error, hint, if_interrupted) from None
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

        title = "starting" if stage is Stage.START else stage
        waits = stage in (Stage.POSITION, Stage.READY, Stage.START)
        is_short = stage in (Stage.CHECK, Stage.RECHECK)
        bar = nullcontext(silent) if is_short else progress_bar(title, is_waiting=waits)
        state = _state_in(stage, link)
        left = self.reporting(state.if_interrupted, hint=state.hint, after=state.after, change=state.change)
        with left, bar as show:
            yield partial(self._show_parameters, show) if stage is Stage.PARAMETERS else show

    def _show_parameters(self, show: "Progress", share: float, names: str) -> None:
        done = "parameters were" if share == 1.0 else "some parameters may be"
        self.note(ChangeKind.PARAMETERS, f"{done} written: {names}")
        show(share, names)

    def interrupted_by(self, error: BaseException, hint: str | None = None, if_interrupted: str = "") -> Interrupted:
        """Return all changes; the link's words about its list replace `if_interrupted`."""
        known = error.known if isinstance(error, MissionError) else {}
        states = [state for state in self.states.values() if state != if_interrupted]
        last = str(error) if "list_on_vehicle" in known else if_interrupted
        states += [str(state) for state in (last, known.get("mode_left")) if state]
        if states == [str(error)]:
            words = str(error)
        elif not states and self.files:
            words = f"stopped; files written: {len(self.files)}"
        else:
            words = f"stopped: {'; '.join(states) or 'nothing was done'}"
        return Interrupted(words, getattr(error, "hint", None) or hint, known=known)


def _is_ctrl_c(error: BaseException) -> bool:
    """`Cancelled` is the link's, SystemExit Typer's."""
    if isinstance(error, SystemExit):
        return error.code == Interrupted.exit_code
    return isinstance(error, KeyboardInterrupt) or (isinstance(error, MissionError) and error.code == "cancelled")


def interruptible(verb: Callable[Concatenate[ChangesMade, P], None]) -> Callable[P, None]:
    """Hand `ChangesMade` to a verb; at Ctrl-C raise Interrupted with all changes until then."""

    @wraps(verb)
    def called(*arguments: P.args, **options: P.kwargs) -> None:
        changes = ChangesMade()
        with recorded_writes(changes.written):
            try:
                verb(changes, *arguments, **options)
            except (MissionError, KeyboardInterrupt, SystemExit) as error:
                ended = changes.interrupted_by(error) if _is_ctrl_c(error) else error
                if isinstance(ended, Interrupted) and changes.files:
                    ended.known["written"] = changes.files
                raise ended from None

    _, *parameters = inspect.signature(verb).parameters.values()
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called
