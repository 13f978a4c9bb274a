"""The page of findings says what the recorded rows say."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from ipoa_mission.experiments.facts import Facts, facts, signs
from ipoa_mission.experiments.markdown import filled
from ipoa_mission.experiments.page import NOT_SO, findings, template
from ipoa_mission.experiments.reproduce import ITEMS
from ipoa_mission.experiments.rows import Row, read_rows

DOCS = Path(__file__).parents[2] / "docs"
SENTENCES = re.findall(r"(?m)^\* \[(\w+)\] ", template())


@pytest.fixture(scope="module")
def rows() -> dict[str, Sequence[Row]]:
    """The recorded rows of every series, in the order of its trials."""
    found: dict[str, Sequence[Row]] = {}
    for series in (series for item in ITEMS.values() for series in item.needs):
        recorded = {row.trial: row for row in read_rows(DOCS / "reproduction" / "rows" / f"{series.name}.csv")}
        found[series.name] = [recorded[trial] for trial in series.trials(None)]
    return found


@pytest.fixture(scope="module")
def known(rows: dict[str, Sequence[Row]]) -> Facts:
    return facts(rows)


@pytest.mark.parametrize("sentence", SENTENCES)
def test_the_sign_of_every_sentence_holds(sentence: str, known: Facts) -> None:
    assert signs(known)[sentence]


def test_every_sentence_of_a_list_has_a_sign_and_every_sign_a_sentence(known: Facts) -> None:
    assert list(signs(known)) == SENTENCES
    assert template().count("\n* ") == len(SENTENCES)


def test_no_fact_is_idle(known: Facts) -> None:
    """What is worked out is told, or a sign stands on it."""
    told = set(re.findall(r"\{(\w+)", template()))
    assert known.keys() - told == {"best_of_six", "without_all_better", "without_all_worse"}


def test_the_page_in_the_documents_is_made_of_the_recorded_rows(
    rows: dict[str, Sequence[Row]], known: Facts, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ipoa_mission.experiments.page.facts", lambda _: known)  # those of these rows, made once
    made = {name: item.make(rows) if "figure" not in name else "<svg/>" for name, item in ITEMS.items()}
    sources = {name: [series.name for series in item.needs] for name, item in ITEMS.items()}
    page = findings(made, sources, rows, "reproduction")
    assert page == (DOCS / "reproduction.md").read_text(encoding="utf-8")
    assert NOT_SO not in page


def test_a_sentence_that_does_not_hold_says_so(known: Facts) -> None:
    turned = known | {"score_ipoa": known["score_poa"], "score_poa": known["score_ipoa"]}
    assert [name for name, holds in signs(turned).items() if not holds] == ["improves_on_poa"]


def test_filling_begins_no_list_in_the_middle_of_a_sentence() -> None:
    for before in range(100, 120):
        lines = filled("a" * before + " b - c 1. " + "d " * 40).splitlines()
        assert all(len(line) <= 120 and line[:2] not in ("- ", "1.") for line in lines)
    assert filled("# a\n\n| b |\n| --- |\n\n* c\n  d\n* e") == "# a\n\n| b |\n| --- |\n\n* c d\n* e\n"
