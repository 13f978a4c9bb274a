"""A file under edit, and a journal next to it for undo after a restart or a crash."""

import codecs
import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import BaseModel, PrivateAttr

from ipoa_mission import BadInput, MissionError
from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.files import MISSIONS, read_text, unused, write_atomically
from ipoa_mission.mission.mission_io import parse_mission, write_mission
from ipoa_mission.studio import answers
from ipoa_mission.studio.edits import changed, mission_changed, parse_table
from ipoa_mission.studio.requests import Add, Change, InsertItem, ItemStep, Take

EDIT_LIMIT = 400  # kept when opened


@dataclass(frozen=True)
class Splice:
    """
    >>> splice_between("goal = 1", "goal = 2", "goal moved")
    Splice(start=7, removed='1', inserted='2', label='goal moved', renumbers=True)
    """

    start: int
    removed: str
    inserted: str
    label: str
    renumbers: bool = True

    def redone(self, text: str) -> str:
        return text[: self.start] + self.inserted + text[self.start + len(self.removed) :]

    def undone(self, text: str) -> str:
        return text[: self.start] + self.removed + text[self.start + len(self.inserted) :]


def splice_between(before: str, after: str, label: str, renumbers: bool = True) -> Splice:
    start = _count_equal(before, after)
    end = _count_equal(before[start:][::-1], after[start:][::-1])
    return Splice(start, before[start : len(before) - end], after[start : len(after) - end], label, renumbers)


def _count_equal(before: str, after: str) -> int:
    pairs = zip(before, after, strict=False)
    return next((n for n, (a, b) in enumerate(pairs) if a != b), min(len(before), len(after)))


class Journal(BaseModel):
    """The text, the text last `saved` or read, and the edits. The first `done` edits are applied."""

    text: str
    saved: str
    edits: list[Splice] = []
    done: int = 0
    _path: Path = PrivateAttr()

    @classmethod
    def open(cls, path: Path, on_disk: str) -> "Journal":
        """Open a file's journal, or begin one; changes by another program become an edit."""
        try:
            journal = cls.model_validate_json(path.read_bytes())
        except (OSError, ValueError):
            journal = cls(text=on_disk, saved=on_disk)
        journal._path = path
        if journal.saved != on_disk:
            journal.take_from_disk(on_disk)
        return journal

    def write(self, text: str, label: str, renumbers: bool = True) -> bool:
        if text == self.text:
            return False
        edits = [*self.edits[: self.done], splice_between(self.text, text, label, renumbers)]
        self.edits = edits[-EDIT_LIMIT:]
        self.done = len(self.edits)
        self.text = text
        self._keep()
        return True

    def step(self, by: int) -> Splice | None:
        """-1: undo, 1: redo; return the edit."""
        if not 0 <= self.done + by <= len(self.edits):
            return None
        edit = self.edits[min(self.done, self.done + by)]
        self.text = edit.redone(self.text) if by > 0 else edit.undone(self.text)
        self.done += by
        self._keep()
        return edit

    def mark_saved(self) -> None:
        self.saved = self.text
        self._keep()

    def take_from_disk(self, text: str) -> None:
        self.write(text, "changed by another program")
        self.mark_saved()

    @property
    def undo_label(self) -> str | None:
        return self.edits[self.done - 1].label if self.done else None

    @property
    def redo_label(self) -> str | None:
        return self.edits[self.done].label if self.done < len(self.edits) else None

    def _keep(self) -> None:
        write_atomically(self._path, self.model_dump_json())


Stale = partial(MissionError, code="stale")  # another window or program has made a change since


class Document:
    """A file under edit; `revision` grows with every change, `autopilot` overrides a mission's."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_mission = path.suffix.lower() in MISSIONS
        self.autopilot: str | None = None
        self.revision = 1
        self.changed_outside = False
        self._renumbered_at = 1
        self._journal = Journal.open(path.with_name(f"{path.name}.studio"), read_text(path))

    @property
    def text(self) -> str:
        return self._journal.text

    def edit(self, changes: Iterable[Change], label: str, seen: int) -> bool:
        """Apply changes made on revision `seen`; return whether the text changed."""
        changes = tuple(changes)
        if seen < self._renumbered_at:
            raise Stale(f"{self.path.name} was changed elsewhere meanwhile", hint="review it, and repeat the change")
        if self.is_mission:
            text = mission_changed(self.text, self.path, changes, self.autopilot)
        else:
            text = changed(self.text, changes)
        renumbers = any(isinstance(change, Take | Add | InsertItem | ItemStep) for change in changes)
        return self._revised(self._journal.write(text, label, renumbers), renumbers)

    def rewrite(self, text: str, seen: int) -> bool:
        if seen != self.revision:
            words = f"{self.path.name} was changed elsewhere while its text was edited here"
            raise Stale(words, hint="copy your text, and reload")
        return self._revised(self._journal.write(text, "text edited"))

    def read_for(self, autopilot: str | None) -> None:
        """Set a mission's autopilot, which invalidates earlier findings."""
        self.autopilot = autopilot
        self.revision += 1

    def step(self, by: int) -> bool:
        edit = self._journal.step(by)
        return edit is not None and self._revised(True, edit.renumbers)

    def save(self, over: bool = False) -> None:
        """Write the file; raise Stale if another program changed it, unless `over`."""
        if not over and self.path.exists() and read_text(self.path) != self._journal.saved:
            self.changed_outside = True
            raise Stale(f"{self.path.name} was changed by another program", hint="save over it, or take its text")
        if not self.path.exists() or read_text(self.path) != self.text:
            has_mark = self.path.exists() and self.path.read_bytes().startswith(codecs.BOM_UTF8)
            write_atomically(self.path, codecs.BOM_UTF8 * has_mark + self.text.encode())
        self._journal.mark_saved()
        self.changed_outside = False

    def save_as(self, suffix: str) -> tuple[Path, tuple[str, ...]]:
        """Write the mission next to its file; return it and losses of its format."""
        if not self.is_mission:
            hint = "a scenario's mission files: Mission files"
            raise BadInput("expected a mission, not a scenario", hint=hint, place=self.path.name)
        autopilot = None if self.autopilot is None else autopilot_named(self.autopilot)
        file = parse_mission(self.path, self.text, autopilot)
        target = unused(self.path.with_suffix(suffix))
        return target, write_mission(file.mission, target, file)

    def look_at_disk(self) -> bool:
        """Take another program's changes if there are no own; return whether the state changed."""
        try:
            on_disk = read_text(self.path)
        except BadInput:
            return False
        if on_disk == self._journal.saved:
            return False
        if on_disk == self.text:  # the page's revision stays valid
            self._journal.mark_saved()
            self.changed_outside = False
            return True
        if self.text == self._journal.saved:
            return self.take_theirs()
        was_known = self.changed_outside
        self.changed_outside = True
        return not was_known

    def take_theirs(self) -> bool:
        self._journal.take_from_disk(read_text(self.path))
        self.changed_outside = False
        return self._revised(True)

    def as_answer(self) -> answers.Document:
        journal = self._journal
        table = dict[str, Any]()
        with suppress(BadInput):
            if not self.is_mission:  # JSON lacks dates, infinity and NaN
                table = json.loads(json.dumps(parse_table(self.text).unwrap(), default=str), parse_constant=str)
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

    def _revised(self, different: bool, renumbers: bool = True) -> bool:
        self.revision += different
        if renumbers:
            self._renumbered_at = self.revision
        return different
