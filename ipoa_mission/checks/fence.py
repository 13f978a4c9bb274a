from collections.abc import Iterator

import numpy as np
import shapely

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import union_of
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Mission, item_of, numbered_items


def check_fence(forecast: Forecast) -> Iterator[Finding]:
    mission = forecast.mission
    frame = forecast.frame
    wrong = {n: words for n, part in enumerate(mission.fence) if (words := _wrong(part, frame))}
    yield from (Finding("fence-shape", Severity.ERROR, None, f"fence[{n}]: {words}") for n, words in wrong.items())
    if wrong or not mission.fence:
        return
    allowed, where = _allowed(mission, frame)
    places = {"home": mission.home} | {f"rally[{n}]": place for n, place in enumerate(mission.rally)}
    for name, place in places.items():
        if not allowed.covers(shapely.Point(frame.local(place)[:2])):
            words = f"{name}: expected {where}, but it lies outside"
            yield Finding("outside-fence", Severity.ERROR, 0 if name == "home" else None, words)
    for at in numbered_items(mission):
        if at.item.command == Command.DO_FENCE_ENABLE and at.item.params[0] == 0.0:
            yield at.warning("fence-off", "switches the fence off: the vehicle does not keep it from here on")
    yield from _legs(forecast, allowed, where)


def _wrong(part: FencePolygon | FenceCircle, frame: LocalFrame) -> str | None:
    if isinstance(part, FenceCircle):
        return None
    if len(part.vertices) < 3:
        return f"expected a polygon of three vertices or more, not {len(part.vertices)}"
    if (reason := shapely.is_valid_reason(_area(part, frame))) == "Valid Geometry":
        return None
    return f"expected a polygon whose edges do not cross or overlap: {reason.split('[')[0].lower()}"


def _allowed(mission: Mission, frame: LocalFrame) -> tuple[shapely.Geometry, str]:
    inside = [_area(part, frame) for part in mission.fence if part.inclusion]
    outside = [_area(part, frame) for part in mission.fence if not part.inclusion]
    one_is_enough = mission.autopilot.parameter_table.has_bit(mission.parameters, mission.firmware.fence_union_by)
    join = union_of if one_is_enough else shapely.intersection_all
    allowed = join(inside) if inside else shapely.box(-1e7, -1e7, 1e7, 1e7)
    where = "inside the fence" if one_is_enough or len(inside) < 2 else "inside all inclusions of the fence"
    return shapely.difference(allowed, union_of(outside)), where


def _area(part: FencePolygon | FenceCircle, frame: LocalFrame) -> shapely.Geometry:
    if isinstance(part, FenceCircle):
        center = frame.local(Geodetic(*part.center, frame.home.altitude))[:2]
        return shapely.Point(center).buffer(part.radius, quad_segs=90)  # within 4e-5 radii of the circle
    latitude, longitude = np.array(part.vertices).T
    return shapely.Polygon(frame.to_local(latitude, longitude, np.full(len(latitude), frame.home.altitude))[:, :2])


def _legs(forecast: Forecast, allowed: shapely.Geometry, where: str) -> Iterator[Finding]:
    wide = allowed.buffer(0.05)  # [m]
    reported: set[int] = set()
    for leg in forecast.legs:
        start, end = (wide.covers(shapely.Point(leg.points[n, :2])) for n in (0, -1))
        if leg.seq in reported or (end and wide.covers(shapely.LineString(leg.points[:, :2]))):
            continue
        if not end and leg.stage is not FlightStage.RETURN:
            message = f"expected {where}, but it lies outside"
        elif start:
            message = f"expected legs {where}, but {leg.name} crosses it"
        else:
            continue
        reported.add(leg.seq)
        yield item_of(forecast.mission, leg.seq).error("outside-fence", message)
