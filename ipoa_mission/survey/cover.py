"""The quickest tour of parallel lines that sees all of an area and keeps inside it."""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

from ipoa_mission.geometry import Vector
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Tour

#: Of the lines, clockwise from north [degrees]; several: one pass in each; crosshatch: the best one and the one across.
Direction: TypeAlias = Literal["best", "crosshatch"] | float | Sequence[float]


def quickest_tour(
    area: Area,
    spacing: float,
    *,
    cost: LegTimes,
    keep_out: Any = None,
    direction: Direction = "best",
    turns_outside: float = 0.0,
    begin: Vector | None = None,
    end: Vector | None = None,
) -> Tour:
    """The tour that takes the least time.

    Args:
        area: what is to be seen; its holes are kept out of.
        spacing: between lines [m]: what lies within half of it of a line is seen.
        cost: how long the vehicle takes.
        keep_out: a shapely geometry that neither lines nor ways enter, obstacles grown by their clearance.
        direction: of the lines.
        turns_outside: how far ways may leave the area [m].
        begin: where the vehicle comes from (2,); left out, it does not matter.
        end: where it goes afterwards (2,).

    Returns:
        Lines and ways; the same for the same arguments.

    Raises:
        BadInput: naming the argument.
    """
    raise NotImplementedError
