"""Change maps: each keeps its obstacles, or the reader reports the change."""

import itertools
import random
import tempfile
import warnings
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import MapObstacle, search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.passed import PassedOver, count_passed_over
from ipoa_mission.unread import Unread
from tests.maps.map_scenes import CHANGES, DRIVERS, TEXTS, Row, pack, scene, write

FRAME = LocalFrame(Geodetic(47.0, 8.0, 400.0))
NEAR = 0.06  # rounding of positions and units [m]
SAMPLES = 12  # places checked in each obstacle


class Reading:
    """Hold obstacles and remarks of a file."""

    def __init__(self, path: Path) -> None:
        self.obstacles, self.doubts, self.words = list[MapObstacle](), list[PassedOver](), set[str]()
        self.anywhere = False
        try:
            self._read(path)
        except BadInput as refused:
            self.words.add(f"refused: {str(refused).replace(str(path), '')}")
            self.anywhere = True

    def _read(self, path: Path) -> None:
        if path.suffix == ".kml":
            zones = find_zones(read_features(path), FRAME, path)
            self.obstacles = [MapObstacle(zone.name, zone.shape, 0.0, -1e3, 1e6) for zone in zones.zones]
            self._say(zones.passed_over, zones.unread, zones.remarks)
        else:
            maps = search_buildings(path, BuildingRules(), FRAME)
            self.obstacles = list(maps.obstacles)
            self._say(maps.passed_over, maps.unread, maps.remarks)

    def _say(self, passed: tuple[PassedOver, ...], unread: tuple[Unread, ...], remarks: tuple[str, ...]) -> None:
        self.doubts = [thing for thing in passed if thing.may_be_obstacle]
        self.words = {*remarks, *(each.words() for each in count_passed_over(passed)), *(each.words for each in unread)}
        self.anywhere = any(thing.may_limit for thing in unread)

    def holds(self, place: NDArray[np.float64]) -> bool:
        """Return whether a place, local and above the ground, is in a certain or possible obstacle."""
        point = shapely.Point(place[:2])
        return (
            self.anywhere
            or any(shapely.dwithin(thing.shape, point, NEAR) for thing in self.doubts)
            or any(
                shapely.dwithin(thing.shape, point, thing.reach + NEAR)
                and thing.foot - NEAR <= place[2] <= thing.height + NEAR
                for thing in self.obstacles
            )
        )

    def places(self, chance: random.Random) -> Iterator[NDArray[np.float64]]:
        """Yield places in obstacles, most of them near top and edge."""
        for thing in self.obstacles:
            body = thing.shape.buffer(thing.reach * 0.999) if thing.reach else thing.shape.buffer(-NEAR)
            corners = shapely.get_coordinates(body)
            for _ in range(SAMPLES if len(corners) else 0):
                corner = corners[chance.randrange(len(corners))]
                inside = shapely.get_coordinates(body.representative_point())[0]
                share = chance.choice([1.0, 0.99, chance.random()])
                place = inside + share * (corner - inside)
                if not shapely.dwithin(body, shapely.Point(place), NEAR / 2):
                    continue
                top = min(thing.height, 1e3)
                yield np.array([*place, chance.choice([top - NEAR, chance.uniform(max(thing.foot, 0.0), top)])])


def lost(rows: list[Row], changed: list[Row], path: Path, cut: float | None, chance: random.Random) -> str | None:
    """Return the silent loss by a change; None without one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GDAL's, about names that it cuts
        write(rows, path)
        before = Reading(path)
        write(changed, path)
    if cut is not None:
        data = path.read_bytes()
        part = data[: int(len(data) * cut)]
        if path.suffix == ".geojsonl" and part.rstrip().endswith(b"}}"):
            return None  # whole lines: their loss is not detectable
        path.write_bytes(part)
    after = Reading(path)
    if after.words - before.words:
        return None
    for place in before.places(chance):
        if not after.holds(place):
            return f"{path.suffix} cut {cut}: {place.round(2).tolist()} of {rows} is free in {changed}"
    return None


def tries(count: int, seed: int) -> Iterator[tuple[str, str | None]]:
    """Yield changes and their silent losses, `count` times."""
    chance = random.Random(seed)
    suffixes = [*TEXTS] * 30 + [*DRIVERS]  # a table takes GDAL most of a second
    with tempfile.TemporaryDirectory() as folder:
        tried = 0
        for n in itertools.count():
            if tried >= count:
                return
            suffix = chance.choice(suffixes)
            rows = scene(chance)
            if suffix in (".kml", *DRIVERS):
                rows = [row for row in rows if row[0]["type"] == "Polygon"]
                if suffix == ".kml":
                    rows = [row for row in rows if len(row[0]["coordinates"]) == 1]
            if suffix in (".json", ".osm", ".kml"):
                rows = [row for row in rows if len(row[0]["coordinates"]) == 1 or row[0]["type"] != "Polygon"]
            if not rows:
                continue
            changed, cut = deepcopy(rows), None
            change = chance.choice(CHANGES)
            if change is pack and suffix in (".json", ".osm", ".kml"):
                continue  # their tags are tags
            change(chance.choice(changed), chance)
            keys = [key.lower() for key in {key for _, tags in changed for key in tags}]
            if suffix in DRIVERS and len(set(keys)) < len(keys):
                continue  # a table has one field of a name
            if suffix in (".json", ".osm", ".kml") and not all(
                shape and any(map(bool, tags.values())) for shape, tags in changed
            ):
                continue  # which is no object there
            if suffix in DRIVERS and any("Polygon" not in shape.get("type", "") for shape, _ in changed):
                continue
            name = change.__name__
            if chance.random() < 0.15:
                changed, cut, name = rows, chance.random(), "cut"
            tried += 1
            path = Path(folder) / f"map{n}{suffix}"
            yield f"{name} {suffix}", lost(rows, changed, path, cut, chance)
            for file in Path(folder).glob(f"map{n}.*"):
                file.unlink()
