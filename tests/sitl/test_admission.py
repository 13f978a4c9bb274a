import argparse
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.messages import Position
from tools.fly import admit
from tools.fly.admission_flight import COMPLETED, FLEW_AWAY, NOT_COMPLETED, NOT_FLOWN, REFUSED, Broken, Row, Watch
from tools.fly.admission_scenes import FAST, KINDS, SLOW, scene, scene_name, shipped, written

MISSIONS = Path(__file__).resolve().parents[2] / "missions"
GOOD = Row(
    "town1x000",
    "px4",
    0,
    "1.17.0",
    COMPLETED,
    surplus=1.0,
    over_guarantee=0.5,
    estimated_route_s=100.0,
    flown_route_s=101.0,
)


def asked(**options: object) -> argparse.Namespace:
    return argparse.Namespace(**({"scenarios": [], "count": 8, "seed": 1, "times": 1} | options))


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_a_random_scene_is_a_scenario_and_follows_from_its_seed(number: int, tmp_path: Path) -> None:
    path = written(number, 1, Autopilot.PX4, tmp_path / "scene.toml")
    again, of_other_seed = (written(number, seed, Autopilot.PX4, tmp_path / f"{seed}.toml") for seed in (1, 2))
    assert read_scenario(path).vehicle.autopilot is Autopilot.PX4
    assert path.read_bytes() == again.read_bytes() != of_other_seed.read_bytes()


def test_a_set_has_every_kind_slow_and_fast() -> None:
    kinds = len(KINDS)
    speeds = [scene(number, 1, Autopilot.PX4)["vehicle"]["cruise_speed"] for number in range(3 * kinds)]
    assert all(SLOW[0] <= speed <= SLOW[1] for speed in speeds[kinds : 2 * kinds])
    assert all(FAST[0] <= speed <= FAST[1] for speed in speeds[2 * kinds :])
    assert {scene_name(number, 1)[:-5] for number in range(kinds)} == set(KINDS)


def test_a_vehicle_that_flies_on_past_its_item_is_a_fly_away() -> None:
    forecast = Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(MISSIONS / "sitl.toml"))
    vehicle = SimpleNamespace(state=SimpleNamespace(armed=True, current=None), autopilot=Autopilot.PX4)
    watch = Watch(vehicle, forecast)  # type: ignore[arg-type]
    points = forecast.estimate.track.points
    top = points[points[:, 2].argmax()]
    for step in range(50):
        at = forecast.frame.geodetic(top + np.array([0.0, 0.0, float(step)]))
        watch.hear(Position(float(step), at.latitude_deg, at.longitude_deg, at.altitude, 0.0))
    assert watch.astray == pytest.approx(49.0, abs=0.1)
    at = forecast.frame.geodetic(top + np.array([0.0, 0.0, 52.0]))
    with pytest.raises(Broken, match="52 m from its path after 52 s") as broken:
        watch.hear(Position(52.0, at.latitude_deg, at.longitude_deg, at.altitude, 0.0))
    assert broken.value.outcome == FLEW_AWAY


def test_a_flight_that_does_not_end_is_not_completed() -> None:
    forecast = Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(MISSIONS / "sitl.toml"))
    vehicle = SimpleNamespace(state=SimpleNamespace(armed=True, current=None), autopilot=Autopilot.PX4)
    watch = Watch(vehicle, forecast)  # type: ignore[arg-type]
    home = forecast.mission.home
    here = home.latitude_deg, home.longitude_deg, home.altitude, 0.0
    watch.hear(Position(0.0, *here))
    with pytest.raises(Broken, match="not down after 400 s") as broken:
        watch.hear(Position(400.0, *here))
    assert broken.value.outcome == NOT_COMPLETED


def test_refused_scenes_are_replaced_by_others() -> None:
    rows, named = list[Row](), list[str]()
    to_fly = admit.tasks(asked(), rows)
    while (task := next(to_fly)) is not None:
        outcome = REFUSED if len(rows) == 6 else COMPLETED
        rows.append(replace(GOOD, scene=task.name, outcome=outcome))
        named.append(task.name)
    assert named == [*(path.stem for path in shipped()), *(scene_name(n, 1) for n in range(4))]
    assert next(admit.tasks(asked(), rows)) is None


def test_flown_scenes_are_not_flown_again() -> None:
    rows = [replace(GOOD, scene=path.stem) for path in shipped()]
    task = next(admit.tasks(asked(), rows))
    assert task is not None
    assert task.name == scene_name(0, 1)


@pytest.mark.parametrize(
    ("bad", "count", "measured"),
    [
        (replace(GOOD, outcome=FLEW_AWAY), 1, False),
        (replace(GOOD, outcome=NOT_COMPLETED), 1, False),
        (replace(GOOD, outcome=NOT_FLOWN), 1, False),
        (replace(GOOD, surplus=-0.1), 1, False),
        (replace(GOOD, over_guarantee=-0.1), 2, True),
        (replace(GOOD, over_guarantee=-0.1), 3, False),
        (replace(GOOD, estimated_route_s=107.0), 1, True),
        (replace(GOOD, estimated_route_s=107.5), 1, False),
        (replace(GOOD, estimated_route_s=103.0), 49, True),
        (replace(GOOD, estimated_route_s=103.0), 51, False),
    ],
)
def test_criteria_make_a_version_measured(bad: Row, count: int, measured: bool) -> None:
    rows = [replace(GOOD, flight=n) for n in range(100 - count)] + [bad] * count
    assert admit.verdict(rows, 100)[0] is measured


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    rows = [replace(GOOD, why='"so", it said'), replace(GOOD, flight=1, outcome=REFUSED)]
    admit.write_rows(path := tmp_path / "rows.csv", rows)
    read = admit.read_rows(path)
    assert [row.flight for row in read] == [0, 1]
    assert "so" in read[0].why
    assert read[1].outcome == REFUSED
    assert read[0].flown_route_s == 101.0


@pytest.mark.long
def test_a_whole_run_on_the_built_in_autopilot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    start = f"{sys.executable} -m ipoa_mission mock --autopilot ardupilot --link tcpin:127.0.0.1:19770"
    start += " --speedup 30 --home {latitude} {longitude} {altitude}"
    words = ["--autopilot", "ardupilot", "--sitl", "tcp:127.0.0.1:19770", "--start", start, "--out", str(tmp_path)]
    admit.main([*words, "--count", "1"])
    assert "ArduCopter 4.8.0-dev: measured" in capsys.readouterr().out
    assert (tmp_path / "campus-ardupilot__0" / "track.csv").exists()
    admit.main([*words, "--count", "1"])
    assert "campus 0: completed" not in capsys.readouterr().out
