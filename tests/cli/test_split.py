import json
from pathlib import Path

import pytest

from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.routing.seek import plan_with_margins
from tests.cli.conftest import Run
from tests.quick_search import once

ROWS = [(300, 30), (300, 90), (0, 90), (0, 150), (300, 150), (300, 210)]
SCENARIO = """
home = { latitude_deg = 47.397742, longitude_deg = 8.545594, altitude_amsl = 488.0 }
start = { east = 0.0, north = 30.0, up = 30.0 }
goal = { east = 0.0, north = 210.0, up = 30.0 }
via = [ROWS]

[vehicle]
autopilot = "ardupilot"
cruise_speed = 8.0
airframe = { mass_kg = 3.0, rotor_diameter = 0.35 }
battery = { capacity_mah = 2000.0, voltage = 14.8 }
""".replace("ROWS", ", ".join(f"{{ east = {east}.0, north = {north}.0, up = 30.0 }}" for east, north in ROWS))


def test_a_plan_beyond_its_battery_is_refused_and_split_writes_its_parts(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = once(plan_with_margins, lambda scenario, seed, progress: (scenario, seed))
    monkeypatch.setattr("ipoa_mission.flight.flight.plan_with_margins", paths)
    scenario = tmp_path / "rows.toml"
    scenario.write_text(SCENARIO, encoding="utf-8")
    refused = run(f"plan {scenario} --seed 7 --out out")
    assert refused.code == 1
    assert "battery: expected a reserve of 20% after landing" in " ".join(refused.err.split())
    assert "plan --split" in " ".join(refused.err.split())
    assert not Path("out").exists()
    result = json.loads(run(f"plan {scenario} --seed 7 --out out --split --json").out)
    assert [flight["file"] for flight in result["flights"]] == ["rows-1.plan", "rows-2.plan"]
    assert not Path("out/rows.plan").exists()
    for flight in result["flights"]:
        assert len(read_mission(Path("out") / flight["file"]).items) == flight["items"]
        assert flight["left"][1] > 0.2
        assert run(f"check out/{flight['file']} --scenario {scenario}").code == 0
    about = json.loads(Path("out/rows.json").read_text(encoding="utf-8"))
    assert about["flights"] == result["flights"]
    assert "2 flights, a battery each" in run(f"plan {scenario} --seed 7 --out out --split --force").out
    assert not Path("out/rows.html").exists()
    reported = json.loads(run(f"plan {scenario} --seed 7 --out out --split --force --report --json").out)["written"]
    assert [file for file in reported if file.endswith(".html")] == ["out/rows.html"]
    page = Path("out/rows.html").read_text(encoding="utf-8")
    table = page[page.index("<h2>Flights</h2>") :]
    assert "flown in 2 flights, a battery each" in table
    for flight in result["flights"]:
        assert flight["file"] in table[: table.index("</table>")]
        assert f"{flight['energy_wh'][1]:.1f} (" in table[: table.index("</table>")]
    timed = run(f"estimate out/rows-1.plan --scenario {scenario}").out
    assert "20% required" in timed
    assert "rows.json" not in timed
    seconds = result["flights"][0]["time_s"]
    alone = run("estimate out/rows-1.plan --param WPNAV_ACCEL=60").out
    assert f"note: rows.json has {seconds:.1f} s for it: in its scenario's world and wind (--scenario)" in alone
    with Path("out/rows-1.plan").open("a") as file:
        file.write("\n")  # another file than it was
    assert "rows.json" not in run("estimate out/rows-1.plan --param WPNAV_ACCEL=60").out


def test_flight_of_one_battery_is_written_as_without_split(run: Run, tmp_path: Path) -> None:
    scenario = tmp_path / "rows.toml"
    near = "\n".join(line for line in SCENARIO.splitlines() if not line.startswith("via"))
    scenario.write_text(near, encoding="utf-8")
    written = json.loads(run(f"plan {scenario} --out out --split --report --json").out)["written"]
    assert [Path(file).name for file in written] == ["rows.plan", "rows.waypoints", "rows.json", "rows.html"]
