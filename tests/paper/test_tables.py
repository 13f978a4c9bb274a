import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.paper import figures, tables
from ipoa_mission.paper.markdown_table import Table, number
from ipoa_mission.paper.problems import FUNCTIONS
from ipoa_mission.paper.reproduce import ITEMS, Artifact, open_processes, page, reproduce
from ipoa_mission.paper.runs import CHECKPOINTS, Series, Trial, TrialRow
from ipoa_mission.paper.tables import PRINTED
from tests.refused import refuses

RUNS = 3
SLOWLY_DRAWN = {f"figure-{number}" for number in (7, 8, 9, 11)}


def made_up(series: Series) -> list[TrialRow]:
    """Every trial costs 1 for the first algorithm, 2 for the next, with a little spread."""
    order = list(dict.fromkeys((t.algorithm, t.settings) for t in series.firsts))
    return [_row(t, cost_of(order.index((t.algorithm, t.settings)) + 1, t.run)) for t in series.trials(RUNS)]


def cost_of(place: int, run: int) -> float:
    """Spread more the better: the first by mean is not first by deviation."""
    return place + run / 100 / place


def _row(trial: Trial, cost: float) -> TrialRow:
    measures: dict[str, float | list[float]] = {}
    if trial.problem != "cec2022":
        control = np.linspace([5, 5, 60], [95, 95, 60], 10).ravel().tolist()
        measures = {
            "distance": 100 * cost,
            "turn": 10.0,
            "turn_smooth": 1.0,
            "dis_obs": 20.0,
            "iterations": 30.0,
            "feasible": 1.0,
        }
        measures |= {
            "time": 20.0,
            "estimate": 21.0,
            "time_landed": 30.0,
            "clearance": 1.0,
            "estimate_landed": 31.0,
            "flyable": 1.0,
            "control": control,
        }
    return TrialRow(trial, cost, 100, 0.5, tuple([cost] * len(CHECKPOINTS)), measures, "2024-10-21", "numpy=2")


@pytest.fixture(scope="module")
def rows() -> dict[str, Sequence[TrialRow]]:
    return {series.name: made_up(series) for item in ITEMS.values() for series in item.needs}


@pytest.fixture(scope="module")
def made(rows: dict[str, Sequence[TrialRow]]) -> Callable[[str], Table | str]:
    @cache
    def make(name: str) -> Table | str:
        return ITEMS[name].make(rows)

    return make


def test_table_3_has_thirty_six_lines_and_ranks_by_what_was_measured(rows: dict[str, Sequence[TrialRow]]) -> None:
    table = tables.table_3(rows["cec2022-d20"])
    assert len(table.rows) == 36
    mean_f1 = next(row for row in table.rows if row[:2] == ["f1", "mean"])
    for place, (cell, printed) in enumerate(zip(mean_f1[2:], PRINTED["table_3"]["f1"]["mean"], strict=True), start=1):
        ours = 300 + float(np.mean([cost_of(place, run) for run in range(RUNS)]))
        assert cell.startswith(f"{number(ours)} ({place}) · {number(printed)} (")
    assert table.notes[0].startswith("IPOA is first in 24 of 36 here; in print in 25")


def test_table_4_says_better_where_it_is_and_corrects(rows: dict[str, Sequence[TrialRow]]) -> None:
    table = tables.table_4(rows["cec2022-d20"])
    assert len(table.rows) == len(FUNCTIONS)
    assert "of 60; 60 show no difference" in table.notes[0]  # three runs cannot survive a correction over sixty


def test_the_contradictions_are_those_that_arithmetic_finds() -> None:
    table = tables.contradictions()
    assert ["f5", "SSA"] in [list(row[:2]) for row in table.rows]
    proved = [row for row in table.rows if "<" in row[-1]]
    assert [row[:2] for row in proved] == [["f5", "SSA"]]


def test_map_tables_say_how_much_shorter(rows: dict[str, Sequence[TrialRow]]) -> None:
    assert "DBO -50 % (printed -7 %)" in tables.table_6(rows["maps"]).notes[0]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in SLOWLY_DRAWN else ()) for name in ITEMS]
)
def test_every_item_is_made_of_its_rows_and_twice_the_same(
    name: str, rows: dict[str, Sequence[TrialRow]], made: Callable[[str], Table | str]
) -> None:
    first = made(name)
    if isinstance(first, Table):
        assert first == ITEMS[name].make(rows)
        assert all(len(row) == len(first.heading) for row in first.rows)
        assert first.markdown().count("\n| ") == len(first.rows) + 2
    else:
        assert first.startswith("<?xml")
        assert "<dc:date>" not in first


def test_the_page_holds_every_table_and_links_every_figure(
    rows: dict[str, Sequence[TrialRow]], made: Callable[[str], Table | str]
) -> None:
    items = {name: made(name) if "figure" not in name else "<svg/>" for name in ITEMS}
    shown = page(items, rows)
    for name, item in items.items():
        assert (item.markdown() if isinstance(item, Table) else f"({name}.svg)") in shown, name
        assert f"`ipoa-mission reproduce {name}`" in shown
    assert "nan" not in shown


def test_figures_are_the_same_bytes_every_time_and_show_every_point(made: Callable[[str], Table | str]) -> None:
    drawn = made("figure-3")
    assert isinstance(drawn, str)
    assert drawn == figures.figure_3()
    assert drawn.count("<use") > 300


def test_reproduce_writes_a_table_as_markdown(tmp_path: Path) -> None:
    (written,) = reproduce("contradictions", None, tmp_path / "out", open_processes(1))
    assert written.name == "contradictions.md"
    assert written.read_text(encoding="utf-8").startswith("**Contradictions in print")


def test_reproduce_measures_what_is_missing_and_tells_how_far_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("minionpy")
    small = json.dumps({"iterations": 3, "population": 6})
    tiny = Series("tiny", 2, [Trial("cec2022", "f1", 10, name, small, 0, 0) for name in ("poa", "ipoa")])
    progress: list[str] = []

    def make(rows: Mapping[str, Sequence[TrialRow]]) -> Table:
        return Table("tiny", ["cost"], [[number(row.cost)] for row in rows["tiny"]])

    monkeypatch.setitem(ITEMS, "tiny", Artifact([tiny], make))
    for runs in (None, 3, None):
        reproduce("tiny", runs, tmp_path / "out", open_processes(1), lambda share, words: progress.append(words))
    later = ("4 of 6", "5 of 6", "6 of 6", "4 of 4")
    assert progress == [f"tiny: {done} of 4" for done in range(5)] + [f"tiny: {done}" for done in later]
    assert len((tmp_path / "out" / "rows" / "tiny.csv").read_text().splitlines()) == 1 + 6


def test_tables_that_cannot_be_reproduced_are_bad_input(tmp_path: Path) -> None:
    with refuses("unknown-name", "what", "'table3'"):
        reproduce("table3", None, tmp_path, open_processes(1))
