"""Table 8: what is found on the campus is flown and timed, wherever the package is installed."""

import tomllib
from pathlib import Path

import pytest

from ipoa_mission.paper.campus import PLACES
from ipoa_mission.paper.rows import Trial, settings_text
from ipoa_mission.paper.runs import run_trial

REPOSITORY = Path(__file__).parents[2]
SMALL = settings_text(evaluations=15_000)


def test_a_wheel_takes_the_campus_along_to_where_it_is_looked_for() -> None:
    build = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]
    taken = build["targets"]["wheel"]["force-include"]
    packed = {REPOSITORY / source: REPOSITORY / target for source, target in taken.items()}
    assert packed[PLACES[1]] == PLACES[0]
    assert PLACES[1].exists()


def test_a_path_that_touches_nothing_is_flown_no_faster_than_15_meters_a_second() -> None:
    measures = run_trial(Trial("campus", "campus", 24, "adaptive-pelican", SMALL, 0, 0)).measures
    assert measures["feasible"] == measures["flyable"] == 1
    distance, time, estimate = (measures[name] for name in ("distance", "time", "estimate"))
    assert isinstance(distance, float)
    assert isinstance(time, float)
    assert 280 < distance < time * 15  # start and goal are 280 m apart
    assert estimate == pytest.approx(time, rel=0.03)
