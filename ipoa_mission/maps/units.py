"""Units such as "m s-1", "kt", "km/h", "ft"."""

import re
from functools import cache
from typing import Any

from ipoa_mission.errors import BadInput, imported

_EXPONENT = re.compile(r"(?<=[A-Za-z])(?=-?\d)")
OTHER_NAMES = ("geopotential_meter = meter = gpm", "feet_per_minute = foot / minute = fpm")


def unit_factor(unit: str, target: str, place: str) -> float:
    pint, registry = _registry()
    for spelling in (unit, unit.lower()):
        try:
            return float(registry.Quantity(1.0, registry.parse_units(spelling)).to(target).magnitude)
        except (pint.PintError, ValueError, TypeError, AssertionError, AttributeError, RecursionError):
            continue
    raise BadInput(f"expected a unit that converts to {target}, not {unit!r}", place=place)


@cache
def _registry() -> tuple[Any, Any]:
    pint = imported("pint", "units of a forecast need pint, which is not installed", "wind")
    registry = pint.UnitRegistry(preprocessors=[lambda text: _EXPONENT.sub("**", text)])
    for definition in OTHER_NAMES:
        registry.define(definition)
    return pint, registry
