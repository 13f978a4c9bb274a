"""Surveys and corridor scans without waypoints are laid out; against what QGroundControl wrote, where there is it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.mission.commands import Command, Frame
from ipoa_mission.mission.files import read_mission_file, write_mission
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.world.frame import Geodetic, apart
from ipoa_mission.world.sphere import SphericalPlane

PLANE = SphericalPlane(47.0, 8.0)
SCANS = json.loads((Path(__file__).parent / "files" / "qgroundcontrol_scans.json").read_text())


def places(corners: list[tuple[float, float]]) -> list[list[float]]:
    latitude, longitude = PLANE.to_geodetic(*np.array(corners, float).T)
    return [[float(a), float(b)] for a, b in zip(latitude, longitude, strict=True)]


def style(**changes: Any) -> dict[str, Any]:
    camera = {
        "AdjustedFootprintFrontal": 20,
        "AdjustedFootprintSide": 30,
        "DistanceToSurface": 50,
        "DistanceMode": 1,
    } | changes.pop("camera", {})
    return {"CameraCalc": camera, "TurnAroundDistance": 0, "CameraTriggerInTurnAround": False} | changes


SQUARE = places([(0, 0), (100, 0), (100, 100), (0, 100)])
SURVEY = {"type": "ComplexItem", "complexItemType": "survey", "angle": 0, "entryLocation": 0, "polygon": SQUARE}
CORRIDOR = {
    "type": "ComplexItem",
    "complexItemType": "CorridorScan",
    "CorridorWidth": 60,
    "EntryPoint": 0,
    "polyline": places([(0, 0), (200, 0), (200, 150)]),
}


def read(folder: Path, item: dict[str, Any]) -> MissionFile:
    path = folder / "scan.plan"
    mission = {"plannedHomePosition": [47, 8, 500], "firmwareType": 12, "vehicleType": 2}
    mission |= {"items": [item], "version": 2}
    fence, rally = {"polygons": [], "circles": [], "version": 2}, {"points": [], "version": 2}
    plan = {"fileType": "Plan", "version": 1, "mission": mission, "geoFence": fence, "rallyPoints": rally}
    path.write_text(json.dumps(plan))
    return read_mission_file(path)


def flown(mission: Mission) -> np.ndarray[Any, Any]:
    """East and north of its waypoints, rounded to a decimetre."""
    waypoints = [item for item in mission.items if item.command == Command.NAV_WAYPOINT]
    assert all((item.frame, item.altitude) == (Frame.GLOBAL_RELATIVE_ALT, 50.0) for item in waypoints)
    latitude, longitude = ([getattr(i, key) for i in waypoints] for key in ("latitude_deg", "longitude_deg"))
    return np.round(PLANE.to_plane(np.array(latitude), np.array(longitude)), 1) + 0.0


def test_a_square_is_flown_to_and_fro(tmp_path: Path) -> None:
    """The first line would lie 1050 m west of the middle at 50 m, and every 30 m from there."""
    file = read(tmp_path, SURVEY | {"TransectStyleComplexItem": style()})
    mission = file.mission
    expected = [(20, 0), (20, 100), (50, 100), (50, 0), (80, 0), (80, 100)]
    assert flown(mission).tolist() == [list(map(float, place)) for place in expected]
    commands = [item.command for item in mission.items]
    assert commands == [16, 206, 16, 206] * 3
    assert [item.params[0] for item in mission.items if item.command == 206] == [20, 0] * 3


@pytest.mark.parametrize(
    ("changes", "first", "last"),
    [
        ({"entryLocation": 1}, (80, 0), (20, 100)),
        ({"entryLocation": 2}, (20, 100), (80, 0)),
        ({"entryLocation": 3}, (80, 100), (20, 0)),
        ({"angle": 180}, (20, 0), (80, 100)),  # turned back, so that the order stays
        ({"angle": 90}, (100, 80), (0, 20)),
        ({"flyAlternateTransects": True}, (20, 0), (50, 100)),
    ],
)
def test_entry_and_angle(
    tmp_path: Path, changes: dict[str, Any], first: tuple[float, float], last: tuple[float, float]
) -> None:
    path = flown(read(tmp_path, SURVEY | changes | {"TransectStyleComplexItem": style()}).mission)
    assert path[0].tolist() == list(first)
    assert path[-1].tolist() == list(last)


def test_a_turnaround_is_flown_beyond_the_ends_and_the_camera_works_on(tmp_path: Path) -> None:
    file = read(
        tmp_path,
        SURVEY | {"TransectStyleComplexItem": style(TurnAroundDistance=10, CameraTriggerInTurnAround=True)},
    )
    mission = file.mission
    path = flown(mission)
    assert path[:4].tolist() == [[20, -10], [20, 0], [20, 100], [20, 110]]
    assert path[-1].tolist() == [80, 110]
    commands = "".join("T" if item.command == 206 else "w" for item in mission.items)
    assert commands == "wTwTww" + "wwTww" + "wwTwwT"


def test_too_fine_a_survey_is_one_line_through_the_middle(tmp_path: Path) -> None:
    path = flown(
        read(tmp_path, SURVEY | {"TransectStyleComplexItem": style(camera={"AdjustedFootprintSide": 0.1})}).mission
    )
    assert path.tolist() == [[50, 0], [50, 100]]


def test_a_corridor_keeps_its_distance_round_the_corner(tmp_path: Path) -> None:
    path = flown(read(tmp_path, CORRIDOR | {"TransectStyleComplexItem": style()}).mission)
    left, right = [[0, 15], [185, 15], [185, 150]], [[0, -15], [215, -15], [215, 150]]
    assert path.tolist() == [*left, *right[::-1]]
    other = flown(read(tmp_path, CORRIDOR | {"EntryPoint": 3, "TransectStyleComplexItem": style()}).mission)
    assert other.tolist() == [*right[::-1], *left]


@pytest.mark.parametrize(
    ("item", "told"),
    [
        (SURVEY | {"TransectStyleComplexItem": style(FollowTerrain=True)}, "FollowTerrain: expected false in a scan"),
        (SURVEY | {"TransectStyleComplexItem": style(camera={"DistanceMode": 3})}, "DistanceMode: expected 1 (above"),
        (SURVEY | {"polygon": SQUARE[:2], "TransectStyleComplexItem": style()}, "polygon: expected 3 corners or more"),
        (SURVEY | {"angle": "north", "TransectStyleComplexItem": style()}, "angle: expected degrees"),
        (SURVEY | {"polygon": [[0, 0], [50, 0], [50, 50]], "TransectStyleComplexItem": style()}, "within a degree"),
        (SURVEY | {"polygon": [SQUARE[0]] * 4, "TransectStyleComplexItem": style()}, "a polygon with an area"),
        (
            SURVEY | {"TransectStyleComplexItem": style(TurnAroundDistance=1e308)},
            "TurnAroundDistance: expected metres, 100000 at most, not 1e+308",
        ),
        (CORRIDOR | {"CorridorWidth": 9e4, "TransectStyleComplexItem": style()}, "a corridor of at most 2000"),
        (CORRIDOR | {"polyline": [SQUARE[0]] * 2, "TransectStyleComplexItem": style()}, "whose corners differ"),
        (SURVEY | {"complexItemType": "fwLandingPattern"}, 'the complex item "fwLandingPattern"'),
    ],
)
def test_what_the_geometry_does_not_say_is_refused_with_its_place(
    tmp_path: Path, item: dict[str, Any], told: str
) -> None:
    with pytest.raises(BadInput) as error:
        read(tmp_path, item)
    assert str(error.value).startswith(f"{tmp_path / 'scan.plan'}: mission.items[0]")
    assert told in str(error.value)


def test_it_is_written_as_it_was(tmp_path: Path) -> None:
    file = read(tmp_path, SURVEY | {"TransectStyleComplexItem": style()})
    mission = file.mission
    before = (tmp_path / "scan.plan").read_bytes()
    write_mission(mission, tmp_path / "scan.plan", read_from=file)
    assert (tmp_path / "scan.plan").read_bytes() == before
    assert "3 transects are laid out as QGroundControl does" in str(file.findings[0])


@pytest.mark.parametrize("scan", SCANS, ids=["turnaround", "no_camera", "no_turnaround", "corridor", "far_end"])
def test_it_is_laid_out_as_qgroundcontrol_did(tmp_path: Path, scan: dict[str, Any]) -> None:
    """Scans made in QGroundControl v4.4, and the items that it stored with them: to the millimetre, item by item."""
    items = read(tmp_path, scan["item"]).mission.items
    assert len(items) == len(scan["laid_out"])
    for item, theirs in zip(items, scan["laid_out"], strict=True):
        if isinstance(theirs, list):
            assert item.command == Command.NAV_WAYPOINT
            assert apart(Geodetic(item.latitude_deg, item.longitude_deg), Geodetic(*theirs)) < 1e-3
        else:
            assert (item.command, item.params) == (Command.DO_SET_CAM_TRIGG_DIST, (theirs, 0.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("entry", "turnaround", "always", "expected"),
    [
        (0, 0, False, "wTwwo" + "wTwwo"),
        (2, 0, False, "wowwT" + "wowwT"),
        (2, 0, True, "wwwT" + "wwwT"),
        (3, 10, True, "wTwwwTw" + "wwwwTwo"),
    ],
)
def test_entered_from_the_far_end_a_corridor_has_its_triggers_reversed(
    tmp_path: Path, entry: int, turnaround: float, always: bool, expected: str
) -> None:
    styled = style(TurnAroundDistance=turnaround, CameraTriggerInTurnAround=always)
    file = read(tmp_path, CORRIDOR | {"EntryPoint": entry, "TransectStyleComplexItem": styled})
    mission = file.mission
    words = ["w" if item.command == Command.NAV_WAYPOINT else "T" if item.params[0] else "o" for item in mission.items]
    assert "".join(words) == expected
    assert ("from its far end" in str(file.findings[-1])) == (entry > 1)


def test_mavsdks_survey_is_laid_out_as_qgroundcontrol_wrote_it(samples: Path) -> None:
    folder = samples / "mavlink+MAVSDK/cpp/src/mavsdk/plugins/mission_raw/test_plans"
    whole, bare = (
        read_mission_file(folder / f"qgroundcontrol_sample_with_survey{name}.plan").mission.items
        for name in ("", "_missing_items")
    )
    assert [(a.command, a.frame, a.altitude) for a in whole] == [(b.command, b.frame, b.altitude) for b in bare]
    for a, b in zip(whole, bare, strict=True):
        if a.command == Command.NAV_WAYPOINT:
            there, here = (Geodetic(item.latitude_deg, item.longitude_deg) for item in (a, b))
            assert apart(there, here) < 1e-3
        else:
            assert a.params == pytest.approx(b.params, nan_ok=True)
