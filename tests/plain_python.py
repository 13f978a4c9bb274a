from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from importlib.util import find_spec, module_from_spec
from types import ModuleType
from typing import Any
from unittest.mock import patch

from ipoa_mission.vehicles.arducopter.dynamics.motion import State


def as_plain_python(name: str) -> ModuleType:
    """Import a module of kernels with nothing compiled."""
    specification = find_spec(name)
    assert specification is not None
    assert specification.loader is not None
    module = module_from_spec(specification)
    with patch("ipoa_mission.compiled.njit", lambda **_: lambda function: function):
        specification.loader.exec_module(module)
    return module


class PlainState(State):
    def item(self) -> tuple[Any, ...]:
        return tuple(getattr(self, field.name) for field in fields(State))


class PlainRecords(list[Any]):
    def tobytes(self) -> bytes:
        return repr(self).encode()


def plain_records(values: Any, kind: type) -> PlainRecords:
    return PlainRecords(PlainState(*PlainState.item(each)) if kind is State else each for each in values)


@contextmanager
def flown_as_plain_python() -> Iterator[None]:
    """Let both vehicles' dynamics run as plain Python."""
    dynamics = ("px4_multicopter.simulation", "arducopter.dynamics.copter")
    with (
        patch(f"ipoa_mission.vehicles.{dynamics[0]}.compiled", lambda function: function),
        patch(f"ipoa_mission.vehicles.{dynamics[0]}.records", plain_records),
        patch(f"ipoa_mission.vehicles.{dynamics[1]}.compiled", lambda function: function),
        patch(f"ipoa_mission.vehicles.{dynamics[1]}.records", plain_records),
    ):
        yield
