"""Groups of options, expanded into a verb for Typer; other rooms add groups to `plan`, and fly what they plan."""

import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache, wraps
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol, TypeAlias

import ipoa_mission.options as options
from ipoa_mission.cli.interrupting import ChangesMade
from ipoa_mission.errors import OptionConflict
from ipoa_mission.files import plug_ins, unused
from ipoa_mission.mission.flight_record import OnDeviation
from ipoa_mission.terminal import expect_free

if TYPE_CHECKING:
    from ipoa_mission.cli.mission_source import FlownJob, Job
    from ipoa_mission.scenario import Scenario

#: Flies a job; every frame goes to the log.
FlyJob: TypeAlias = "Callable[[Job, Path], FlownJob]"


@dataclass
class SearchOptions:
    seed: options.SeedOption = 0
    optimizer: Annotated[
        str | None, options.flag("--optimizer", "Search algorithm, like ipoa or poa, also an installed one.", "NAME")
    ] = None


@dataclass
class FlownByOptions:
    autopilot: options.AutopilotOption = None
    firmware_version: options.FirmwareVersionOption = None
    unmeasured_version: options.UnmeasuredVersionOption = False
    param: options.ParameterOption = None
    param_file: options.ParameterFileOption = None
    wind: Annotated[
        str | None, options.flag("--wind", "A steady wind by speed and origin: 6@270 is from the west.", "M/S@DEG")
    ] = None
    vehicle: Annotated[
        Path | None, options.flag("--vehicle", "A vehicle file written by `learn`: drag, lag, delays, power.", "FILE")
    ] = None

    def __post_init__(self) -> None:
        from ipoa_mission.autopilot.version import Version

        self.parameters, self.parameter_remarks = options.read_parameter_options(self.param, self.param_file)
        self.version = None if self.firmware_version is None else Version.parsed(self.firmware_version)
        self.air = options.read_wind_option(self.wind)


@dataclass
class WorldOptions:
    flown_by: FlownByOptions
    scenario: options.ScenarioOption = None
    ignore: options.IgnoreOption = None


@dataclass
class ContingencyOptions(WorldOptions):
    contingencies: options.ContingenciesOption = False

    def __post_init__(self) -> None:
        if self.contingencies and self.scenario is None:
            hint = "the clearance of a contingency depends on the obstacles"
            raise OptionConflict("needs --scenario", hint=hint, place="--contingencies")


@dataclass
class FileOutput:
    folder: options.OutOption = Path()
    report: options.ReportOption = False
    force: options.ForceOption = False
    as_json: options.JsonOption = False

    def expect_plans(self, names: Iterable[str]) -> None:
        """Refuse to overwrite anything but unchanged earlier plans."""
        from ipoa_mission.mission.mission_io import not_as_written

        paths = (path for name in names for path in not_as_written(self.folder, name, self.report))
        expect_free(paths, self.force, ask=not self.as_json)


@dataclass
class LinkOptions:
    system: options.SystemOption = None
    log: Annotated[
        Path | None, options.link_option("--log", "Log of every frame (.tlog); default: next to the mission.", "FILE")
    ] = None
    key: options.KeyOption = None
    timeout: Annotated[
        float | None,
        options.link_option(
            "--timeout",
            "Give up after this time [s], also in flight: the vehicle is no longer watched then. "
            "Default: one hour until a flight begins.",
            "S",
            min=1.0,
        ),
    ] = None
    backend: Annotated[options.Backend, options.link_option("--backend", "MAVLink implementation.")] = (
        options.Backend.BUILTIN
    )
    anyway: Annotated[bool, options.link_option("--anyway", options.ANYWAY)] = False

    def written(self, usual_log: Path | None) -> list[str]:
        log = self.log or usual_log
        return [] if self.backend is options.Backend.MAVSDK or log is None else [str(log)]


@dataclass
class FlightOptions:
    link: Annotated[
        str | None, options.link_option("--link", "Vehicle, like udpin:HOST:PORT; default: the built-in one.", "URL")
    ] = None
    begin: Annotated[
        int, options.link_option("--from", "Begin at item N of `show`; the path there is checked.", "N", min=1)
    ] = 1
    set_params: Annotated[
        bool, options.link_option("--set-params", "Write parameters of the scenario and --param that differ aboard.")
    ] = False
    on_deviation: Annotated[
        OnDeviation, options.link_option("--on-deviation", "Order sent once if the flight deviates from the forecast.")
    ] = OnDeviation.HOLD

    def given_for_link(self) -> dict[str, bool]:
        deviates = self.on_deviation is not OnDeviation.HOLD
        return {"--from": self.begin != 1, "--set-params": self.set_params, "--on-deviation": deviates}


@dataclass(frozen=True)
class PlanOptions:
    search: SearchOptions
    flown_by: FlownByOptions
    ignore: options.IgnoreOption = None
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
