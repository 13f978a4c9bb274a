import json
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.cli.contingency_output import CELLS, bar_of
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow, Grade
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.scenario import read_scenario
from tests.cli.conftest import Run

MISSIONS = Path(__file__).parents[2] / "missions"
SITL = f"{MISSIONS}/sitl.plan --scenario {MISSIONS}/sitl.toml"


def test_bars_and_words_are_the_rows_of_the_forecast(run: Run) -> None:
    rows = Contingencies(
        Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(MISSIONS / "sitl.toml"))
    ).all_rows(timed=False)
    ended, plain = run(f"show {SITL} --contingencies"), run(f"show {SITL}")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.startswith(plain.out)
    strip = ended.out.removeprefix(plain.out)
    assert strip.isascii()
    bars = re.findall(r"^(\w+) +([-+#?]+)  (.*)$", strip, re.MULTILINE)
    assert [(name, where) for name, _, where in bars] == [("rtl", "to home"), ("land", "here"), ("hold", "here")]
    for name, bar, _ in bars:
        own = [row for row in rows if row.contingency == name]
        assert len(bar) == CELLS
        for grades, signs in ({Grade.UNCLEAR}, "#"), ({Grade.UNCLEAR, Grade.POSSIBLY_UNCLEAR}, "#+"):
            worse = [row for row in own if row.grade in grades]
            share = sum(row.to_s - row.from_s for row in worse) / (own[-1].to_s - own[0].from_s)
            edges = 2 * len(worse)  # a character that is so in part is so
            assert CELLS * share <= sum(map(bar.count, signs)) <= CELLS * share + edges
    assert strip.endswith("".join(f"{row}\n" for row in rows if not row.clear))


@pytest.mark.parametrize(("grade", "sign"), [(Grade.UNCLEAR, "#"), (Grade.POSSIBLY_UNCLEAR, "+")])
@pytest.mark.parametrize("begin", [0.0, 3.3, 47.7])
def test_a_moment_that_is_not_clear_is_never_lost_in_a_bar(begin: float, grade: Grade, sign: str) -> None:
    whole = ContingencyRow(Contingency.LAND, 0.0, begin, Grade.CLEAR, 3.0, 2.5, "mast", "here")
    short = replace(whole, from_s=begin, to_s=begin + 0.01, grade=grade)
    bar = bar_of((whole, short, replace(whole, from_s=begin + 0.01, to_s=50.0)))
    assert bar.index(sign) == max(0, math.ceil(begin) - 1)
    assert 1 <= bar.count(sign) <= 2


def test_unknown_contingencies_are_not_called_clear(run: Run) -> None:
    output = run(f"show {SITL} --param RTL_TYPE=1 --contingencies").out
    assert re.search(rf"^rtl   \?{{{CELLS}}}  goal unknown$", output, re.MULTILINE)
    assert "not clear: returns to the mission's landing, which begin during the landing, are not modeled" in output


def test_the_reason_why_a_return_has_no_duration_is_printed(run: Run) -> None:
    shown, as_json = (run(f"check {SITL} --param RTL_TYPE=2 --contingencies{form}").out for form in ("", " --json"))
    why = "the duration of returns ahead along the mission is not modeled well enough"
    assert shown.count(f"no time of rtl: {why}\n") == 1
    reasons = {row["contingency"]: row["why_untimed"] for row in json.loads(as_json)["contingencies"]}
    assert reasons == {"rtl": why, "land": None, "hold": None}


def test_a_flight_of_which_nothing_is_known_has_no_bars(run: Run, tmp_path: Path) -> None:
    plan = json.loads((MISSIONS / "sitl.plan").read_text(encoding="utf-8"))
    plan["mission"]["items"][2]["params"][4] = 95.0  # north of the pole
    (tmp_path / "far.plan").write_text(json.dumps(plan), encoding="utf-8")
    ended = run(f"show far.plan --scenario {MISSIONS}/sitl.toml --contingencies")
    assert ended.out.endswith("contingencies: unknown, because the flight is unknown\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (f"show {MISSIONS}/sitl.plan --contingencies", "--contingencies: needs --scenario"),
        (f"check {MISSIONS}/sitl.plan --contingencies", "--contingencies: needs --scenario"),
        (f"show {SITL} --contingencies --json", "--contingencies: cannot be combined with --json"),
    ],
)
def test_contingencies_need_a_world_and_have_one_form_for_machines(run: Run, words: str, message: str) -> None:
    ended = run(words)
    assert ended.code == 2
    assert message in ended.err


def test_earlier_flag_warns_and_does_the_same(run: Run) -> None:
    earlier, now = run(f"show {SITL} --endings"), run(f"show {SITL} --contingencies")
    assert earlier.out == now.out
    assert "--endings is --contingencies since 0.5, and goes in 0.6" in earlier.err
