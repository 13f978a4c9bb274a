from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import plan_flight, read_mission
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.checks.check import check
from ipoa_mission.forecast.contingency.contingencies import Contingencies
from ipoa_mission.forecast.contingency.shortfalls import highest_return
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.scenario import Scenario, parse_scenario
from tests.examples import some
from tests.quick_search import search_quickly

PLANNED = (Contingency.RTL, Contingency.SMART_RTL, Contingency.HOLD)
OF_RETURNS = {"return-too-near", "land-too-near", "outside-fence"}
FENCE = "[[fence]]\ninclusion = false\npolygon = [[{0}, {1}], [{2}, {1}], [{2}, {3}], [{0}, {3}]]"


def scene(seed: int) -> Scenario:
    """Blocks, masts, hanging bodies, at times a fence, rally points, low bounds, a return altitude."""
    rng = np.random.default_rng(seed)

    def body(n: int) -> str:
        kind = rng.choice(["box", "box", "cylinder", "sphere"])
        place = f"east = {rng.uniform(25, 230):.1f}\nnorth = {rng.uniform(-90, 90):.1f}"
        size = {
            "box": f"width = {rng.uniform(8, 40):.1f}\ndepth = {rng.uniform(8, 40):.1f}\n"
            f"height = {rng.uniform(6, 55):.1f}",
            "cylinder": f"radius = {rng.uniform(1, 8):.1f}\nheight = {rng.uniform(10, 65):.1f}",
            "sphere": f"radius = {rng.uniform(4, 9):.1f}\nup = {rng.uniform(25, 60):.1f}",
        }[str(kind)]
        return f'[[obstacles]]\nkind = "{kind}"\nname = "body {n}"\n{place}\n{size}'

    bodies = [body(n) for n in range(int(rng.integers(3, 10)))]
    west, south = rng.uniform(40, 160), rng.uniform(-60, 20)
    fences = [FENCE.format(west, south, west + rng.uniform(20, 70), south + rng.uniform(20, 65))] * (rng.random() < 0.3)
    rally = [
        f"[[rally]]\neast = {rng.uniform(20, 240):.1f}\nnorth = {rng.uniform(-90, 90):.1f}\nup = 20"
        for _ in range(int(rng.choice([0, 0, 0, 1, 2])))
    ]
    top = f", up = [-5.0, {rng.uniform(26, 90):.0f}]" if rng.random() < 0.5 else ""
    text = f"""
    safety_distance = {rng.uniform(1.0, 3.0):.1f}
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = {rng.uniform(10, 20):.0f} }}
    goal = {{ east = {rng.uniform(80, 240):.1f}, north = {rng.uniform(-80, 80):.1f}, up = {rng.uniform(10, 22):.0f} }}
    vehicle = {{ radius = 0.5, cruise_speed = {rng.uniform(4, 12):.1f} }}
    route = {{ ending = "{rng.choice(["rtl", "land"])}" }}
    safety = {{ returns = "planned" }}
    bounds = {{ east = [-50.0, 300.0], north = [-120.0, 120.0]{top} }}
    """
    return parse_scenario("\n".join([text, *fences, *rally, *bodies]), Path(f"scene{seed}.toml"))


#: Scenes that are planned on both; a refusal writes nothing.
PLANNED_SCENES = (0, 1, 2, 4, 6, 8, 10, 11, 12, 13, 15, 16, 17, 19, 20, 22, 23)


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("seed", some(2, PLANNED_SCENES))
def test_planned_returns_are_clear_by_the_check(
    seed: int, autopilot: Autopilot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    search_quickly(monkeypatch.setattr)
    scenario = scene(seed)
    plan_flight(scenario.flown_by(autopilot), seed=0).write(tmp_path)
    forecast = Forecast(read_mission(tmp_path / f"scene{seed}.plan"), scenario)
    findings = check(forecast)
    own = {n for n, item in enumerate(forecast.mission.items, 1) if item.command == Command.NAV_RETURN_TO_LAUNCH}
    assert not [f for f in findings if f.code in OF_RETURNS or (f.code == "leg-too-near" and f.seq in own)]
    assert all(
        row.clear for contingency in PLANNED for row in forecast.cached(Contingencies).rows(contingency, timed=False)
    )
    if scenario.geofence:
        assert all(leg.points[:, 2].max() <= highest_return(forecast) + 0.1 for leg in forecast.ways_home)
