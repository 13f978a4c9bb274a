"""The airspace as flat arrays for kernels, with a lookup by grid cell; analytic surfaces are resampled."""

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.obstacles.obstacle import NO_EDGES, PRISM, GridRow
from ipoa_mission.world.terrain import Flat, Grid, Terrain

if TYPE_CHECKING:  # kernels need only numpy, shapely and pyproj
    from ipoa_mission.scenario.path_limits import Limits
    from ipoa_mission.world.airspace import Airspace

FENCE = PRISM + 1  # seen from inside
LEAST = 0.05  # of a threat [m]
LEVER = 10.0  # run of the slack of a slope [m]
UNLIMITED = 1e9
ENDLESS = 1e9  # of a fence [m]
RESAMPLED = 400


class Raster(NamedTuple):
    """A regular grid: its south-western corner [m], steps per meter, rows and columns."""

    east: float
    north: float
    per_meter: float
    rows: int
    columns: int


class ObstacleGrid(NamedTuple):
    """`shape` rows: sphere east, north, up, radius; cylinder east, north, radius, base, top.

    Prism or fence: first edge, end of edges, unused, base, top. Edges: east, north, east, north.
    """

    cells: Raster  # cell arrays are flat, row by row
    first: NDArray[np.int32]  # (cells + 1,): begin of a cell's list in `listed`
    listed: NDArray[np.int32]
    top: NDArray[np.float64]  # (cells,): no ground matters above [m]
    around: NDArray[np.float64]  # (k, 5): east, north, radius squared, lowest, highest
    kind: NDArray[np.int8]  # (k,)
    shape: NDArray[np.float64]  # (k, 5)
    edges: NDArray[np.float64]  # (m, 4)
    ground: Raster  # of heights
    heights: NDArray[np.float64]  # (rows, columns)
    lower: Vector  # (3,) bounds
    upper: Vector
    reach: float  # of the lists [m]
    low_zones: NDArray[np.float64]  # (z, 4): east, north, radius, height


class Rules(NamedTuple):
    clearance: float  # from obstacles [m]
    height: float  # above ground [m]
    ceiling: float  # above ground [m]
    climb_slope: float  # height over distance
    descent_slope: float
    radius: float  # hull [m]
    d_safe: float  # [m]
    length: float  # cost per meter
    turning: float  # cost per radian
    climbing: float  # cost per radian
    threat: float  # cost per meter (or node) at one meter
    per_node: bool
    collision: float  # and per square meter of depth times length
    depth: float


class Nodes(NamedTuple):
    price: NDArray[np.float64]  # (nx, ny, nz): per meter, infinite if blocked
    slack: NDArray[np.float64]  # (nx, ny, nz) [m]
    places: Points  # (nx ny nz, 3), near the lattice
    spacing: Vector  # (3,) [m]


class NodeBasis(NamedTuple):
    first: NDArray[np.int64]  # (n,): the first of five control points
    values: NDArray[np.float64]  # (3, 5, n): of the node, the step to it, and the step from it


class ControlPointShifts(NamedTuple):
    """Shifts of n control points by f free ones, along a sparse matrix (n, f).

    Row i has the `weights` and `columns` from `starts[i]` to `starts[i + 1]`.
    """

    free: int  # coordinates, 3 f
    band_width: int  # of the Hessian by free coordinates
    starts: NDArray[np.int64]  # (n + 1,)
    columns: NDArray[np.int64]
    weights: NDArray[np.float64]


class PolishInputs(NamedTuple):
    """Nodes about `mean_leg` [m] apart that depend on the control points that are moved."""

    basis: NodeBasis
    shifts: ControlPointShifts
    mean_leg: float


class Smoothing(NamedTuple):
    bend: float  # smaller angles count squared [rad]
    reach: float  # at which barriers begin to act [m]
    barrier: float  # cost per meter of path at about `reach`
    stiffness: float  # per meter of path, of a squared meter
    evenness: float
    aside: float  # to the required clearance [m]
    above: float  # to the required height [m]
    flatter: float  # from the greatest slopes

    def scaled(self, scale: float) -> "Smoothing":
        """Return the smoothing of a scene with lengths times `scale`."""
        return self._replace(
            reach=self.reach * scale,
            barrier=self.barrier / scale,
            stiffness=self.stiffness / scale**3,
            evenness=self.evenness / scale,
            aside=self.aside * scale,
            above=self.above * scale,
        )


def obstacle_grid_of(airspace: "Airspace", limits: "Limits", reach: float) -> ObstacleGrid:
    """Return the grid, with lists of all within `reach` [m] of each cell."""
    lower = np.asarray(airspace.bounds.lower, float)
    upper = np.asarray(airspace.bounds.upper, float)
    size = upper[:2] - lower[:2]
    cell = float(size.max()) / np.clip(4 * np.sqrt(len(airspace.obstacles)), 64, 512)
    columns, rows = np.ceil(size / cell).astype(int)
    cells = Raster(float(lower[0]), float(lower[1]), 1 / cell, int(rows), int(columns))

    parts = [part for obstacle in airspace.obstacles for part in obstacle.parts]
    bodies = [part.grid_row() for part in parts]
    boxes = [part.bounds for part in parts]
    area = airspace.bounds.footprint
    if area is not None:
        bodies.append(GridRow(FENCE, (0.0, 0.0, 0.0, -ENDLESS, ENDLESS), np.inf, np.hstack(area.edges)))
        boxes.append(np.array([[-ENDLESS] * 3, [ENDLESS] * 3]))
    bounds = np.array(boxes).reshape(-1, 2, 3)
    middle = bounds[:, :, :2].mean(axis=1)
    reached = np.array([body.plan_radius for body in bodies], float) + reach
    first, listed = _lists(bounds, reached, cells, cell, reach)
    shape, edges = _shapes(bodies)

    ground = _heights(airspace.terrain, tuple(lower[:2]), tuple(upper[:2]))
    concern = np.inf if np.isfinite(limits.ceiling_above_ground) else limits.height_above_ground + reach
    return ObstacleGrid(
        cells=cells,
        first=first,
        listed=listed,
        top=_highest(ground, lower, cell, int(rows), int(columns)).ravel() + concern,
        around=np.column_stack([middle, reached**2, bounds[:, :, 2] + np.array([-reach, reach])]),
        kind=np.array([body.kind for body in bodies], np.int8),
        shape=shape,
        edges=edges,
        ground=Raster(float(ground.east), float(ground.north), 1 / ground.spacing, *ground.heights.shape),
        heights=np.ascontiguousarray(ground.heights, float),
        lower=lower,
        upper=upper,
        reach=reach,
        low_zones=np.array([(z.east, z.north, z.radius, z.height) for z in limits.low_zones]).reshape(-1, 4),
    )


@lru_cache(maxsize=4)  # for each of the enlarged airspaces of a plan
def _heights(terrain: Terrain, lower: tuple[float, float], upper: tuple[float, float]) -> Grid:
    if isinstance(terrain, Grid):
        return terrain
    size = np.subtract(upper, lower)
    spacing = float(size.max()) / (1 if isinstance(terrain, Flat) else RESAMPLED)
    columns, rows = np.ceil(size / spacing).astype(int) + 1
    east, north = np.meshgrid(lower[0] + spacing * np.arange(columns), lower[1] + spacing * np.arange(rows))
    heights = terrain.height(np.column_stack([east.ravel(), north.ravel()]))
    return Grid(*lower, spacing, heights.reshape(rows, columns))


def _highest(ground: Grid, lower: Vector, cell: float, rows: int, columns: int) -> NDArray[np.float64]:
    heights = ground.heights
    for axis, (count, origin, start) in enumerate(((rows, lower[1], ground.north), (columns, lower[0], ground.east))):
        last = heights.shape[axis] - 1
        edge = (origin + cell * np.arange(count + 1) - start) / ground.spacing
        low = np.clip(np.floor(edge[:-1]), 0, last).astype(int)
        high = np.clip(np.ceil(edge[1:]), 0, last).astype(int)
        strips = [heights.take(range(a, b + 1), axis).max(axis=axis) for a, b in zip(low, high, strict=True)]
        heights = np.stack(strips, axis=axis)
    return heights


def _shapes(bodies: Sequence[GridRow]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows of `shape` (k, 5) and `edges` (m, 4)."""
    shape = []
    edges = [NO_EDGES]
    for body in bodies:
        numbers = body.numbers
        if len(body.edges):
            start = sum(map(len, edges))
            edges.append(body.edges)
            numbers = (start, start + len(body.edges), *numbers[2:])
        shape.append(numbers)
    return np.array(shape, float).reshape(-1, 5), np.vstack(edges)


def _lists(
    bounds: NDArray[np.float64], reached: Vector, cells: Raster, cell: float, reach: float
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the begin of each cell's list (cells + 1,), and the lists.

    Bodies have `bounds` (k, 2, 3), and plan radii `reached` (k,) [m] that include `reach`.
    """
    corner = np.array([cells.east, cells.north])
    last = (cells.columns - 1, cells.rows - 1)
    low = np.clip(np.floor((bounds[:, 0, :2] - reach - corner) / cell), 0, last).astype(int)
    high = np.clip(np.floor((bounds[:, 1, :2] + reach - corner) / cell), 0, last).astype(int)
    extent = high - low + 1
    count = extent.prod(axis=1)
    body = np.repeat(np.arange(len(bounds)), count)
    within = np.arange(len(body)) - np.repeat(np.cumsum(count) - count, count)
    column = low[body, 0] + within % extent[body, 0]
    row = low[body, 1] + within // extent[body, 0]
    away = bounds[:, :, :2].mean(axis=1)[body] - corner - cell * (np.column_stack([column, row]) + 0.5)
    near = (away**2).sum(axis=1) <= (reached[body] + 0.71 * cell) ** 2
    number = (row * cells.columns + column)[near]
    order = np.argsort(number, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(number, minlength=cells.rows * cells.columns))])
    return first.astype(np.int32), body[near][order].astype(np.int32)
