from typing import Any

import numpy as np
import shapely

GRID = 1e-9  # [m or degrees]


def union_of(areas: Any) -> Any:
    """Return the union of shapely polygons (n,), or nothing.

    GEOS 3.14 may lose some polygons where many just touch. A grid prevents this, but takes three times as long; it is
    used only if an inner point of a polygon is missing.

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
