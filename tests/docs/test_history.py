from pathlib import Path

from tools.history import HISTORY, Row, append, plotted, read

OLD = [Row("0.1.0", "2026-11-22", name, "path cost", cost) for name, cost in (("sitl", 80.0), ("campus", 300.0))]
NEW = [Row("0.2.0", "2026-12-01", "sitl", "path cost", 72.0)]


def test_rows_are_added_behind_those_that_are_there(tmp_path: Path) -> None:
    for rows in (OLD, NEW):
        append(iter(rows), tmp_path / "history.csv")
    assert read(tmp_path / "history.csv") == OLD + NEW


def test_each_scenario_is_a_line_over_its_first_value() -> None:
    (panel,) = plotted(OLD + NEW).axes
    lines = {str(line.get_label()): list(line.get_ydata()) for line in panel.lines}  # type: ignore[arg-type]
    assert lines == {"sitl": [1.0, 0.9], "campus": [1.0]}


def test_the_history_has_a_scenario_once_for_each_version_and_measure() -> None:
    keys = [(row.version, row.scenario, row.measure) for row in read(HISTORY)]
    assert len(set(keys)) == len(keys) > 0
