"""A path whose contingencies cost much time is planned once more."""

from pathlib import Path

import pytest

from ipoa_mission import read_scenario
from ipoa_mission.errors import MissionError
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.planning.planner import Plan, plan_path
from ipoa_mission.progress import silent
from ipoa_mission.routing import seek
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.resample import NoRoute
from tests.quick_search import QUICK

SCENARIO = read_scenario(Path(__file__).parents[2] / "missions" / "sitl.toml")


@pytest.mark.parametrize("refusal", [NoPath("closed"), NoRoute("too near")], ids=["no path", "no route"])
def test_a_slow_attempt_is_kept_if_the_next_path_fails(refusal: MissionError, monkeypatch: pytest.MonkeyPatch) -> None:
    path = plan_path(SCENARIO, strategy=QUICK)
    paths: list[Plan | MissionError] = [path, refusal]
    tried, move = list[Attempt](), seek._move_until_safe

    def planned(*_: object, **__: object) -> Plan:
        if isinstance(one := paths.pop(0), MissionError):
            raise one
        return one

    def delayed(*given: object) -> tuple[Attempt, float]:
        attempt, _ = move(*given)  # type: ignore[arg-type]
        tried.append(attempt)
        return attempt, 2.0

    monkeypatch.setattr(seek, "plan_path", planned)
    monkeypatch.setattr(seek, "_move_until_safe", delayed)
    assert seek.seek(SCENARIO, 0, silent) is tried[0]
    assert tried[0].is_acceptable
    assert paths == []
