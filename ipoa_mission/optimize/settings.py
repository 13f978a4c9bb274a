"""Types and ranges of optimizer settings."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias, get_args, get_origin

from ipoa_mission.errors import BadInput

#: An optimizer's `short_settings` are those of its short searches. Without them they end after this many evaluations.
SHORT_EVALUATIONS = 2500
SHORT_SETTINGS = {"population": 20, "iterations": 25}


@dataclass(frozen=True)
class Between:
    least: float
    most: float = math.inf

    def __str__(self) -> str:
        return f"of at least {self.least:g}" if math.isinf(self.most) else f"from {self.least:g} to {self.most:g}"


Count: TypeAlias = Annotated[int, Between(1)]
Members: TypeAlias = Annotated[int, Between(4)]  # for steps between distinct members
Fraction: TypeAlias = Annotated[float, Between(0, 1)]
Amount: TypeAlias = Annotated[float, Between(0)]


def check_setting(place: str, kind: Any, value: object) -> object:
    """Return `value` as `kind`: bool, int, float, a Literal, or Annotated with a `Between`.

    Raises:
        BadInput: it is not; the message begins with `place`.
    """
    (kind, *rest) = get_args(kind) if get_origin(kind) is Annotated else (kind,)
    limits = next((r for r in rest if isinstance(r, Between)), Between(-math.inf))
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            raise BadInput(f"expected {' or '.join(map(repr, get_args(kind)))}, not {value!r}", place=place)
        return value
    if kind is bool:
        if not isinstance(value, bool):
            raise BadInput(f"expected true or false, not {value!r}", place=place)
        return value
    wanted = f"expected a {'whole ' if kind is int else ''}number {limits}"
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise BadInput(f"{wanted}, not {value!r}", place=place)
    if not limits.least <= value <= limits.most or (kind is int and value != int(value)):
        raise BadInput(f"{wanted}, not {value!r}", place=place)
    return kind(value)
