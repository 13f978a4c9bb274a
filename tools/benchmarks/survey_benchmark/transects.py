"""What QGroundControl flies over an area: its transects, which know of no holes, and the same led round them."""

from itertools import pairwise

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.document import Node
from ipoa_mission.mission.scan_items import lay_out
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.free import FreeSpace, Ways
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.world.frame import Geodetic, LocalFrame


def transects(area: Area, spacing: float, home: Geodetic) -> Points:
    """The corners (n, 2) of its survey of the outer ring, at its default angle of 0 degrees and no turnaround."""
    frame = LocalFrame(home)
    ring = shapely.get_coordinates(area.shape.geoms[0].exterior)[:-1]
    latitude, longitude, _ = frame.to_geodetic(np.column_stack([ring, np.zeros(len(ring))]))
    style = {
        "CameraCalc": {
            "AdjustedFootprintSide": spacing,
            "AdjustedFootprintFrontal": 0.0,
            "DistanceToSurface": 30.0,
            "DistanceToSurfaceRelative": True,
        },
        "TurnAroundDistance": 0.0,
    }
    corners = [[float(a), float(b)] for a, b in zip(latitude, longitude, strict=True)]
    survey = {"complexItemType": "survey", "angle": 0, "polygon": corners, "TransectStyleComplexItem": style}
    laid_out, _ = lay_out(Node("survey", "", survey))
    items = [item for item in laid_out if item.has_position]
    places = [frame.local(Geodetic(item.latitude_deg, item.longitude_deg, home.altitude))[:2] for item in items]
    return np.array(places)


def led_round(path: Points, area: Area, cost: LegTimes, place: Vector) -> Points:
    """The same path, its legs cut where holes begin and joined round them by the shortest ways; and back to a place."""
    space = FreeSpace.of(area.shape.buffer(0.1, join_style="mitre"))
    solid = shapely.union_all([shapely.Polygon(ring) for part in area.shape.geoms for ring in part.interiors])
    whole = [place]
    for start, end in pairwise([*path, place]):
        left = shapely.get_parts(shapely.LineString([start, end]).difference(solid))
        corners = [at for part in left for at in shapely.get_coordinates(part)]
        for at in sorted(corners, key=lambda corner: float(np.linalg.norm(corner - start))):
            if (at != whole[-1]).any():
                whole += list(Ways(np.array([whole[-1]] * 2 + [at] * 2), space, space, cost).way(0, 2)[1:])
    return np.array(whole)
