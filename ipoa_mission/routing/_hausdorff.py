# mypy: disable-error-code="no-untyped-def,misc"

import math

from ipoa_mission.compiled import njit


@njit(cache=True, error_model="numpy")
def farthest(points, others):
    """Return the directed Hausdorff distance from `points` (n, 3) to `others` (m, 3).

    A point is dropped once another is nearer than the maximum so far (Taha and Hanbury 2015).
    """
    most, near = 0.0, 0
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        least, nearest = math.inf, near
        for k in range(2 * len(others)):
            o = near + (k + 1) // 2 if k % 2 else near - k // 2
            if not 0 <= o < len(others):
                continue
            square = (others[o, 0] - x) ** 2 + (others[o, 1] - y) ** 2 + (others[o, 2] - z) ** 2
            if square < least:
                least, nearest = square, o
                if square <= most:
                    break
        most, near = max(most, least), nearest
    return math.sqrt(most)
