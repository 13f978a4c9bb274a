from pathlib import Path

import pytest

import ipoa_mission


def test_a_notebook_shows_our_data_as_tables(missions: Path) -> None:
    interactiveshell = pytest.importorskip("IPython.core.interactiveshell")
    shell = interactiveshell.InteractiveShell()
    shell.run_line_magic("load_ext", "ipoa_mission")
    scenario = ipoa_mission.read_scenario(missions / "sitl.toml")
    plan = ipoa_mission.plan_path(scenario)
    mission = ipoa_mission.assemble(plan, scenario)
    found = ipoa_mission.estimate(mission)
    record = ipoa_mission.fly(mission)
    for thing, words in (
        (plan, "least clearance"),
        (mission, "NAV_TAKEOFF"),
        (found, f"Estimated {found.total_s:.1f} s"),
        (record, f"Flown to its end: {record.total_s:.1f} s"),
    ):
        html = shell.display_formatter.format(thing)[0]["text/html"]
        assert words in html
        assert html.count("<tr>") == html.count("</tr>") > 2
