"""Time how long maps take to load: a city of 5,000 buildings on an elevation model of 2000 x 2000 posts.

    python -m tools.benchmarks.maps [--plan] [--large MEGABYTES...]

Each line is the least processor time of three runs, beside the same flight with 50 buildings and 40 x 40 posts.
`--plan` also plans both. `--large` instead tells time and memory, of one run each in a process of its own, that `plan`
and `new` take for GeoJSON of that size. The city and its ground are synthetic and written to a temporary folder.
"""

import json
import math
import multiprocessing
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import rasterio

from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.scenario import read_scenario
from ipoa_mission.world.frame import Geodetic, LocalFrame
from tools import command_line

HOME = Geodetic(47.7, 8.25, 500.0)
POST = 1 / 3600  # a second of arc: SRTM's own spacing
BLOCK = 40.0  # distance between the middles of houses [m]
PER_MEGABYTE = 3960  # houses


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--plan", action="store_true", help="also plan the flights")
    parser.add_argument("--large", type=int, nargs="+", metavar="MEGABYTES", help="GeoJSON of these sizes instead")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if wanted.large:
            for size in wanted.large:
                tell_large(folder, size)
            return
        small, city, wide = make(folder, "small", 50, 40), make(folder, "city", 5000, 2000), folder / "wide.toml"
        wide.write_text(
            city.read_text().replace("[bounds]", "[bounds]\neast = [-20000, 20000]\nnorth = [-30000, 30000]")
        )
        full = folder / "full.toml"
        full.write_text(city.read_text().replace("[bounds]", "[bounds]\neast = [-1000, 2000]\nnorth = [-1000, 2000]"))
        print(f"{'':44}{'small':>8}{'city':>8}   ratio")
        tell("read the features of the GeoJSON", lambda path: read_features(path.with_suffix(".geojson")), small, city)
        tell("scenario to airspace, flight of 144 m", lambda path: read_scenario(path).airspace, small, city)
        tell("the same over all posts (40 km x 60 km)", lambda path: read_scenario(path).airspace, small, wide)
        worlds = read_scenario(small).airspace, read_scenario(city).airspace
        print(f"{'obstacles in the airspace':44}{len(worlds[0].obstacles):>8}{len(worlds[1].obstacles):>8}")
        if wanted.plan:
            from ipoa_mission.planning.planner import plan_path

            def plan(path: Path) -> object:
                return plan_path(read_scenario(path), seed=1)

            tell("plan, from file to curve", plan, small, city)
            tell("the same with all 5,000 in the airspace", plan, small, full)


def tell_large(folder: Path, megabytes: int) -> None:
    """Time and memory for a map of so many megabytes, of which a few buildings matter."""
    context = multiprocessing.get_context("spawn")  # a process's peak begins with what its parent has
    with context.Pool(1) as pool:
        path = pool.apply(make, (folder, f"large-{megabytes}", megabytes * PER_MEGABYTE, 40))
    size = path.with_suffix(".geojson").stat().st_size / 1e6
    for act in (read_scenario, plan_it, suggest_it):
        with context.Pool(1) as pool:
            seconds, peak = pool.apply(spent, (act, path))
        print(f"{act.__name__:16}{size:>8.0f} MB{seconds:>8.1f} s{peak:>8.0f} MB")


def spent(act: Callable[[Path], object], path: Path) -> tuple[float, float]:
    """Processor time [s] and the process's peak memory [MB]."""
    begun = time.process_time()
    act(path)
    return time.process_time() - begun, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def plan_it(path: Path) -> None:
    from ipoa_mission import plan_flight

    plan_flight(read_scenario(path), seed=1)


def suggest_it(path: Path) -> None:
    from ipoa_mission.scenario.new import new_scenario, suggest_answers

    buildings = path.with_suffix(".geojson")
    new_scenario(suggest_answers(buildings), path.with_name("new.toml"), buildings)


def tell(words: str, act: Callable[[Path], object], small: Path, city: Path) -> None:
    quick, slow = least(lambda: act(small)), least(lambda: act(city))
    print(f"{words:44}{quick:>7.2f}s{slow:>7.2f}s{slow / quick:>8.1f}")


def least(act: Callable[[], object]) -> float:
    times = []
    for _ in range(3):
        begun = time.process_time()
        act()
        times.append(time.process_time() - begun)
    return min(times)


def make(folder: Path, name: str, buildings: int, posts: int) -> Path:
    """A scenario with its two maps; home stands in a gap among the houses."""
    rows = math.isqrt(buildings - 1) + 1
    rng = np.random.default_rng(0)
    row, column = np.divmod(np.arange(buildings), rows)
    middles = BLOCK * np.column_stack([column - rows // 3 + 0.5, row - rows // 3 + 0.5])
    width, depth = rng.uniform(14, 24, (2, buildings)) / 2
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    rings = middles[:, None, :] + corners * np.stack([width, depth], axis=1)[:, None, :]
    frame = LocalFrame(HOME)
    latitude, longitude, _ = frame.to_geodetic(np.column_stack([rings.reshape(-1, 2), np.zeros(5 * buildings)]))
    degrees = np.column_stack([longitude, latitude]).reshape(buildings, 5, 2).round(7)
    features = [
        {
            "type": "Feature",
            "properties": {"@id": f"way/{i}", "building": "yes", "height": f"{rng.uniform(6, 45):.1f}"},
            "geometry": {"type": "Polygon", "coordinates": [degrees[i].tolist()]},
        }
        for i in range(buildings)
    ]
    (folder / f"{name}.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    rows_of_posts, columns_of_posts = np.mgrid[0:posts, 0:posts] - posts / 2
    heights = 500 + 6 * np.sin(rows_of_posts / 9) * np.cos(columns_of_posts / 7)
    transform = rasterio.Affine(
        POST, 0, HOME.longitude_deg - POST * posts / 2, 0, -POST, HOME.latitude_deg + POST * posts / 2
    )
    options = {"driver": "GTiff", "dtype": "int16", "crs": "EPSG:4326", "transform": transform, "nodata": -32768}
    with rasterio.open(folder / f"{name}.tif", "w", width=posts, height=posts, count=1, **options) as file:
        file.write(heights.astype("int16"), 1)
    path = folder / f"{name}.toml"
    path.write_text(
        f"""
safety_distance = 2.0
home = {{ latitude_deg = {HOME.latitude_deg}, longitude_deg = {HOME.longitude_deg}, altitude_amsl = {HOME.altitude} }}
start = {{ east = 0, north = 0, height_above_ground = 20 }}
goal = {{ east = 120, north = 80, height_above_ground = 20 }}
terrain = {{ kind = "elevation", file = "{name}.tif" }}
maps = [{{ kind = "buildings", file = "{name}.geojson" }}]
[bounds]
margin = 60.0
"""
    )
    return path


if __name__ == "__main__":
    main()
