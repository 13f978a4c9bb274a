"""The union of areas, of which none is lost."""

from typing import Any

import numpy as np
import shapely

GRID = 1e-9  # on which GEOS loses none; of metres, and of degrees


def union_of(areas: Any) -> Any:
    """What polygons of shapely (n,), or nothing, hold together.

    GEOS 3.14 may lose some, even half of all, where many just meet; on a grid it does not, which takes three times as
    long: it is asked for that only where a place inside of one is missing.

    Example:
        >>> halves = [shapely.box(0.0, 0.0, 1.0, 2.0), shapely.box(1.0, 0.0, 2.0, 2.0)]
        >>> union_of(halves).area
        4.0
    """
    areas = np.asarray(areas, dtype=object)
    whole = shapely.union_all(areas)
    shapely.prepare(whole)
    held = shapely.intersects(whole, shapely.point_on_surface(areas))
    return whole if (held | shapely.is_empty(areas)).all() else shapely.union_all(areas, grid_size=GRID)
