"""Compare the shapes of a small map with those that GDAL finds in it. The flight is planned with ours."""

import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import shapely

from ipoa_mission.finding import Finding, Severity
from ipoa_mission.maps.map_reader import GEOJSON, read_features
from ipoa_mission.maps.planar import flat


def differences(path: Path) -> Iterator[Finding]:
    """Yield a warning if GDAL finds other shapes in a map; nothing without GDAL, or where it refuses the file."""
    most = 2 << 20  # bytes, read twice in about a second
    can_be_compared = path.suffix.lower() in (*GEOJSON, ".kml", ".kmz") and path.stat().st_size <= most
    if not can_be_compared or find_spec("pyogrio") is None:
        return
    import pyogrio

    features = read_features(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            layers = [name for name, _ in pyogrio.list_layers(path)]
            shapes = [shape for name in layers for shape in pyogrio.raw.read(path, layer=name, columns=[])[2]]
    except pyogrio.errors.DataSourceError:
        return
    theirs = _parts(shapely.from_wkb([shape for shape in shapes if shape is not None], on_invalid="fix"))
    ours = _parts(feature.shape for feature in features)
    if _counted(ours) == _counted(theirs):
        return
    apart = next((each.name.removeprefix(f"{path}: ") for each in features if _parts([each.shape]) - theirs), None)
    west, south, *_ = next(iter(theirs - ours), ("", (0.0, 0.0)))[1]
    first = f"the first that only GDAL has is at {south:g}, {west:g}" if apart is None else f"GDAL lacks {apart}"
    words = (
        f"{path.name}: two readers differ: {_counted(ours)} by ipoa-mission {metadata.version('ipoa-mission')}, which "
        f"count, {_counted(theirs)} by GDAL {pyogrio.__gdal_version_string__} (pyogrio {pyogrio.__version__}); "
        f"{first}"
    )
    yield Finding("readers-differ", Severity.WARNING, None, words, "look at that shape in the map")


def _parts(shapes: Iterable[Any]) -> Counter[tuple[str, tuple[float, ...]]]:
    """Return the kind and bounds of each part; a closed line and each ring of a polygon are rings."""
    parts = Counter[tuple[str, tuple[float, ...]]]()
    for part in (part for shape in shapes if shape is not None for part in flat(shape) if not part.is_empty):
        rings = [part.exterior, *part.interiors] if part.geom_type == "Polygon" else [part]
        for ring in rings:
            kind = "point" if ring.geom_type == "Point" else "ring" if ring.is_closed else "line"
            parts[kind, tuple(round(side, 6) + 0.0 for side in ring.bounds)] += 1  # to about 0.1 m
    return parts


def _counted(parts: Counter[tuple[str, tuple[float, ...]]]) -> str:
    kinds = Counter[str]()
    for (kind, _), count in parts.items():
        kinds[kind] += count
    return ", ".join(f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in sorted(kinds.items())) or "nothing"
