import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.items import Item, Mission, waypoint
from ipoa_mission.mission.plan_file import parse_plan, plan_text
from tests.refused import refuses

HOME = [47.3977, 8.5456, 488]
AHEAD = {"autoContinue": True, "command": 22, "doJumpId": 1, "frame": 3, "params": [0, 0, 0, None, 0, 0, 50]}
BEHIND = {"autoContinue": True, "command": 20, "doJumpId": 2, "frame": 2, "params": [0] * 7, "type": "SimpleItem"}


def document(*items: dict[str, Any]) -> str:
    mission = {"plannedHomePosition": HOME, "firmwareType": 12, "items": items, "version": 2}
    return json.dumps({"fileType": "Plan", "version": 1, "mission": mission})


def survey() -> dict[str, Any]:
    place = [47.398, 8.546, 40]
    items = [
        {"autoContinue": True, "command": 16, "frame": 3, "params": [0, 0, 0, None, *place], "type": "SimpleItem"},
        {"autoContinue": True, "command": 206, "frame": 2, "params": [9, 0, 1, 0, 0, 0, 0], "type": "SimpleItem"},
    ]
    listed = [item | {"doJumpId": 2 + n} for n, item in enumerate(items)]
    corners = [[47.398, 8.546], [47.3995, 8.5462], [47.3993, 8.549]]
    style = {"CameraShots": 3, "Items": listed, "VisualTransectPoints": corners[:2], "version": 2}
    table = {"angle": 33, "complexItemType": "survey", "polygon": corners, "type": "ComplexItem", "version": 5}
    return table | {"TransectStyleComplexItem": style}


def read(text: str) -> Mission:
    return parse_plan(Path("scan.plan"), text).mission


def written(mission: Mission) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = json.loads(plan_text(mission))["mission"]["items"]
    return items


def test_a_survey_is_written_as_it_was_read() -> None:
    mission = read(document(AHEAD | {"type": "SimpleItem"}, survey(), BEHIND))
    assert [item.command for item in mission.items] == [22, 16, 206, 20]
    assert written(mission)[1] == survey()
    assert repr(read(plan_text(mission)).items) == repr(mission.items)


def test_items_before_a_complex_item_move_its_numbers() -> None:
    mission = read(document(AHEAD | {"type": "SimpleItem"}, survey(), BEHIND))
    more = replace(
        mission, items=(mission.items[0], Item(Command.NAV_DELAY, 2, (5.0, 0.0, 0.0, 0.0)), *mission.items[1:])
    )
    inner = written(more)[2]["TransectStyleComplexItem"]["Items"]
    assert [item["doJumpId"] for item in inner] == [3, 4]


def test_changed_items_are_no_survey_any_more() -> None:
    mission = read(document(AHEAD | {"type": "SimpleItem"}, survey(), BEHIND))
    moved = replace(mission, items=(*mission.items[:1], waypoint(mission.home, 40.0), *mission.items[2:]))
    assert [item["type"] for item in written(moved)] == ["SimpleItem"] * 4
    jump = Item(Command.DO_JUMP, 2, (2.0, 1.0, 0.0, 0.0))
    jumping = replace(mission, items=(*mission.items[:-1], jump, mission.items[-1]))
    assert [item["type"] for item in written(jumping)] == ["SimpleItem"] * 5


SCAN = {"type": "ComplexItem", "complexItemType": "StructureScan", "version": 3, "StructureHeight": 70}


@pytest.mark.parametrize(
    "scan",
    [
        SCAN,
        SCAN | {"Items": []},
        SCAN | {"TransectStyleComplexItem": {"Items": []}},  # QGroundControl #10557: a survey over unknown terrain
    ],
)
def test_a_scan_without_waypoints_is_refused_by_name(scan: dict[str, Any]) -> None:
    with refuses("bad-input", "scan.plan: mission.items[1]", '"StructureScan", but it holds none', kind=BadInput):
        read(document(AHEAD | {"type": "SimpleItem"}, scan))


def test_unknown_complex_items_are_read_and_written_with_their_waypoints() -> None:
    stored = {"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, None, 47.398, 8.546, 30]}
    scan = SCAN | {"Items": [stored | {"autoContinue": True, "doJumpId": 2}]}
    mission = read(document(AHEAD | {"type": "SimpleItem"}, scan, BEHIND))
    assert [item.altitude for item in mission.items] == [50.0, 30.0, 0.0]
    assert written(mission)[1] == scan
    later = replace(mission, items=(mission.items[0], *mission.items))
    assert written(later)[2]["Items"][0]["doJumpId"] == 3
