"""The seeded maps: a hectare with 0 to 15 holes, twenty of each number.

Of the maps of Baehnemann and others (arXiv 1907.09224) only what was published of them is kept: 100 m by 100 m, in the
mean 4.9 corners to a hole, lines 3 m apart, 3 m/s, from a corner and back to it. Where holes lie and how large they are
is drawn here.
"""

import math

import numpy as np
import shapely
from shapely.affinity import rotate

from ipoa_mission.survey.area import Area

SIDE, SPACING, SPEED = 100.0, 3.0, 3.0
MOST_HOLES, MAPS = 15, 20  # of each number
CORNERS, SHARES = (3, 4, 5, 6, 7, 8), (0.1, 0.4, 0.2, 0.15, 0.1, 0.05)  # of a hole: 4.9 in the mean
RADII = 3.0, 9.0  # of the circle around a hole [m]
APART = 2.0  # holes from each other, and from the edge [m]


def survey_map(holes: int, number: int, turned: bool = False) -> Area:
    """The area with so many holes, and its number among those; `turned` by any angle about its corner."""
    rng = np.random.default_rng([holes, number])
    rings: list[list[tuple[float, float]]] = []
    taken = shapely.Polygon()
    while len(rings) < holes:
        radius = rng.uniform(*RADII)
        middle = rng.uniform(radius + APART, SIDE - radius - APART, 2)
        turns = np.sort(rng.uniform(0.0, 2 * math.pi, rng.choice(CORNERS, p=SHARES)))
        steps = np.diff(turns, append=turns[0] + 2 * math.pi)
        if steps.max() > 0.9 * math.pi or steps.min() < 0.2:  # neither slivers nor needles
            continue
        ring = [(float(middle[0] + radius * math.cos(t)), float(middle[1] + radius * math.sin(t))) for t in turns]
        hole = shapely.Polygon(ring)
        if hole.distance(taken) > APART or not rings:
            rings.append(ring)
            taken = taken.union(hole)
    area = Area.of([[[(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)], *rings]])
    angle = float(rng.uniform(0.0, 360.0)) if turned else 0.0
    return Area(rotate(area.shape, angle, origin=(0.0, 0.0))) if turned else area
