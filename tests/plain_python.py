from importlib.util import find_spec, module_from_spec
from types import ModuleType
from unittest.mock import patch


def as_plain_python(name: str) -> ModuleType:
    """Import a module of kernels with nothing compiled."""
    specification = find_spec(name)
    assert specification is not None
    assert specification.loader is not None
    module = module_from_spec(specification)
    with patch("ipoa_mission.compiled.njit", lambda **_: lambda function: function):
        specification.loader.exec_module(module)
    return module
