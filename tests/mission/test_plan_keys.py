import json
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.mission.mission_io import read_mission, read_mission_file
from tests.refused import refuses

ITEM = {"type": "SimpleItem", "command": 16, "frame": 3, "autoContinue": True, "params": [0, 0, 0, None, 47, 8, 30]}
SQUARE = {"polygon": [[46.9, 7.9], [46.9, 8.1], [47.1, 8.1], [47.1, 7.9]], "inclusion": True, "version": 1}
CIRCLE = {"circle": {"center": [47, 8], "radius": 500}, "inclusion": True, "version": 1}


def written(folder: Path, **changes: Any) -> Path:
    plan = {
        "fileType": "Plan",
        "geoFence": {"polygons": [SQUARE], "circles": [CIRCLE], "version": 2},
        "mission": {
            "firmwareType": 12,
            "items": [ITEM | {"doJumpId": 1}, ITEM | {"doJumpId": 2}],
            "plannedHomePosition": [47, 8, 400],
            "vehicleType": 2,
            "version": 2,
        },
        "rallyPoints": {"points": [[47, 8, 20]], "version": 2},
        "version": 1,
    }
    for key, value in changes.items():
        *keys, last = key.split("__")
        inner = plan
        for step in keys:
            inner = inner[step]  # type: ignore[assignment]
        inner.pop(last, None) if value is None else inner.update({last: value})
    path = folder / "a.plan"
    path.write_text(json.dumps(plan))
    return path


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"geoFence": None, "geofence": {"polygons": [SQUARE]}}, 'not read: key "geofence": the file'),
        ({"rallyPoints": None, "Alternates": [[47, 8, 9]]}, 'not read: key "Alternates": the file'),
        ({"noFlyZones": [SQUARE]}, 'not read: key "noFlyZones": the file'),
        ({"geoFence__polygon": [[47, 8], [47.1, 8], [47, 8.1]]}, 'not read: key "polygon": geoFence'),
        ({"geoFence__maxAltitude": 50}, 'not read: key "maxAltitude": geoFence ("50")'),
        ({"geoFence__circles": [CIRCLE | {"unit": "ft"}]}, 'not read: key "unit": geoFence.circles[0]'),
        ({"rallyPoints__position": [[47, 8, 9]]}, 'not read: key "position": rallyPoints'),
    ],
)
def test_a_limit_that_is_not_read_is_an_error(tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    path = written(tmp_path, **changes)
    assert next(str(each)[7:] for each in read_mission_file(path).findings if each.code == "not-read").startswith(words)
    with refuses("not-read", path.name, kind=BadInput):
        read_mission(path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, []),
        ({"geoFence": None}, ["geoFence: missing: taken as a mission without a fence"]),
        ({"rallyPoints": {}}, ["rallyPoints.points: missing: taken as a mission without rally points"]),
        ({"mission__vehicleType": None}, ["mission.vehicleType: missing: taken as a multicopter"]),
        ({"mission__hoverspeed": 5}, ['not read: key "hoverspeed": mission ("5")']),
        ({"mission__items": [ITEM | {"altitude": 9}] * 2},
         ['not read: key "altitude": 2 times, first mission.items[0] ("9")']),
        ({"mission__items": [ITEM | {"doJumpId": n} for n in (1, 3)]},
         ["item 2 has doJumpId 3: an item may be missing or moved"]),
    ],
)  # fmt: skip
def test_other_keys_are_warnings(tmp_path: Path, changes: dict[str, Any], words: list[str]) -> None:
    read = read_mission_file(written(tmp_path, **changes))
    assert [str(finding) for finding in read.findings] == [f"warning: {word}" for word in words]


def test_a_key_that_stands_twice_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_text(path.read_text().replace('"radius": 500', '"radius": 500, "radius": 50'))
    with refuses("wrong-format", path.name, '"radius"'):
        read_mission(path)


def test_a_jump_to_two_items_of_one_number_is_refused(tmp_path: Path) -> None:
    jump = ITEM | {"command": 177, "frame": 2, "params": [1, 2, 0, 0, 0, 0, 0], "doJumpId": 3}
    path = written(tmp_path, mission__items=[ITEM | {"doJumpId": 1}, ITEM | {"doJumpId": 1}, jump])
    with refuses("bad-input", "items[2].params[0]"):
        read_mission(path)


@pytest.mark.parametrize(
    ("frame", "severity", "words"),
    [
        (0, "error", "expected home's altitude, which altitudes AMSL need: item 2"),
        (5, "error", "expected home's altitude, which altitudes AMSL need: item 2"),
        (3, "warning", "home has no altitude: taken as 0 m AMSL, which heights above home do not depend on"),
    ],
)
def test_heights_above_home_are_unknown_without_its_altitude(
    tmp_path: Path, frame: int, severity: str, words: str
) -> None:
    items = [ITEM | {"doJumpId": 1}, ITEM | {"doJumpId": 2, "frame": frame}]
    path = written(tmp_path, mission__plannedHomePosition=[47, 8, None], mission__items=items)
    (finding,) = read_mission_file(path).findings
    assert (str(finding.severity), finding.message) == (severity, f"mission.plannedHomePosition[2]: {words}")


def test_a_home_of_another_frame_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.waypoints"
    path.write_text("QGC WPL 110\n0\t1\t3\t16\t0\t0\t0\t0\t47\t8\t400\t1\n1\t0\t3\t16\t0\t0\t0\t0\t47\t8\t30\t1\n")
    (finding,) = read_mission_file(path).findings
    assert finding.message == "home: its altitude is taken as AMSL, but its frame is 3, not 0"
