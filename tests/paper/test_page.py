from collections.abc import Sequence
from pathlib import Path

import pytest

from ipoa_mission.paper.markdown_table import filled
from ipoa_mission.paper.reproduce import ITEMS, page
from ipoa_mission.paper.runs import TrialRow, read_rows

FOLDER = Path(__file__).parents[2] / "docs" / "reproduction"


def recorded() -> dict[str, Sequence[TrialRow]]:
    """The recorded rows of every series, in the order of its trials."""
    rows_by_name: dict[str, Sequence[TrialRow]] = {}
    for series in (series for item in ITEMS.values() for series in item.needs):
        rows = {row.trial: row for row in read_rows(FOLDER / "rows" / f"{series.name}.csv")}
        rows_by_name[series.name] = [rows[trial] for trial in series.trials(None)]
    return rows_by_name


@pytest.mark.long
def test_the_page_in_the_documents_is_made_of_the_recorded_rows() -> None:
    rows = recorded()
    made = {name: item.make(rows) if "figure" not in name else "<svg/>" for name, item in ITEMS.items()}
    assert page(made, rows) == (FOLDER / "README.md").read_text(encoding="utf-8")


def test_filling_begins_no_list_in_the_middle_of_a_sentence() -> None:
    for before in range(100, 120):
        lines = filled("a" * before + " b - c 1. " + "d " * 40).splitlines()
        assert all(len(line) <= 120 and line[:2] not in ("- ", "1.") for line in lines)
    assert filled("# a\n\n| b |\n| --- |\n\n* c\n  d\n* e") == "# a\n\n| b |\n| --- |\n\n* c d\n* e\n"
