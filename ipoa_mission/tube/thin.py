"""A predicted path with fewer points, for proofs that ask every leg of it."""

import numpy as np
import shapely

from ipoa_mission.geometry import Points, arc_lengths

STRAY = 0.02  # how far a thinned path may be from the predicted one [m]


def thinned(path: Points, stray: float) -> Points:
    """The path (n, 3) with points left out where the legs that remain pass them within about `stray` [m]."""
    if len(path) < 3:
        return path
    traveled = arc_lengths(path[:, :2])
    kept = {0}
    for view in (path[:, :2], np.column_stack([traveled, path[:, 2]])):  # from above, and from the side
        numbered = shapely.linestrings(np.column_stack([view, np.arange(len(path))]))
        kept |= set(shapely.get_coordinates(shapely.simplify(numbered, stray), include_z=True)[:, 2].astype(int))
    return np.asarray(path[sorted(kept)])
