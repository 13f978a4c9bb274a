import json
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.map_reader import read_features

FRAME = LocalFrame(Geodetic(47.0, 8.0, 500.0))
RING = [[8.002, 47.0], [8.004, 47.0], [8.004, 47.001], [8.002, 47.001], [8.002, 47.0]]
UNITS = {"M": 1.0, "m": 1.0, "FT": 0.3048, "ft": 0.3048, "feet": 0.3048, "FL": None, "LY": None, "": 1.0}
REFERENCES = ["AGL", "AMSL", "agl", "WGS84", "STD", "", "QFE"]
NEAR_KEYS = ["lower", "upper", "lowerLimit", "upperLimit", "lower_limit", "upper_limit", "floor", "ceiling", "uom",
             "lowerReference", "upperReference", "restriction", "type", "zoneType", "note"]  # fmt: skip


def shape(kind: str) -> dict[str, Any]:
    square: dict[str, Any] = {"type": "Polygon", "coordinates": [RING]}
    every: dict[str, dict[str, Any]] = {
        "Polygon": square,
        "MultiPolygon": {"type": "MultiPolygon", "coordinates": [[RING]]},
        "LineString": {"type": "LineString", "coordinates": RING},
        "MultiLineString": {"type": "MultiLineString", "coordinates": [RING]},
        "GeometryCollection": {"type": "GeometryCollection", "geometries": [square]},
    }
    return every[kind]


@st.composite
def zones(draw: st.DrawFn) -> tuple[dict[str, Any], Any]:
    """A file with one zone, and its true limits [m], None for a unit or reference of no schema."""
    lower = draw(st.sampled_from([0, 20, 60]))
    upper = lower + draw(st.sampled_from([30, 100]))
    unit = draw(st.sampled_from([*UNITS]))
    references = draw(st.sampled_from(REFERENCES)), draw(st.sampled_from(REFERENCES))
    restriction = draw(st.sampled_from(["PROHIBITED", "REQ_AUTHORIZATION", "REQ_AUTHORISATION", "USPACE", "forbidden"]))
    form, kind = draw(st.sampled_from(["ed269", "ed318", "flat", "words", "volume"])), draw(st.sampled_from(KINDS))
    layer = {"lower": lower, "upper": upper, "uom": unit, "lowerReference": references[0]}
    layer |= {"upperReference": references[1]}
    volume = {"lowerLimit": lower, "upperLimit": upper, "uomDimensions": unit}
    volume |= {"lowerVerticalReference": references[0], "upperVerticalReference": references[1]}
    about: dict[str, Any] = {"identifier": "Z1"}
    geometry = shape(kind)
    if form == "ed318":
        holder = draw(st.sampled_from([geometry, *geometry.get("geometries", [])]))
        holder["layer"] = layer
        about |= {"type": restriction, "variant": "COMMON"}
    elif form == "flat":
        about |= {"restriction": restriction} | draw(st.sampled_from([layer, volume]))
    elif form == "words":
        words = (f"{value} {unit} {reference}" for value, reference in zip((lower, upper), references, strict=True))
        about |= dict(zip(("lower", "upper"), words, strict=True)) | {"restriction": restriction}
    elif form == "volume":
        about |= {"geometry": volume, "restriction": restriction}
    holders = [each for each in (about, layer, volume) if each]
    for holder in holders:
        keys = [key for key in holder if key not in ("identifier", "geometry")]
        if keys and draw(st.integers(0, 3)) == 0:
            key = draw(st.sampled_from(keys))
            value = holder.pop(key)
            if draw(st.booleans()):
                holder.setdefault(draw(st.sampled_from(NEAR_KEYS)), value)
    if form == "ed269":
        projection = {"type": "Polygon", "coordinates": [RING]}
        zone = about | {"restriction": restriction, "geometry": [volume | {"horizontalProjection": projection}]}
        document: dict[str, Any] = {"title": "zones", "features": [zone]}
    else:
        feature = {"type": "Feature", "properties": about, "geometry": geometry}
        document = {"type": "FeatureCollection", "features": [feature]}
    factor = UNITS[unit]
    return document, tuple(None if factor is None else value * factor for value in (lower, upper))


KINDS = ["Polygon", "MultiPolygon", "LineString", "MultiLineString", "GeometryCollection"]
LONGITUDES, LATITUDES = np.array(RING).T
WHOLE = shapely.Polygon(FRAME.to_local(LATITUDES, LONGITUDES, 500.0)[:, :2])


@given(zones())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_no_spelling_of_a_zone_is_lost_quietly(tmp_path_factory: Any, zone: tuple[dict[str, Any], Any]) -> None:
    document, (lower, upper) = zone
    path = Path(tmp_path_factory.getbasetemp()) / "mutated.json"
    path.write_text(json.dumps(document))
    try:
        found = find_zones(read_features(path), FRAME, path)
    except BadInput:
        return
    if found.unread or found.passed_over:
        return
    assert WHOLE.buffer(-0.1).within(shapely.union_all([each.shape for each in found.zones]))
    for each in found.zones:
        assert "WGS84" not in (getattr(each.lower, "reference", ""), getattr(each.upper, "reference", ""))
        assert each.lower is None or (lower is not None and each.lower.height <= lower + 0.01)
        assert each.upper is None or (upper is not None and each.upper.height >= upper - 0.01)
