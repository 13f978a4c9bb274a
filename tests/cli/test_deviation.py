import json
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission import Forecast, read_mission
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import NotModeled
from ipoa_mission.flight import procedure
from ipoa_mission.forecast.conformance import ConformanceMonitor
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.geodesy import Geodetic
from tests.cli.conftest import Run, Serve
from tests.cli.test_surveying import SCENARIO

SITL = Path(__file__).parents[2] / "missions" / "sitl.plan"
MISSION = read_mission(SITL)


@pytest.fixture
def lower(monkeypatch: pytest.MonkeyPatch) -> None:
    """The flight is compared with the forecast of one that is half as high."""
    half = replace(MISSION, items=tuple(replace(item, altitude=item.altitude / 2) for item in MISSION.items))
    monitor = ConformanceMonitor(Forecast(half))
    monkeypatch.setattr(procedure, "_monitor", lambda *_: monitor)


@pytest.mark.usefixtures("lower")
def test_cli_deviation_is_a_json_line_with_next_steps(run: Run, autopilot: Serve) -> None:
    with autopilot(MISSION.home, speedup=8.0) as link:
        ended = run(f"fly {SITL} --link {link} --json")
    assert ended.code == 1
    event, result = map(json.loads, ended.out.splitlines())
    assert event.pop("event") == "deviation"
    assert (event["kind"], event["unit"], event["found"] > event["allowed"]) == ("left-corridor", "m", True)
    assert result["deviations"] == [event]
    assert (result["completed"], result["armed"], result["in_air"]) == (False, True, True)
    assert result["error"] == f"it holds, because {event['words']}"
    assert any(remark.startswith("the vehicle is no longer watched") for remark in result["remarks"])
    assert result["hint"].startswith(f"`ipoa-mission resume --link {link}` continues its mission")
    assert f"warning: {event['words']}; hold is ordered" in ended.err
    assert f"error: {result['error']}" in ended.err
    assert f"hint: {result['hint']}" in ended.err


@pytest.mark.usefixtures("lower")
def test_a_survey_whose_flight_is_held_names_the_next_steps(run: Run, autopilot: Serve, tmp_path: Path) -> None:
    (tmp_path / "field.toml").write_text(SCENARIO)
    with autopilot(Geodetic(47.3977, 8.5456, 488.0), Autopilot.ARDUPILOT, speedup=8.0) as link:
        ended = run(f"fly {tmp_path}/field.toml --out {tmp_path}/out --link {link} --json")
    assert ended.code == 1
    result = json.loads(ended.out.splitlines()[-1])
    assert result["error"].startswith("field was not flown to its end: it holds, because ")
    assert result["hint"].startswith(f"`ipoa-mission resume --link {link}` continues its mission")
    assert f"hint: {result['hint']}" in ended.err


@pytest.mark.usefixtures("lower")
def test_a_deviation_that_is_only_reported_still_ends_with_1(run: Run, autopilot: Serve) -> None:
    with autopilot(MISSION.home) as link:
        ended = run(f"fly {SITL} --link {link} --on-deviation report")
    assert ended.code == 1
    assert "not as forecast: item " in ended.out
    assert "is ordered" not in ended.err


def test_a_flight_without_contingencies_says_why(
    run: Run, autopilot: Serve, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unknown(*_: object) -> None:
        raise NotModeled("the way is unknown")

    monkeypatch.setattr(ContingenciesNow, "__init__", unknown)
    with autopilot(MISSION.home) as link:
        printed = run(f"fly {SITL.with_suffix('.toml')} --link {link} --set-params --out {tmp_path}/a")
        ended = run(f"fly {SITL.with_suffix('.toml')} --link {link} --set-params --out {tmp_path}/b --json")
    assert printed.out.count("contingencies are not shown in flight: the way is unknown") == 1
    assert "contingencies are not shown in flight: the way is unknown" in json.loads(ended.out)["remarks"]


def test_a_flight_that_outlasts_the_users_time_is_left_in_the_air(run: Run, autopilot: Serve) -> None:
    with autopilot(MISSION.home, speedup=8.0) as link:
        ended = run(f"fly {SITL} --link {link} --timeout 6 --json")
    assert ended.code == 1
    result = json.loads(ended.out)
    assert result["error"].startswith("the time is up: the vehicle flies on, and is not watched any more")
    assert (result["completed"], result["in_air"]) == (False, True)


def test_vehicle_options_are_refused_without_a_vehicle(run: Run) -> None:
    ended = run(f"fly {SITL} --on-deviation rtl")
    assert (ended.code, "--on-deviation: needs --link" in ended.err) == (2, True)
