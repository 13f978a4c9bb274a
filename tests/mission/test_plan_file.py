import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot import autopilot as autopilots
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Severity
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import ComplexItem, FenceCircle, FencePolygon, Item, Mission, land, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission, read_mission_file, write_files, write_mission
from ipoa_mission.mission.parameter_file import read_parameter_file
from ipoa_mission.mission.plan_file import plan_text
from tests.mission_strategies import any_missions, missions, same
from tests.refused import refuses

FILES = Path(__file__).parent / "files"
HOME = Geodetic(39.101, 121.82, 20.0)
ERROR, WARNING = Severity.ERROR, Severity.WARNING
MISSION = Mission(HOME, (takeoff(HOME, 10.0), waypoint(HOME, 12.0)))


def written(mission: Mission, folder: Path) -> dict[str, Any]:
    path = folder / "written.plan"
    write_mission(mission, path)
    return json.loads(path.read_text())


@given(mission=missions())
def test_written_mission_is_read_back_the_same(mission: Mission, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "round.plan"
    write_mission(mission, path)
    assert same(read_mission_file(path).mission, mission)


@given(mission=missions())
def test_written_plans_keep_the_rules_of_qgroundcontrol_s_loader(mission: Mission, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "rules.plan"
    write_mission(mission, path)
    text = path.read_text()
    plan = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert (plan["fileType"], plan["groundStation"]) == ("Plan", "QGroundControl")
    assert plan["version"] == 1
    assert type(plan["version"]) is int
    header, fence, rally = plan["mission"], plan["geoFence"], plan["rallyPoints"]
    assert (header["version"], fence["version"], rally["version"]) == (2, 2, 2)
    assert header["firmwareType"] == {"ardupilot": 3, "px4": 12}[mission.autopilot.name]
    assert header["vehicleType"] == 2
    assert [type(v) in (int, float) for v in header["plannedHomePosition"]] == [True] * 3
    assert {type(circle["inclusion"]) for circle in fence["circles"]} <= {bool}
    assert all(part["version"] == 1 for part in (*fence["circles"], *fence["polygons"]))
    assert all(len(point) == 3 for point in rally["points"])
    for number, item in enumerate(header["items"], start=1):
        assert item["type"] == "SimpleItem"
        assert (type(item["command"]), type(item["frame"]), type(item["autoContinue"])) == (int, int, bool)
        assert item["doJumpId"] == number
        assert len(item["params"]) == 7
        assert all(p is None or type(p) in (int, float) for p in item["params"])
        keys = {"AltitudeMode", "Altitude", "AMSLAltAboveTerrain"} & set(item)
        assert len(keys) in (0, 3), "all or none"
        assert bool(keys) == (item["frame"] in (0, 3, 10))
        if keys:
            assert item["AltitudeMode"] == {3: 1, 0: 2, 10: 4}[item["frame"]]
            assert item["Altitude"] == item["params"][6]
            assert item["Altitude"] is not None


def test_the_same_mission_gives_the_same_bytes(tmp_path: Path) -> None:
    mission = read_mission_file(FILES / "survey.plan").mission
    first, second = tmp_path / "one.plan", tmp_path / "other.plan"
    write_mission(mission, first)
    write_mission(mission, second)
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().endswith(b"}\n")
    assert b"\r" not in first.read_bytes()


@pytest.mark.parametrize(("frames", "mode"), [((3, 3), 1), ((0, 0), 2), ((10, 10), 4), ((0, 3), 0), ((), 1)])
def test_the_altitude_mode_of_the_plan_is_that_of_its_items_or_mixed(
    frames: tuple[int, ...], mode: int, tmp_path: Path
) -> None:
    items = tuple(Item(16, frame, altitude=30.0) for frame in frames)
    assert written(Mission(HOME, items), tmp_path)["mission"]["globalPlanAltitudeMode"] == mode


def test_a_speed_is_shown_in_the_header_only_if_there_is_one(tmp_path: Path) -> None:
    assert written(Mission(HOME, (), cruise_speed=12.5), tmp_path)["mission"]["hoverSpeed"] == 12.5
    assert "hoverSpeed" not in written(Mission(HOME, ()), tmp_path)["mission"]


@pytest.mark.parametrize("speed", [0, -5])
def test_a_speed_that_nobody_can_fly_is_named_and_ignored(speed: float, tmp_path: Path) -> None:
    plan = written(replace(MISSION, cruise_speed=5.0), tmp_path)
    plan["mission"]["hoverSpeed"] = speed
    (tmp_path / "slow.plan").write_text(json.dumps(plan))
    file = read_mission_file(tmp_path / "slow.plan")
    assert file.mission.cruise_speed is None
    words = f"warning: mission.hoverSpeed: expected a speed above zero, not {speed}: ignored"
    assert [str(finding) for finding in file.findings] == [words]


def test_an_altitude_that_is_no_number_is_not_written(tmp_path: Path) -> None:
    mission = Mission(HOME, (takeoff(HOME, 10.0), waypoint(HOME, math.nan)))
    with refuses("altitude-missing", "item 2 (NAV_WAYPOINT)", kind=BadInput):
        write_mission(mission, tmp_path / "no.plan")
    assert not list(tmp_path.iterdir())


NOT_FINITE = {
    "fence[0]: radius": {"fence": (FenceCircle((39.1, 121.8), math.inf),)},
    "fence[0]: center": {"fence": (FenceCircle((39.1, math.nan), 50.0),)},
    "fence[0]: vertices[1]": {"fence": (FencePolygon(((39.1, 121.8), (math.nan, 121.8), (39.2, 121.9))),)},
    "cruise_speed": {"cruise_speed": math.inf},
    "item 1 (NAV_WAYPOINT): param1": {"items": (waypoint(HOME, 12.0, hold_s=-math.inf),)},
    "item 1 (NAV_WAYPOINT): longitude": {"items": (replace(MISSION.items[1], longitude_deg=math.inf),)},
    "item 1 (DO_DIGICAM_CONTROL): altitude": {"items": (Item(203, 2, altitude=math.inf),)},
    "no.params: MPC_XY_CRUISE": {"parameters": {"MPC_XY_CRUISE": math.inf}},
    "landing_ground": {"items": (*MISSION.items, land(HOME)), "landing_ground": replace(HOME, altitude=math.nan)},
    "complex item at item 1": {"complex_items": (ComplexItem(MISSION.items, '{"camera": Infinity}'),)},
}


@pytest.mark.parametrize("place", NOT_FINITE)
def test_only_nan_of_an_item_is_written_as_null(place: str, tmp_path: Path) -> None:
    fields: Any = NOT_FINITE[place]
    with refuses("bad-input", place, kind=BadInput):
        write_mission(replace(MISSION, **fields), tmp_path / "no.plan")
    assert not list(tmp_path.iterdir())


TRIANGLE = ((39.1, 121.8), (39.1, 121.9), (39.2, 121.9))
REFUSED = {
    "geoFence.circles[0].circle.radius": {"fence": (FenceCircle((39.1, 121.8), -5.0),)},
    "geoFence.circles[0].circle.center[1]": {"fence": (FenceCircle((39.1, 181.0), 5.0),)},
    "geoFence.polygons[0].polygon": {"fence": (FencePolygon(TRIANGLE[:2]),)},
    "geoFence.polygons[0].polygon[0][0]": {"fence": (FencePolygon(((200.0, 121.8), *TRIANGLE)),)},
    "mission.items[1].params[4]": {"items": (MISSION.items[0], replace(MISSION.items[1], latitude_deg=200.0))},
    "mission.items[0].command": {"items": (Item(70_000, 2),)},
    "mission.items[0].frame": {"items": (Item(16, 300),)},
    "mission.plannedHomePosition[0]": {"home": replace(HOME, latitude_deg=200.0)},
    "mission.vehicleType": {"vehicle_type": 256},
    "rallyPoints.points[0][1]": {"rally": (replace(HOME, longitude_deg=470.0),)},
}


@pytest.mark.parametrize("place", REFUSED)
def test_what_read_mission_refuses_is_not_written(place: str, tmp_path: Path) -> None:
    fields: Any = REFUSED[place]
    mission = replace(MISSION, **fields)
    with refuses("bad-input", f"no.plan: {place}", kind=BadInput):
        write_mission(mission, tmp_path / "no.plan")
    with refuses("bad-input", f"no.plan: {place}", kind=BadInput):
        write_files([("no", mission, {})], tmp_path)
    assert not list(tmp_path.iterdir())


@given(mission=any_missions(), suffix=st.sampled_from([".plan", ".waypoints"]))
def test_a_mission_is_written_readable_or_not_at_all(mission: Mission, suffix: str, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / f"any{suffix}"
    path.unlink(missing_ok=True)
    try:
        write_mission(mission, path)
    except BadInput:
        assert not path.exists()
        return
    read = read_mission(path, mission.autopilot)
    assert len(read.items) == len(mission.items)
    if suffix == ".plan":
        assert (len(read.fence), len(read.rally)) == (len(mission.fence), len(mission.rally))


def test_a_jump_to_nowhere_is_not_written(tmp_path: Path) -> None:
    mission = Mission(HOME, (takeoff(HOME, 10.0), Item(177, 2, (3.0, 1.0, 0.0, 0.0))))
    with refuses("jump-target", "item 2 (DO_JUMP): param1", kind=BadInput):
        write_mission(mission, tmp_path / "no.plan")


def test_a_survey_becomes_its_waypoints() -> None:
    mission = read_mission_file(FILES / "survey.plan").mission
    assert [item.command for item in mission.items] == [22, 530, 16, 206, 16, 206, 16, 206, 16, 206, 177, 20]
    assert mission.autopilot is Autopilot.PX4
    assert mission.home == Geodetic(47.3977419, 8.545594, 488.2)
    assert mission.cruise_speed == 5.0
    assert all(item.frame == (3 if item.command in (16, 22) else 2) for item in mission.items)
    assert [item.altitude for item in mission.items if item.command == 16] == [50.0] * 4


def test_a_jump_refers_to_a_do_jump_id_and_not_to_a_place_in_the_list() -> None:
    jump = read_mission_file(FILES / "survey.plan").mission.items[10]
    assert jump.params[:2] == (12.0, 1.0), "doJumpId 21 is the twelfth item"


def test_a_jump_into_a_survey_is_refused_as_qgroundcontrol_refuses_it(tmp_path: Path) -> None:
    plan = json.loads((FILES / "survey.plan").read_text())
    plan["mission"]["items"][2]["params"][0] = 12  # of an item inside the survey
    path = tmp_path / "into.plan"
    path.write_text(json.dumps(plan))
    with refuses("bad-input", "into.plan: mission.items[2].params[0]"):
        read_mission_file(path)


def test_fence_and_rally_points_are_read() -> None:
    mission = read_mission_file(FILES / "survey.plan").mission
    polygon, keep_in, keep_out = mission.fence
    assert isinstance(polygon, FencePolygon)
    assert (len(polygon.vertices), polygon.inclusion) == (4, True)
    assert keep_in == FenceCircle((47.3985, 8.5465), 400.0, True)
    assert keep_out == FenceCircle((47.39901, 8.54712), 25.5, False)
    assert mission.rally == (Geodetic(47.3979, 8.5448, 40.0), Geodetic(47.3971, 8.5471, 35.0))


def test_mavsdk_reads_the_survey_as_we_do(mavsdk: Any) -> None:
    path = FILES / "survey.plan"
    mission = read_mission_file(path).mission
    assert len(mission.items) == 12
    theirs = mavsdk.read(path.read_text(), "plan", Autopilot.PX4)
    assert [row[2] for row in theirs["mission"]] == [item.command for item in mission.items]
    assert [row[9:11] for row in theirs["mission"] if row[1] == 3] == [
        [round(item.latitude_deg * 1e7), round(item.longitude_deg * 1e7)] for item in mission.items if item.frame == 3
    ]


def test_a_corridor_scan_on_ardupilot_is_read() -> None:
    mission = read_mission_file(FILES / "corridor.plan").mission
    assert mission.autopilot is Autopilot.ARDUPILOT
    assert [item.command for item in mission.items] == [22, 16, 206, 16, 16, 206, 21]
    assert [item.frame for item in mission.items] == [3, 10, 2, 10, 10, 2, 3]


def test_the_autopilot_that_is_asked_for_goes_before_that_of_the_file() -> None:
    assert read_mission_file(FILES / "corridor.plan", Autopilot.PX4).mission.autopilot is Autopilot.PX4


def test_keys_that_other_programs_omit_are_not_needed(tmp_path: Path) -> None:
    plan = written(Mission(HOME, (takeoff(HOME, 10.0), waypoint(HOME, 10.0))), tmp_path)
    del plan["groundStation"], plan["geoFence"], plan["rallyPoints"], plan["mission"]["version"]
    for item in plan["mission"]["items"]:
        del item["AltitudeMode"], item["Altitude"], item["AMSLAltAboveTerrain"], item["doJumpId"]
    path = tmp_path / "sparse.plan"
    path.write_text(json.dumps(plan))
    assert len(read_mission_file(path).mission.items) == 2
    path.write_text(json.dumps(plan | {"geoFence": {}, "rallyPoints": {}, "somethingElse": [1, 2]}))
    assert same(read_mission_file(path).mission, replace(read_mission_file(path).mission, fence=(), rally=()))


def test_a_take_off_without_a_position_is_one_from_here(tmp_path: Path) -> None:
    plan = written(Mission(HOME, (takeoff(HOME, 10.0),)), tmp_path)
    plan["mission"]["items"][0]["params"][4:6] = [None, None]
    path = tmp_path / "here.plan"
    path.write_text(json.dumps(plan))
    (item,) = read_mission_file(path).mission.items
    assert (item.latitude_deg, item.longitude_deg, item.has_position) == (0.0, 0.0, False)


def test_a_return_point_of_the_fence_is_reported_as_not_kept(tmp_path: Path) -> None:
    plan = written(Mission(HOME, ()), tmp_path)
    plan["geoFence"]["breachReturn"] = [39.1, 121.8, 50]
    path = tmp_path / "breach.plan"
    path.write_text(json.dumps(plan))
    assert [str(f) for f in read_mission_file(path).findings] == [
        "warning: geoFence.breachReturn: the return point is dropped"
    ]


def test_a_home_without_an_altitude_is_not_written(tmp_path: Path) -> None:
    with refuses("altitude-missing", "home", kind=BadInput):
        write_mission(Mission(Geodetic(39.1, 121.8, math.nan), ()), tmp_path / "no.plan")


def test_a_plan_selects_its_autopilot_by_firmware_and_vehicle_class(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    class Plane(type(Autopilot.ARDUPILOT)):  # type: ignore[misc]
        name, mav_types = "plane", frozenset({1})

    plane = Plane()
    path = tmp_path / "wings.plan"
    path.write_text(plan_text(replace(MISSION, autopilot=Autopilot.ARDUPILOT, vehicle_type=1)))
    assert (
        read_mission_file(path).mission.autopilot is Autopilot.ARDUPILOT
    )  # its firmware's, where none is known for planes
    monkeypatch.setitem(autopilots._registered(), plane.name, plane)
    assert read_mission_file(str(path)).mission.autopilot is plane
    path.write_text(plan_text(replace(MISSION, autopilot=Autopilot.ARDUPILOT)))
    assert read_mission_file(path).mission.autopilot is Autopilot.ARDUPILOT


def test_each_format_is_read_by_a_path_or_its_name(tmp_path: Path) -> None:
    path = tmp_path / "hop.plan"
    mission = replace(MISSION, parameters={"MPC_XY_CRUISE": 8.0})
    write_mission(mission, path)
    write_mission(mission, path.with_suffix(".waypoints"))
    assert same(read_mission_file(str(path)).mission, read_mission_file(path).mission)
    waypoints = path.with_suffix(".waypoints")
    assert same(read_mission_file(str(waypoints)).mission, read_mission_file(waypoints).mission)
    parameters = path.with_suffix(".params")
    assert (
        read_parameter_file(str(parameters)).parameters
        == read_parameter_file(parameters).parameters
        == {"MPC_XY_CRUISE": 8.0}
    )


ALTITUDE = "Altitude: QGroundControl flies 30 m, other software params[6], which is 40"
BY_TERRAIN = "AMSLAltAboveTerrain: QGroundControl flies 95 m, other software params[6], which is 30"
BY_FRAME = "AltitudeMode: QGroundControl flies in frame {}, other software in the item's frame {}"
WITHOUT = (
    "AltitudeMode: without an AMSLAltAboveTerrain, QGroundControl flies above its own terrain, "
    "other software at params[6] AMSL"
)


@pytest.mark.parametrize(
    ("mode", "frame", "heights", "expected"),
    [  # Altitude, AMSLAltAboveTerrain, params[6]
        (1, 3, (30, None, 30), []),
        (1, 6, (30, None, 30), []),
        (2, 0, (518, None, 518), []),
        (3, 0, (30, 518, 518), []),
        (4, 10, (30, None, 30), []),
        (0, 3, (30, None, 30), []),
        (1, 3, (30, None, 40), [ALTITUDE]),
        (2, 0, (30, None, 40), [ALTITUDE]),
        (3, 0, (30, 95, 30), [BY_TERRAIN]),
        (4, 10, (30, None, 40), [ALTITUDE]),
        (1, 0, (30, None, 30), [BY_FRAME.format(3, 0)]),
        (2, 3, (30, None, 30), [BY_FRAME.format(0, 3)]),
        (3, 3, (30, 30, 30), [BY_FRAME.format(0, 3)]),
        (4, 3, (30, None, 30), [BY_FRAME.format(10, 3)]),
        (3, 0, (30, None, 518), [WITHOUT]),
    ],
)
def test_each_altitude_mode_is_held_against_frame_and_params(
    tmp_path: Path, mode: int, frame: int, heights: tuple[float | None, ...], expected: list[str]
) -> None:
    plan = written(MISSION, tmp_path)
    item = plan["mission"]["items"][1]
    item |= {"AltitudeMode": mode, "frame": frame, "Altitude": heights[0], "AMSLAltAboveTerrain": heights[1]}
    item["params"][6] = heights[2]
    (tmp_path / "changed.plan").write_text(json.dumps(plan))
    findings = read_mission_file(tmp_path / "changed.plan").findings
    assert [finding.message for finding in findings] == [f"mission.items[1].{words}" for words in expected]
    assert [finding.severity for finding in findings] == [WARNING if words == WITHOUT else ERROR for words in expected]
    item["AltitudeMode"] = 9
    (tmp_path / "changed.plan").write_text(json.dumps(plan))
    with refuses("bad-input", "changed.plan: mission.items[1].AltitudeMode"):
        read_mission_file(tmp_path / "changed.plan")


def test_a_file_keeps_its_permissions_when_it_is_written_again(tmp_path: Path) -> None:
    path = tmp_path / "flight.plan"
    mission = Mission(HOME, (takeoff(HOME, 10.0), land(HOME)))
    write_mission(mission, path)
    path.chmod(0o600)
    write_mission(replace(mission, cruise_speed=4.0), path)
    assert path.stat().st_mode & 0o777 == 0o600
