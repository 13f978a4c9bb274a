"""Expand groups of options into a verb, for Typer; other rooms add groups to `plan`, and fly what they plan."""

import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache, wraps
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias

from ipoa_mission.cli.groups import FileOutput, FlightOptions, FlownByOptions, LinkOptions, SearchOptions
from ipoa_mission.cli.interrupting import ChangesMade
from ipoa_mission.files import plug_ins, unused
from ipoa_mission.options import IgnoreOption

if TYPE_CHECKING:
    from ipoa_mission.cli.mission_source import FlownJob, Job
    from ipoa_mission.scenario import Scenario

#: Flies a job; every frame goes to the log.
FlyJob: TypeAlias = "Callable[[Job, Path], FlownJob]"


@dataclass(frozen=True)
class PlanOptions:
    search: SearchOptions
    flown_by: FlownByOptions
    ignore: IgnoreOption = None
    files: FileOutput = field(default_factory=FileOutput)


@dataclass(frozen=True)
class FlyOptions(PlanOptions):
    on_vehicle: FlightOptions = field(default_factory=FlightOptions)
    on_link: LinkOptions = field(default_factory=LinkOptions)

    def log_of(self, name: str) -> Path:
        default_log = self.files.folder / f"{name}.tlog"
        return self.on_link.log or (default_log if self.on_vehicle.link is None else unused(default_log))


class Planner(Protocol):
    """A room's options of `plan`, as a dataclass with a default for each, and its planning and flying."""

    option: ClassVar[str]  # in place of a scenario file
    instead: ClassVar[str]  # the same, in words
    about: ClassVar[str]  # for the help of `plan`

    def scenario(self, path: Path | None) -> "Scenario | None": ...
    def accepts(self, scenario: "Scenario") -> bool: ...
    def plan(self, scenario: "Scenario", asked: PlanOptions, changes: ChangesMade) -> None: ...
    def fly(self, scenario: "Scenario", asked: FlyOptions, fly_job: FlyJob, changes: ChangesMade) -> None: ...


Planners: TypeAlias = list[Planner]


@cache
def planners() -> tuple[type[Any], ...]:
    return tuple(entry.load() for entry in plug_ins("planners"))


def planner_of(scenario: "Scenario", among: Iterable[Planner]) -> Planner | None:
    return next((planner for planner in among if planner.accepts(scenario)), None)


def grouped(verb: Callable[..., None]) -> Callable[..., None]:
    parameters: list[inspect.Parameter] = []
    groups: dict[str, tuple[Any, ...]] = {}
    for parameter in inspect.signature(verb).parameters.values():
        if parameter.annotation is Planners or is_dataclass(parameter.annotation):
            groups[parameter.name] = planners() if parameter.annotation is Planners else (parameter.annotation,)
            parameters += chain.from_iterable(map(_expanded, groups[parameter.name]))
        else:
            parameters.append(parameter)

    @wraps(verb)
    def called(**values: Any) -> None:
        for name, kinds in groups.items():
            made = [_made(kind, values) for kind in kinds]
            values[name] = made if kinds == planners() else made[0]
        verb(**values)

    named = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in parameters]
    called.__signature__ = inspect.Signature(named)  # type: ignore[attr-defined]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in named}
    about = (inspect.cleandoc(kind.about) for kinds in groups.values() if kinds == planners() for kind in kinds)
    called.__doc__ = inspect.cleandoc(verb.__doc__ or "").replace("Example: ", "\n\n".join((*about, "Example: ")))
    return called


def _expanded(group: Any) -> Iterator[inspect.Parameter]:
    for parameter in inspect.signature(group).parameters.values():
        yield from _expanded(parameter.annotation) if is_dataclass(parameter.annotation) else (parameter,)


def _made(group: Any, values: dict[str, Any]) -> Any:
    inner = {option.name: _made(option.type, values) for option in fields(group) if is_dataclass(option.type)}
    return group(**inner, **{option.name: values.pop(option.name) for option in fields(group) if option.name in values})
