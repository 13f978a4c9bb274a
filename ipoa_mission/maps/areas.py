"""Polygons of a map as zones to keep out of, or as the one area to stay in."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature, Mistakes
from ipoa_mission.maps.planar import polygons_of, to_plane
from ipoa_mission.world.frame import LocalFrame


@dataclass(frozen=True)
class Zone:
    """A valid polygon in the local plane, east, north [m], and what it is called."""

    name: str
    shape: Any


def find_zones(features: Sequence[Feature], frame: LocalFrame, path: Path) -> tuple[tuple[Zone, ...], tuple[str, ...]]:
    """Every polygon among the features, and remarks on what was mended or passed over.

    Raises:
        BadInput: naming file and place of a polygon without an area, or that there is none.
    """
    shapes = to_plane([f.shape for f in features], [f.place for f in features], frame)
    mistakes, zones, remarks, others = Mistakes(), [], [], 0
    for feature, shape in zip(features, shapes, strict=True):
        parts = [part for part in _flat(shape) if part.geom_type == "Polygon"]
        others += not parts
        for part in parts:
            found = mistakes.attempt(polygons_of, part, feature.place)
            if found is not None:
                zones += [Zone(feature.name, polygon) for polygon in found[0]]
                remarks += [f"{feature.name}: mended ({found[1]})"] if found[1] else []
    mistakes.tell()
    if not zones:
        raise BadInput(f"{path}: expected a polygon, but there is none among {len(features)} features")
    if others:
        remarks.append(f"{others} features without a polygon passed over")
    return tuple(zones), tuple(remarks)


def join_zones(zones: Sequence[Zone], path: Path) -> Any:
    """The one polygon that all zones make together.

    Raises:
        BadInput: they do not touch.
    """
    whole = shapely.union_all([zone.shape for zone in zones])
    if whole.geom_type != "Polygon":
        raise BadInput(f"{path}: expected one flight area, but there are {len(whole.geoms)} that do not touch")
    return whole


def _flat(shape: Any) -> list[Any]:
    """The simple shapes of a collection, however deep."""
    return [part for piece in shape.geoms for part in _flat(piece)] if hasattr(shape, "geoms") else [shape]
