import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.maps.geozones import may_be_active, periods_of
from ipoa_mission.scenario.scenario_file import read_scenario
from tests.refused import refuses

WEEKEND = {"day": ["SAT", "SUN"], "startTime": "17:00:00.00Z", "endTime": "23:59:59.00Z"}
NIGHT = {"day": ["FRI"], "startTime": "22:00:00+01:00", "endTime": "05:00:00+01:00"}
DUSK = {"day": ["MON"], "startEvent": "SS", "endEvent": "SR"}


def active(period: dict[str, Any], time: str) -> bool:
    then = datetime.fromisoformat(time).replace(tzinfo=UTC).timestamp()
    return may_be_active({"limitedApplicability": json.dumps([period])}, then)


@pytest.mark.parametrize(
    ("period", "time", "expected"),
    [
        ({"startDateTime": "2026-11-22T10:00:00Z"}, "2026-11-22T08:59", False),
        ({"startDateTime": "2026-11-22T10:00:00Z"}, "2026-11-22T09:30", True),  # it begins in the hour of the flight
        ({"endDateTime": "2026-11-22T10:00:00.00+02:00"}, "2026-11-22T08:01", False),
        ({"endDateTime": "2026-11-22T10:00:00.00+02:00"}, "2026-11-22T07:59", True),
        ({"schedule": [WEEKEND]}, "2026-11-22T17:30", True),  # a Sunday
        ({"schedule": [WEEKEND]}, "2026-11-22T15:00", False),
        ({"schedule": [WEEKEND]}, "2026-11-23T17:30", False),
        ({"schedule": [WEEKEND], "endDateTime": "2023-06-15T09:00:00.00Z"}, "2026-11-22T17:30", False),
        ({"schedule": [NIGHT]}, "2026-11-28T03:30", True),  # of Friday night, in UTC until 4 on Saturday
        ({"schedule": [NIGHT]}, "2026-11-28T04:30", False),
        ({"schedule": [NIGHT]}, "2026-11-27T20:30", True),
        ({"schedule": [DUSK]}, "2026-11-23T12:00", True),  # between dawn and dusk: nobody reckons with the sun
        ({"schedule": [DUSK]}, "2026-11-26T12:00", False),
        ({"schedule": [WEEKEND | {"day": ["ANY"]}]}, "2026-11-24T18:00", True),
        ({"startDateTime": "2026"}, "1999-01-01T00:00", True),  # unreadable: at all times
        ({"schedule": [WEEKEND | {"startTime": "17:00"}]}, "2026-11-24T12:00", True),
        ({"endDateTime": "20260101"}, "2026-11-24T12:00", True),  # no seconds since 1970
        ({"endDateTime": 1700000000}, "2026-11-24T12:00", True),
        ({}, "2026-11-24T12:00", True),
    ],
)
def test_a_zone_is_active_at_its_times(period: dict[str, Any], time: str, expected: bool) -> None:
    assert active(period, time) is expected


@pytest.mark.parametrize("text", ["null", "[]", "3", "[3]", '{"a": 1}', "[" * 5000, '[{"schedule": [7]}]'])
def test_text_without_times_is_no_period(text: str) -> None:
    assert periods_of({"limitedApplicability": text}) is None


def scenario(folder: Path, time: str) -> Path:
    zone = {
        "identifier": "LS1",
        "restriction": "PROHIBITED",
        "applicability": [{"permanent": "NO", "schedule": [WEEKEND]}],
        "geometry": [{"horizontalProjection": {"type": "Circle", "center": [8.002, 47.0], "radius": 50}}],
    }
    (folder / "zones.json").write_text(json.dumps({"features": [zone]}))
    (folder / "w.toml").write_text(
        f"{time}\nhome = {{ latitude_deg = 47.0, longitude_deg = 8.0 }}\n"
        "start = { east = 0, north = 0, up = 20 }\ngoal = { east = 300, north = 0, up = 20 }\n"
        "maps = [{ kind = 'no_fly', file = 'zones.json' }]"
    )
    return folder / "w.toml"


@pytest.mark.parametrize(
    ("time", "zones", "remark"),
    [
        ("", 1, "zones.json: LS1: active at times only, kept at all times"),
        ("time = 2026-11-22T18:00:00Z", 1, None),
        ("time = 2026-11-22T10:00:00+01:00", 0, "zones.json: 1 passed over, not active in the hour of the flight: LS1"),
    ],
)
def test_the_time_of_a_flight_says_which_zones_count(tmp_path: Path, time: str, zones: int, remark: str | None) -> None:
    world = read_scenario(scenario(tmp_path, time))
    assert len(world.airspace.obstacles) == zones
    assert [remark for remark in world.remarks if "LS1" in remark] == ([] if remark is None else [remark])


def test_a_copy_for_another_time_has_the_zones_of_that_time(tmp_path: Path) -> None:
    world = read_scenario(scenario(tmp_path, "time = 2026-11-22T09:00:00Z"))
    assert not world.airspace.obstacles
    later = world.model_copy(update={"time": datetime(2026, 11, 22, 18, tzinfo=UTC)})
    assert len(later.airspace.obstacles) == 1


@pytest.mark.parametrize("time", ["time = 2026-11-22T10:00:00", "time = 2026-11-22", "time = 'noon'"])
def test_a_time_without_an_offset_is_refused(tmp_path: Path, time: str) -> None:
    with refuses("bad-input", "time", "2026-11-22T10:00:00Z"):
        read_scenario(scenario(tmp_path, time))
