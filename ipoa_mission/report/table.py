import csv
import io
import math
from collections import Counter, defaultdict
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ipoa_mission.autopilot.commands import Command, Frame, plain_frame
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import bearing, leg_lengths
from ipoa_mission.mission.item_words import details_of, hold_of
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.positions import refusals

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario


@dataclass(frozen=True)
class Row:
    """One line of the table, in meters; `seq` 0 is home.

    `length` and `climb` are of the whole way from the item before; for a return, home and down. `heading_deg`: last
    horizontal part, clockwise from north.
    """

    seq: int
    command: str
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    altitude_amsl: float | None = None
    height: float | None = None  # above home
    height_above_ground: float | None = None  # if known
    length: float | None = None
    heading_deg: float | None = None
    climb: float | None = None
    hold_s: float | None = None
    speed: float | None = None  # [m/s] after the change
    detail: str = ""
    passes: int = 1  # of its leg by jumps

    def heading(self, digits: int) -> float | None:
        """Return the heading rounded, below 360 [deg]."""
        return None if self.heading_deg is None else bearing(self.heading_deg, digits)


def shown(value: float | str | None, form: str = "z.1f") -> str:
    return "" if value is None else format(value, form)


def mission_table(mission: Mission, scenario: "Scenario | None" = None) -> tuple[Row, ...]:
    """Tabulate a mission: home and every item.

    Args:
        mission: has no legs if a position or height is invalid.
        scenario: gives heights above its ground.

    Returns:
        A row each: lengths and heights [m], headings [degrees], or None.

    Example:
        >>> from ipoa_mission import mission_table, read_mission
        >>> home, first, *others = mission_table(read_mission("missions/sitl.plan"))
        >>> home.command, first.command
        ('home', 'NAV_TAKEOFF')
    """
    return rows_of(Forecast(mission, scenario))


def rows_of(forecast: Forecast) -> tuple[Row, ...]:
    mission = forecast.mission
    legs = defaultdict[int, list[Leg]](list)
    passes = Counter[int]()
    if not refusals(mission):
        for leg in forecast.legs:
            if not leg.alternative:
                legs[leg.seq].append(leg)
        if any(item.is_jump for item in mission.items):
            with suppress(BadInput):  # endless jumps
                passes.update(visit.seq for visit in forecast.itinerary.visits)
    home = Row(0, "home", mission.home.latitude_deg, mission.home.longitude_deg, mission.home.altitude, 0.0)
    rows = (_row(seq, item, mission, legs[seq], forecast.scenario) for seq, item in enumerate(mission.items, start=1))
    return (home, *(replace(row, passes=max(passes[row.seq], 1)) for row in rows))


def to_csv(forecast: Forecast, name: str) -> str:
    """RFC 4180, but LF; `name` is unused."""
    columns = {
        "seq": ("seq", ""),
        "command": ("command", ""),
        "latitude_deg": ("latitude_deg", "z.9f"),
        "longitude_deg": ("longitude_deg", "z.9f"),
        "altitude_amsl_m": ("altitude_amsl", "z.3f"),
        "height_above_home_m": ("height", "z.3f"),
        "height_above_ground_m": ("height_above_ground", "z.3f"),
        "leg_m": ("length", "z.2f"),
        "heading_deg": ("heading_deg", ".1f"),
        "climb_m": ("climb", "z.2f"),
        "hold_s": ("hold_s", ".1f"),
        "speed_m_s": ("speed", ".2f"),
        "detail": ("detail", ""),
        "passes": ("passes", ""),
    }
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for exact in rows_of(forecast):
        row = replace(exact, heading_deg=exact.heading(1))
        writer.writerow([shown(getattr(row, attribute), form) for attribute, form in columns.values()])
    return out.getvalue()


def _row(seq: int, item: Item, mission: Mission, legs: list[Leg], scenario: "Scenario | None") -> Row:
    placed = item.command in mission.firmware.placed and item.frame != Frame.MISSION
    on_map = placed and (item.latitude_deg, item.longitude_deg) != (0.0, 0.0)
    height = mission.altitude_above_home(item) if placed else math.nan
    points = np.vstack([leg.points for leg in legs]) if legs else None
    if scenario is not None and points is not None and item.command in {Command.NAV_LAND, Command.NAV_VTOL_LAND}:
        height = scenario.frame.geodetic(points[-1]).altitude - mission.home.altitude
    return Row(
        seq=seq,
        command=item.name,
        latitude_deg=item.latitude_deg if on_map else None,
        longitude_deg=item.longitude_deg if on_map else None,
        altitude_amsl=_known(mission.home.altitude + height),
        height=_known(height),
        height_above_ground=_above_ground(item, mission, height, scenario) if on_map else None,
        length=None if points is None else float(leg_lengths(points).sum()),
        heading_deg=_heading(legs),
        climb=None if points is None else float(points[-1, 2] - points[0, 2]),
        hold_s=hold_of(item),
        speed=_known(item.params[1]) if item.command == Command.DO_CHANGE_SPEED else None,
        detail=details_of(item),
    )


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _above_ground(item: Item, mission: Mission, height: float, scenario: "Scenario | None") -> float | None:
    if plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT:
        return item.altitude
    if scenario is None or not math.isfinite(height):
        return None
    place = Geodetic(item.latitude_deg, item.longitude_deg, mission.home.altitude + height)
    point = scenario.frame.local(place)
    return float(point[2] - scenario.airspace.ground(point[None, :])[0])


def _heading(legs: list[Leg]) -> float | None:
    for leg in reversed(legs):
        for step in np.diff(leg.points, axis=0)[::-1]:
            if np.hypot(step[0], step[1]) > 0.5:  # [m]
                return float(np.degrees(np.arctan2(step[0], step[1])) % 360.0)
    return None
