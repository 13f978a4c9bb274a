import json
import tomllib
from pathlib import Path

import pytest

from ipoa_mission import files
from ipoa_mission.paper.runs import Trial, run_trial

REPOSITORY = Path(__file__).parents[2]
SMALL = json.dumps({"iterations": 200, "population": 30})


@pytest.mark.parametrize("mission", ["campus.toml", "paper"])
def test_a_wheel_takes_missions_along_to_where_they_are_looked_for(
    mission: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]
    name = "paper/campus.toml" if mission == "paper" else mission
    assert files.packed(name) == REPOSITORY / "missions" / name
    there = tmp_path / build["targets"]["wheel"]["force-include"][f"missions/{mission}"]
    installed = there / "campus.toml" if mission == "paper" else there
    installed.parent.mkdir(parents=True)
    installed.touch()
    monkeypatch.setattr(files, "__file__", str(tmp_path / "ipoa_mission" / "files.py"))
    assert files.packed(name) == installed


def test_a_feasible_campus_path_is_flown_below_15_meters_a_second() -> None:
    measures = run_trial(Trial("campus", "campus", 24, "ipoa", SMALL, 0, 2)).measures
    assert measures["feasible"] == measures["flyable"] == 1
    distance, time, estimate = (measures[name] for name in ("distance", "time", "estimate"))
    assert isinstance(distance, float)
    assert isinstance(time, float)
    assert 280 < distance < time * 15  # start and goal are 280 m apart
    assert estimate == pytest.approx(time, rel=0.03)
