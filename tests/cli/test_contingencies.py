import json
import re
from pathlib import Path

from tests.cli.conftest import Run

MISSIONS = Path(__file__).parents[2] / "missions"
SITL = f"{MISSIONS}/sitl.plan --scenario {MISSIONS}/sitl.toml"


def test_unknown_contingencies_are_not_called_clear(run: Run) -> None:
    output = run(f"check {SITL} --param RTL_TYPE=1 --contingencies").out
    assert re.search(r"^rtl +[\d.]+ +[\d.]+ +\? ", output, re.MULTILINE)
    assert "1 of 7 stretches are unknown" in output


def test_the_reason_why_a_return_has_no_duration_is_printed(run: Run) -> None:
    shown, as_json = (run(f"check {SITL} --param RTL_TYPE=2 --contingencies{form}").out for form in ("", " --json"))
    why = "the duration of returns ahead along the mission is not modeled well enough"
    assert shown.count(f"no time of rtl: {why}\n") == 1
    reasons = {row["contingency"]: row["why_untimed"] for row in json.loads(as_json)["contingencies"]}
    assert reasons == {"rtl": why, "land": None, "hold": None}


def test_contingencies_of_an_unknown_flight_are_unknown(run: Run, tmp_path: Path) -> None:
    plan = json.loads((MISSIONS / "sitl.plan").read_text(encoding="utf-8"))
    plan["mission"]["items"][2]["params"][4] = 95.0  # north of the pole
    (tmp_path / "far.plan").write_text(json.dumps(plan), encoding="utf-8")
    ended = run(f"check far.plan --scenario {MISSIONS}/sitl.toml --contingencies")
    assert "contingencies: unknown, because the flight is unknown\n" in ended.out


def test_contingencies_need_a_world(run: Run) -> None:
    ended = run(f"check {MISSIONS}/sitl.plan --contingencies")
    assert ended.code == 2
    assert "--contingencies: needs --scenario" in ended.err
