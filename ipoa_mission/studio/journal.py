"""Keep a text's edits in a file next to it, for undo after a restart or a crash.

Each line is a JSON object: the initial text, then splices, and marks for undo, redo and save.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ipoa_mission.files import write_atomically

SUFFIX = ".studio"
EDIT_LIMIT = 400  # kept when opened
LONGEST = 20_000_000  # [bytes]; larger ones are rewritten


@dataclass(frozen=True)
class Splice:
    """
    >>> splice_between("goal = 1", "goal = 2", "goal moved")
    Splice(start=7, removed='1', inserted='2', label='goal moved')
    """

    start: int
    removed: str
    inserted: str
    label: str

    def redone(self, text: str) -> str:
        return text[: self.start] + self.inserted + text[self.start + len(self.removed) :]

    def undone(self, text: str) -> str:
        return text[: self.start] + self.removed + text[self.start + len(self.inserted) :]


def splice_between(before: str, after: str, label: str) -> Splice:
    start = _alike(before, after)
    end = _alike(before[start:][::-1], after[start:][::-1])
    return Splice(start, before[start : len(before) - end], after[start : len(after) - end], label)


def _alike(one: str, other: str) -> int:
    return next((n for n, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))


@dataclass
class Journal:
    """The text, that last `saved` or read, and the edits, of which the first `done` are applied."""

    path: Path
    text: str
    saved: str
    edits: list[Splice] = field(default_factory=list)
    done: int = 0

    @classmethod
    def open(cls, path: Path, on_disk: str) -> "Journal":
        """Open a file's journal, or begin one. Changes by another program become an edit."""
        journal = _replayed(path) or cls(path, on_disk, on_disk)
        if journal.done > EDIT_LIMIT:
            journal._rewrite()
        if journal.saved != on_disk:
            journal.take_from_disk(on_disk)
        return journal

    def write(self, text: str, label: str) -> bool:
        if text == self.text:
            return False
        self._splice(splice := splice_between(self.text, text, label))
        self._append(asdict(splice))
        return True

    def undo(self) -> bool:
        if not self.done:
            return False
        self._step(-1)
        self._append({"step": -1})
        return True

    def redo(self) -> bool:
        if self.done == len(self.edits):
            return False
        self._step(1)
        self._append({"step": 1})
        return True

    def mark_saved(self) -> None:
        self.saved = self.text
        self._append({"saved": self.done})

    def take_from_disk(self, text: str) -> None:
        """Take another program's text as an edit that can be undone."""
        self.write(text, "changed by another program")
        self.mark_saved()

    @property
    def undo_label(self) -> str | None:
        return self.edits[self.done - 1].label if self.done else None

    @property
    def redo_label(self) -> str | None:
        return self.edits[self.done].label if self.done < len(self.edits) else None

    def _splice(self, splice: Splice) -> None:
        self.edits[self.done :] = [splice]
        self._step(1)

    def _step(self, way: int) -> None:
        if way > 0:
            self.text = self.edits[self.done].redone(self.text)
        else:
            self.text = self.edits[self.done - 1].undone(self.text)
        self.done += way

    def _append(self, line: dict[str, Any]) -> None:
        if self.path.exists():
            with self.path.open("a", encoding="utf-8", newline="\n") as file:
                file.write(json.dumps(line, ensure_ascii=False) + "\n")
        else:
            self._rewrite()

    def _rewrite(self) -> None:
        first = max(0, self.done - EDIT_LIMIT)
        text = self.text
        for splice in reversed(self.edits[first : self.done]):
            text = splice.undone(text)
        self.edits, self.done = self.edits[first:], self.done - first
        steps = [{"step": -1}] * (len(self.edits) - self.done)
        lines = [{"text": text, "saved_text": self.saved}, *map(asdict, self.edits), *steps]
        write_atomically(self.path, "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines))


def _replayed(path: Path) -> Journal | None:
    lines = _lines(path)
    first = next(lines, None)
    if first is None or "text" not in first:
        return None
    journal = Journal(path, first["text"], first.get("saved_text", first["text"]))
    for line in lines:
        if "saved" in line:
            journal.saved = journal.text
        elif "step" in line and 0 <= journal.done + line["step"] <= len(journal.edits):
            journal._step(line["step"])
        elif "start" in line:
            journal._splice(Splice(**line))
    return journal


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    if not path.is_file() or path.stat().st_size > LONGEST:
        return
    for text in path.read_text(encoding="utf-8", errors="replace").split("\n"):
        try:
            line = json.loads(text)
        except ValueError:
            return
        if not isinstance(line, dict):
            return
        yield line
