"""Build an optimizer from a name and user settings; others register in the group `ipoa_mission.optimizers`."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError

from ipoa_mission.errors import BadInput, UnknownName, hint_of
from ipoa_mission.files import plug_ins
from ipoa_mission.optimize.ipoa import IPOA
from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.search import Optimizer

BUILT_IN: dict[str, type[Optimizer]] = {"ipoa": IPOA, "poa": POA}


def optimizer_names() -> list[str]:
    return [*BUILT_IN, *sorted({entry.name for entry in plug_ins("optimizers")} - BUILT_IN.keys())]


def optimizer_class(name: str) -> type[Optimizer]:
    """Raise BadInput if not exactly one optimizer has this name, or it cannot be imported."""
    same = {entry.value: entry for entry in plug_ins("optimizers") if entry.name == name}
    if len(same) + (name in BUILT_IN) > 1:
        sources = [*same, *(["the built-in one"] if name in BUILT_IN else [])]
        raise BadInput(f"expected one optimizer {name}, not {' and '.join(sources)}", place="optimizer.name")
    if name in BUILT_IN:
        return BUILT_IN[name]
    if not same:
        *others, last = names = optimizer_names()
        words = f"expected {', '.join(others)} or {last}, not {name!r}"
        raise UnknownName(words, hint=hint_of(name, names), place="optimizer.name")
    (registered,) = same.values()
    try:
        loaded: Any = registered.load()
    except (ImportError, AttributeError) as error:
        words = f"{name} is registered as {registered.value}, which fails: {error}"
        raise BadInput(words, place="optimizer.name") from error
    if not (isinstance(loaded, type) and hasattr(loaded, "search") and hasattr(loaded, "__dataclass_fields__")):
        words = f"{name} is registered as {registered.value}, not a dataclass with a search method"
        raise BadInput(words, place="optimizer.name")
    return loaded


def build_optimizer(name: str, settings: Mapping[str, object]) -> Optimizer:
    """Raise BadInput if a setting does not exist or is out of range."""
    kind = optimizer_class(name)
    types = get_type_hints(kind, include_extras=True)
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    for key in settings:
        if key not in names:
            words = f"{name} has no such setting; it has {', '.join(names)}"
            raise UnknownName(words, hint=hint_of(key, names), place=f"optimizer.{key}")
    return kind(**{key: _checked(f"optimizer.{key}", types[key], value) for key, value in settings.items()})


def _checked(place: str, kind: Any, value: object) -> Any:
    try:
        return TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False)).validate_python(value)
    except ValidationError as error:
        words = error.errors()[0]["msg"].replace("Input should be", "expected")
        raise BadInput(f"{words}, not {value!r}", place=place) from error
