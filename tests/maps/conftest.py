import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.geodesy import Geodetic, LocalFrame

WriteMap = Callable[..., Path]


@pytest.fixture
def frame() -> LocalFrame:
    return LocalFrame(Geodetic(47.0, 8.0, 500.0))


@pytest.fixture
def write_map(tmp_path: Path) -> WriteMap:
    def write(*features: tuple[Any, Mapping[str, Any]], **members: Any) -> Path:
        path = tmp_path / "map.geojson"
        rows = [{"type": "Feature", "geometry": shape, "properties": tags} for shape, tags in features]
        path.write_text(json.dumps({"type": "FeatureCollection", "features": rows} | members), encoding="utf-8")
        return path

    return write


@pytest.fixture
def square() -> Callable[..., dict[str, Any]]:
    """Make square footprints whose lower left corner is near (east, north) [m] of 47 N, 8 E."""

    def make(east: float, north: float, side: float = 20.0) -> dict[str, Any]:
        ring = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]
        return {"type": "Polygon", "coordinates": [[degrees(east + side * x, north + side * y) for x, y in ring]]}

    return make


def degrees(east: float, north: float) -> list[float]:
    """Longitude and latitude of a place near 47 N, 8 E, by pymap3d."""
    pymap3d = pytest.importorskip("pymap3d")
    latitude, longitude, _ = pymap3d.enu2geodetic(east, north, 0.0, 47.0, 8.0, 500.0)
    return [float(longitude), float(latitude)]


@pytest.fixture
def at() -> Callable[[float, float], list[float]]:
    """Longitude and latitude of a place near 47 N, 8 E."""
    return degrees
