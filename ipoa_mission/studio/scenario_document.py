import datetime
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.files import MISSIONS, read_text, unused, write_atomically
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.mission.mission_io import parse_mission, write_mission
from ipoa_mission.studio import answers
from ipoa_mission.studio.edits import changed, parse_table
from ipoa_mission.studio.journal import SUFFIX, Journal
from ipoa_mission.studio.mission_changes import mission_changed
from ipoa_mission.studio.requests import Add, Change, InsertItem, PlainItems, Take, TakeItem

BOM = b"\xef\xbb\xbf"


class Stale(MissionError):
    """Another window or program has made a change since."""


class Document:
    """A file under edit; `revision` grows with every change, `autopilot` overrides a mission's."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_mission = path.suffix.lower() in MISSIONS
        self.autopilot: str | None = None
        self.revision = 1
        self.changed_outside = False
        self._numbered_anew = 1
        text = read_text(path)
        self._journal = Journal.open(path.with_name(path.name + SUFFIX), text)

    @property
    def text(self) -> str:
        return self._journal.text

    def edit(self, changes: Iterable[Change], label: str, seen: int) -> bool:
        """Apply changes made on revision `seen`; return whether the text changed."""
        changes = tuple(changes)
        if seen < self._numbered_anew:
            raise Stale(f"{self.path.name} was changed elsewhere meanwhile", hint="review it, and repeat the change")
        new = self._mission_with(changes) if self.is_mission else changed(self.text, changes)
        different = self._stepped(self._journal.write(new, label))
        if any(isinstance(change, Take | Add | InsertItem | TakeItem | PlainItems) for change in changes):
            self._numbered_anew = self.revision
        return different

    def rewrite(self, text: str, seen: int) -> bool:
        """Replace the text of revision `seen`."""
        if seen != self.revision:
            words = f"{self.path.name} was changed elsewhere while its text was edited here"
            raise Stale(words, hint="copy your text, and reload")
        return self._renumbered(self._journal.write(text, "text edited"))

    def read_for(self, autopilot: str | None) -> None:
        """Set a mission's autopilot: earlier findings are invalid."""
        self.autopilot = autopilot
        self.revision += 1

    def undo(self) -> bool:
        return self._renumbered(self._journal.undo())

    def redo(self) -> bool:
        return self._renumbered(self._journal.redo())

    def save(self, over: bool = False) -> None:
        """Write the file; `over` replaces changes by another program."""
        if not over and self.path.exists() and self._on_disk() != self._journal.saved:
            self.changed_outside = True
            raise Stale(f"{self.path.name} was changed by another program", hint="save over it, or take its text")
        mark = BOM if self.path.exists() and self.path.read_bytes().startswith(BOM) else b""
        if not self.path.exists() or self._on_disk() != self.text:
            write_atomically(self.path, mark + self.text.encode())
        self._journal.mark_saved()
        self.changed_outside = False

    def save_as(self, suffix: str) -> tuple[Path, tuple[str, ...]]:
        """Write the mission next to its file; return it and losses of its format."""
        if not self.is_mission:
            raise BadInput("expected a mission", hint="a scenario's mission files: Mission files", place=self.path.name)
        file, target = self._mission(), unused(self.path.with_suffix(suffix))
        return target, write_mission(file.mission, target, suffix, file)

    def look_at_disk(self) -> bool:
        """Look for changes by another program, take them if there are no own; return whether the state changed."""
        try:
            there = self._on_disk()
        except BadInput:
            return False
        if there == self._journal.saved:
            return False
        if there == self.text:  # the same edit: the page's revision stays valid
            self._journal.mark_saved()
            self.changed_outside = False
            return True
        if self.text == self._journal.saved:
            return self.take_theirs()
        before, self.changed_outside = self.changed_outside, True
        return not before

    def take_theirs(self) -> bool:
        self._journal.take_from_disk(self._on_disk())
        self.changed_outside = False
        return self._renumbered(True)

    def as_answer(self) -> answers.Document:
        journal = self._journal
        try:
            table = {} if self.is_mission else _plain(parse_table(self.text).unwrap())
        except BadInput:
            table = {}
        return answers.Document(
            of="mission" if self.is_mission else "scenario",
            revision=self.revision,
            name=self.path.stem,
            path=str(self.path),
            text=self.text,
            scenario=table,
            unsaved=self.text != journal.saved,
            changed_outside=self.changed_outside,
            undo=journal.undo_label,
            redo=journal.redo_label,
        )

    def _mission_with(self, changes: Iterable[Change]) -> str:
        return mission_changed(self.text, self.path, changes, self.autopilot)

    def _mission(self) -> MissionFile:
        return parse_mission(self.path, self.text, None if self.autopilot is None else autopilot_named(self.autopilot))

    def _renumbered(self, different: bool) -> bool:
        self._stepped(different)
        self._numbered_anew = self.revision
        return different

    def _stepped(self, different: bool) -> bool:
        self.revision += different
        return different

    def _on_disk(self) -> str:
        return read_text(self.path)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_plain(one) for one in value]
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, float) and not abs(value) < float("inf"):
        return str(value)
    return value
