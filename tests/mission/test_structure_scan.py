import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import SphericalPlane
from ipoa_mission.mission.items import MissionFile
from ipoa_mission.mission.mission_io import read_mission_file, write_mission

HOME = [47.398027, 8.54612, 488.2]
SQUARE = [[47.398, 8.546], [47.398, 8.547], [47.3975, 8.547], [47.3975, 8.546]]
SCAN = {
    "type": "ComplexItem",
    "complexItemType": "StructureScan",
    "version": 3,
    "CameraCalc": {"AdjustedFootprintFrontal": 25, "AdjustedFootprintSide": 20, "DistanceToSurface": 50},
    "EntranceAltitude": 60,
    "GimbalPitch": -10,
    "ScanBottomAlt": 10,
    "StartFromTop": True,
    "StructureHeight": 70,
    "polygon": SQUARE,
}
NOTCH = [[47.39774, 8.546], [47.39775, 8.5469], [47.39776, 8.546]]
PLANE = SphericalPlane(*HOME[:2])


def read(tmp_path: Path, **changes: Any) -> MissionFile:
    plan = {
        "fileType": "Plan",
        "version": 1,
        "mission": {"version": 2, "firmwareType": 12, "plannedHomePosition": HOME, "items": [SCAN | changes]},
    }
    path = tmp_path / "scan.plan"
    path.write_text(json.dumps(plan))
    return read_mission_file(path)


def plane(places: list[list[float]]) -> shapely.Polygon:
    latitude, longitude = np.array(places).T
    return shapely.Polygon(PLANE.to_plane(latitude, longitude))


@pytest.mark.parametrize(
    ("corners", "tops"),
    [
        (SQUARE, True),
        (SQUARE[::-1], True),
        (SQUARE, False),
        ([[47.398, 8.546], [47.3982, 8.5475], [47.397, 8.5465]], True),
    ],
)
def test_a_round_a_layer_runs_beside_the_structure(corners: list[list[float]], tops: bool, tmp_path: Path) -> None:
    file = read(tmp_path, polygon=corners, StartFromTop=tops)
    mission = file.mission
    flown = [item for item in mission.items if item.command == Command.NAV_WAYPOINT]
    count = len(corners) + 1
    assert [item.altitude for item in (flown[0], flown[-1])] == [60.0, 60.0]
    heights = [57.5, 32.5, 7.5] if tops else [22.5, 47.5, 72.5]  # layers of 25 m from half a layer on
    assert [item.altitude for item in flown[1:-1]] == [height for height in heights for _ in range(count)]
    assert {item.frame for item in flown} == {Frame.GLOBAL_RELATIVE_ALT}
    ring = [[item.latitude_deg, item.longitude_deg] for item in flown[1 : 1 + count]]
    assert ring[0] == ring[-1] == [flown[0].latitude_deg, flown[0].longitude_deg]
    structure, ring_path = plane(corners), plane(ring)
    assert not ring_path.exterior.is_ccw
    assert ring_path.exterior.distance(structure) == pytest.approx(50.0, abs=1e-3)
    for a, b in zip(structure.exterior.coords, structure.exterior.coords[1:], strict=False):
        middle = shapely.LineString([a, b]).interpolate(0.5, normalized=True)
        assert middle.distance(ring_path.exterior) == pytest.approx(50.0, abs=1e-3)
    others = [(item.command, *item.params) for item in mission.items if item.command != Command.NAV_WAYPOINT]
    trigger = Command.DO_SET_CAM_TRIGG_DIST
    rounds = [(trigger, 20.0, 0.0, 1.0, 0.0), (trigger, 0.0, 0.0, 0.0, 0.0)] * 3
    none = (0.0, 0.0, 0.0, 0.0)
    assert others == [(Command.DO_SET_ROI_WPNEXT_OFFSET, *none), *rounds, (Command.DO_SET_ROI_NONE, *none)]
    aim = mission.items[1]
    assert (aim.latitude_deg, aim.longitude_deg, aim.altitude) == (-10.0, 0.0, 90.0)
    assert "3 rounds are laid out" in file.findings[0].message


def test_stored_items_go_before_the_geometry_and_the_file_is_kept(tmp_path: Path) -> None:
    stored = {"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, None, 47.398, 8.546, 30]}
    file = read(tmp_path, Items=[stored | {"autoContinue": True}])
    mission = file.mission
    assert [item.altitude for item in mission.items] == [30.0]
    again = tmp_path / "again.plan"
    file = read(tmp_path)
    write_mission(file.mission, again, read_from=file)
    assert again.read_bytes() == (tmp_path / "scan.plan").read_bytes()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"CameraCalc": SCAN["CameraCalc"] | {"AdjustedFootprintFrontal": 0}}, "expected more than 0 m"),  # type: ignore[operator]
        ({"StructureHeight": 1e308}, "StructureHeight: expected meters, 100000 at most, not 1e+308"),
        ({"StructureHeight": 9e4}, "expected a structure of at most 200 layers"),
        ({"polygon": SQUARE[:2]}, "expected 3 corners or more"),
        ({"polygon": [SQUARE[0]] * 4}, "expected a polygon with an area"),
        ({"polygon": [*SQUARE, *NOTCH]}, "expected a round with room for each side at 50 m from the structure"),
        ({"EntranceAltitude": None}, "EntranceAltitude: expected meters"),
    ],
)
def test_a_geometry_that_says_too_little_is_refused_by_name(
    changes: dict[str, Any], words: str, tmp_path: Path
) -> None:
    with pytest.raises(BadInput) as refused:
        read(tmp_path, **changes)
    assert str(refused.value).startswith(f"{tmp_path / 'scan.plan'}: mission.items[0]")
    assert words in str(refused.value)
