from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.studio import scenario_document
from ipoa_mission.studio.scenario_document import Journal, splice_between


def reopened(path: Path, on_disk: str) -> Journal:
    return Journal.open(path, on_disk)


@given(st.text(), st.text())
def test_a_splice_leads_there_and_back(before: str, after: str) -> None:
    splice = splice_between(before, after, "x")
    assert splice.redone(before) == after
    assert splice.undone(after) == before


@given(st.lists(st.one_of(st.text(max_size=6), st.sampled_from([1, -1])), max_size=25))
def test_a_restart_changes_nothing(tmp_path_factory: pytest.TempPathFactory, doings: list[str | int]) -> None:
    path = tmp_path_factory.mktemp("journal") / "x.studio"
    journal = Journal.open(path, "begin")
    for doing in doings:
        if isinstance(doing, str):
            journal.write(doing, doing)
        elif doing > 0:
            journal.step(1)
        else:
            journal.step(-1)
        again = reopened(path, "begin")
        assert (again.text, again.undo_label, again.redo_label) == (
            journal.text,
            journal.undo_label,
            journal.redo_label,
        )
    while journal.step(-1):
        pass
    assert journal.text == "begin"


def test_opening_alone_writes_nothing(tmp_path: Path) -> None:
    Journal.open(tmp_path / "x.studio", "text")
    assert not list(tmp_path.iterdir())


def test_unsaved_edits_are_there_again(tmp_path: Path) -> None:
    journal = Journal.open(tmp_path / "x.studio", "one")
    journal.write("two", "second")
    journal.mark_saved()
    journal.write("three", "third")
    again = reopened(tmp_path / "x.studio", "two")
    assert (again.text, again.saved, again.undo_label) == ("three", "two", "third")


def test_another_programs_text_is_taken_and_ours_is_one_step_back(tmp_path: Path) -> None:
    journal = Journal.open(tmp_path / "x.studio", "one")
    journal.write("ours", "ours")
    again = reopened(tmp_path / "x.studio", "theirs")
    assert (again.text, again.saved) == ("theirs", "theirs")
    again.step(-1)
    assert again.text == "ours"


@pytest.mark.parametrize("broken", [b"", b'{"text": "two", "sav', b"[1, 2]", b"\x00\xff"])
def test_a_damaged_journal_begins_anew(tmp_path: Path, broken: bytes) -> None:
    path = tmp_path / "x.studio"
    path.write_bytes(broken)
    journal = Journal.open(path, "one")
    assert (journal.text, journal.undo_label) == ("one", None)
    journal.write("two", "second")
    assert reopened(path, "one").text == "two"


def test_journal_has_a_greatest_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenario_document, "EDIT_LIMIT", 5)
    path = tmp_path / "x.studio"
    journal = Journal.open(path, "0")
    for n in range(1, 8):
        journal.write(str(n), str(n))
    again = reopened(path, "0")
    assert again.text == "7"
    assert again.done == len(again.edits) == 5
    while again.step(-1):
        pass
    assert again.text == "2"
