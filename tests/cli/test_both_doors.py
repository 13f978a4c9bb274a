import json
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

import ipoa_mission as api
from ipoa_mission.checks.world_check import check_failsafe_return
from ipoa_mission.routing.seek import plan_with_margins
from tests.cli.conftest import Run
from tests.quick_search import once, search_quickly

MISSIONS = Path(__file__).parents[2] / "missions"
OTHERS = sorted(path.stem for path in MISSIONS.glob("*.toml") if path.stem != "sitl")
#: Slower than the autopilot's defaults.
SLOW = {
    "ardupilot": "WPNAV_ACCEL = 120\nWP_JERK = 0.6\nLAND_SPEED = 30\nRTL_ALT_M = 22.5",
    "px4": "MPC_ACC_HOR = 2.4\nMPC_JERK_AUTO = 3.5\nMPC_LAND_SPEED = 0.4",
}
#: NAME.json knows the ground's height at the landing, not its slope [s].
SLOPE_S = 0.2


@pytest.fixture(scope="module")
def slowed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Return a quickly searched scenario on such a vehicle."""

    @cache
    def written(name: str) -> Path:
        folder = tmp_path_factory.mktemp(name)
        for file in MISSIONS.iterdir():
            if file.is_file():
                (folder / file.name).symlink_to(file)
        usual = api.read_scenario(MISSIONS / f"{name}.toml")
        path = folder / "slow.toml"
        text = (MISSIONS / f"{name}.toml").read_text(encoding="utf-8")
        short = "[optimizer]\npopulation = 8\niterations = 8\n"
        heading, slow = "[vehicle.parameters]\n", SLOW[usual.vehicle.autopilot.name]
        text = re.sub(r"(?m)^RTL_ALT = .*\n", "", text)  # it is given by its newer name
        has = heading in text
        text = text.replace(heading, f"{heading}{slow}\n") if has else f"{text}\n{heading}{slow}\n"
        path.write_text(f"{text}\n{short}\n", encoding="utf-8")
        return path

    return written


@pytest.fixture
def slow(slowed: Callable[[str], Path], name: str) -> Path:
    if name == "oldtown":
        pytest.importorskip("rasterio")
    return slowed(name)


@cache
def planned(slow: Path) -> api.Flight:
    return api.plan_flight(api.read_scenario(slow), seed=4)


@pytest.fixture(autouse=True, scope="module")
def looked_for_once() -> Iterator[None]:
    """Answer equal searches once; other tests prove that they are equal."""
    paths = once(plan_with_margins, lambda scenario, seed, progress: (scenario, seed))
    ways_home = once(lambda f: tuple(check_failsafe_return(f)), lambda f: (f.mission, f.scenario))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ipoa_mission.flight.flight.plan_with_margins", paths)
        patch.setattr("ipoa_mission.checks.world_check.check_failsafe_return", ways_home)
        search_quickly(patch.setattr)
        yield


@pytest.mark.parametrize("name", ["sitl", *(pytest.param(name, marks=pytest.mark.long) for name in OTHERS)])
def test_python_and_the_command_line_give_the_same_numbers_and_bytes(run: Run, slow: Path) -> None:
    scenario, flight = api.read_scenario(slow), planned(slow)
    result = json.loads(run(f"plan {slow} --out cli --seed 4 --report --json").out)
    written = flight.write("api")
    assert result["written"] == [str(Path("cli") / path.name) for path in written] + ["cli/slow.html"]
    del result["written"]
    assert result == json.loads(json.dumps(flight.summary()))
    for path in written:
        assert path.read_bytes() == (Path("cli") / path.name).read_bytes()
    flight.report("api/slow.html")
    assert Path("api/slow.html").read_bytes() == Path("cli/slow.html").read_bytes()

    total = flight.estimate.total_s
    usual = api.estimate(replace(flight.mission, parameters={})).total_s
    assert total > usual + 3.0
    near = 1e-3 if flight.forecast.ground.is_flat else SLOPE_S
    for file in ("api/slow.plan", "cli/slow.waypoints"):
        again = api.read_mission(file, flight.mission.autopilot)
        assert dict(again.parameters) == dict(flight.mission.parameters)
        assert api.estimate(again).total_s == pytest.approx(total, abs=near)
        words = f"estimate {file} --autopilot {flight.mission.autopilot} --json"
        by_command = json.loads(run(words).out)
        assert by_command["total_s"] == pytest.approx(total, abs=near)
        with_scenario = json.loads(run(f"{words} --scenario {slow}").out)
        assert with_scenario["total_s"] == pytest.approx(total, abs=1e-3)
        assert by_command["remarks"][0].startswith(f"parameters from {Path(file).with_suffix('.params')}: ")
    findings = api.check_mission(flight.mission, scenario)
    checked = json.loads(run(f"check cli/slow.plan --scenario {slow} --json").out)
    assert [row["message"] for row in checked["findings"]] == [finding.message for finding in findings]
    assert findings == flight.findings


@pytest.mark.parametrize("name", ["sitl"])
def test_both_doors_fly_the_same_flight(run: Run, slow: Path) -> None:
    scenario, flight = api.read_scenario(slow), planned(slow)
    flight.report("api.html")
    api.write_report(api.Forecast(flight.mission, scenario), "by_hand.html", flight.plan, remarks=flight.remarks)
    assert Path("api.html").read_bytes() == Path("by_hand.html").read_bytes()
    record = api.fly_built_in(flight.mission, log="api.tlog")
    flight.write("api")
    flown = json.loads(run("fly api/slow.plan --out cli --json").out)
    assert flown["flown_s"] == round(record.total_s, 3)
    assert Path("cli/slow.tlog").read_bytes() == Path("api.tlog").read_bytes()
    assert flown["estimate"]["total_s"] == pytest.approx(flight.estimate.total_s, abs=1e-3)
    compared = json.loads(run("compare api/slow.plan cli/slow.tlog --json").out)
    comparison = api.compare_flight(flight.estimate, api.read_flight("cli/slow.tlog", flight.mission))
    assert compared["estimated_s"] == round(comparison.estimated_total_s, 3)
    assert compared["flown_s"] == pytest.approx(comparison.flown_total_s, abs=1e-3)
    assert not math.isnan(comparison.flown_total_s)


@pytest.mark.parametrize("name", ["sitl"])
def test_options_go_before_values_of_the_mission(run: Run, slow: Path) -> None:
    flight = planned(slow)
    flight.write()
    by_command = json.loads(run("estimate slow.plan --param MPC_LAND_SPEED=0.7 --json").out)["total_s"]
    by_python = api.estimate(flight.mission, {"MPC_LAND_SPEED": 0.7}).total_s
    assert by_command == round(by_python, 3)
    assert by_python < flight.estimate.total_s - 1.0
    longer = api.fly_built_in(flight.mission, seed=1).total_s
    assert api.fly_built_in(flight.mission, {"MPC_LAND_SPEED": 0.7}, seed=1).total_s < longer - 1.0


@pytest.mark.parametrize("name", ["sitl"])
def test_python_refuses_what_the_command_line_refuses(run: Run, slow: Path) -> None:
    thirsty = "\n[vehicle.airframe]\nmass_kg = 2.0\nrotor_diameter = 0.25\n[vehicle.battery]\ncapacity_wh = 1.0\n"
    path = slow.with_name("thirsty.toml")
    path.write_text(slow.read_text(encoding="utf-8") + thirsty, encoding="utf-8")
    with pytest.raises(api.NotEnoughBattery) as refused:
        api.plan_flight(api.read_scenario(path), seed=4)
    ended = run(f"plan {path} --seed 4 --out out")
    assert ended.code == 1
    assert str(refused.value) in " ".join(ended.err.split())
    assert not Path("out").exists()
