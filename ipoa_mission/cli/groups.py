"""Options that go together, as one value: a verb takes the group, and Typer is shown each option of it."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ipoa_mission.cli.options import (
    AnywayOption,
    AutopilotOption,
    Backend,
    BackendOption,
    DelayOption,
    DuplicateOption,
    KeyOption,
    LearnedOption,
    LogOption,
    LossOption,
    NakOption,
    OptimizerOption,
    ParameterFileOption,
    ParameterOption,
    PlannerOption,
    PolishOption,
    ReorderOption,
    SeedOption,
    SystemOption,
    TimeoutOption,
    WindOption,
    WindProfileOption,
    read_parameter_options,
    read_wind_option,
)

if TYPE_CHECKING:
    from ipoa_mission.simulator.faults import Faults
    from ipoa_mission.wind import Wind


def grouped(verb: Callable[..., None]) -> Callable[..., None]:
    """The verb as Typer calls it: each parameter that is a group is taken option by option."""
    parameters: list[inspect.Parameter] = []
    groups: dict[str, Any] = {}
    for parameter in inspect.signature(verb).parameters.values():
        if is_dataclass(parameter.annotation):
            groups[parameter.name] = parameter.annotation
            parameters += inspect.signature(groups[parameter.name]).parameters.values()
        else:
            parameters.append(parameter)

    @wraps(verb)
    def called(**given: Any) -> None:
        for name, group in groups.items():
            given[name] = group(**{field.name: given.pop(field.name) for field in fields(group) if field.name in given})
        verb(**given)

    named = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in parameters]
    called.__signature__ = inspect.Signature(named)  # type: ignore[attr-defined]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in named}
    return called


@dataclass
class SearchOptions:
    """How a path is sought."""

    seed: SeedOption = 0
    optimizer: OptimizerOption = None
    planner: PlannerOption = None
    polish: PolishOption = True


@dataclass
class FlownByOptions:
    """What flies a mission, and in what wind."""

    autopilot: AutopilotOption = None
    param: ParameterOption = None
    param_file: ParameterFileOption = None
    wind: WindOption = None
    wind_profile: WindProfileOption = None
    vehicle: LearnedOption = None

    @cached_property
    def parameters(self) -> dict[str, float]:
        """By name; BadInput as `read_parameter_options`."""
        return read_parameter_options(self.param, self.param_file)

    @cached_property
    def air(self) -> "Wind | None":
        """The wind, if one was given; BadInput as `read_wind_option`."""
        return read_wind_option(self.wind, self.wind_profile)


@dataclass
class LinkOptions:
    """How a vehicle is spoken to."""

    system: SystemOption = None
    log: LogOption = None
    key: KeyOption = None
    timeout: TimeoutOption = None
    backend: BackendOption = Backend.BUILTIN
    anyway: AnywayOption = False

    def written(self, usual_log: Path) -> list[str]:
        """The file with every frame; MAVSDK keeps none."""
        return [] if self.backend is Backend.MAVSDK else [str(self.log or usual_log)]


@dataclass
class FaultOptions:
    """What a bad link does."""

    loss: LossOption = 0.0
    duplicate: DuplicateOption = 0.0
    delay: DelayOption = 0.0
    reorder: ReorderOption = 0.0
    nak_at: NakOption = None

    def faults(self) -> "Faults":
        """The same for the simulator."""
        from ipoa_mission.simulator.faults import Faults

        return Faults(self.loss, self.duplicate, self.delay, self.reorder, nak_at=self.nak_at)
