"""What was done to a text, kept in a file beside it, so that undo survives a restart and a crash loses nothing.

A line is a JSON object: first the text it began with, then a splice an edit, and marks for undo, redo and save.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ipoa_mission.files import write_atomically

SUFFIX = ".studio"
KEPT = 400  # edits that are kept when a journal is opened
LONGEST = 20_000_000  # a journal with more bytes begins anew


@dataclass(frozen=True)
class Splice:
    """At `start` the characters `removed` gave way to `inserted`.

    >>> splice_between("goal = 1", "goal = 2", "goal moved")
    Splice(start=7, removed='1', inserted='2', label='goal moved')
    """

    start: int
    removed: str
    inserted: str
    label: str

    def redone(self, text: str) -> str:
        """The text after it."""
        return text[: self.start] + self.inserted + text[self.start + len(self.removed) :]

    def undone(self, text: str) -> str:
        """The text before it."""
        return text[: self.start] + self.removed + text[self.start + len(self.inserted) :]


def splice_between(before: str, after: str, label: str) -> Splice:
    """The shortest one that leads from one text to another."""
    start = _alike(before, after)
    end = _alike(before[start:][::-1], after[start:][::-1])
    return Splice(start, before[start : len(before) - end], after[start : len(after) - end], label)


def _alike(one: str, other: str) -> int:
    """How many characters two texts have in common at their begin."""
    return next((n for n, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))


@dataclass
class Journal:
    """The text as it is now, `saved` as it was when last written or read, and the edits; `done` of them count."""

    path: Path
    text: str
    saved: str
    edits: list[Splice] = field(default_factory=list)
    done: int = 0

    @classmethod
    def open(cls, path: Path, on_disk: str) -> "Journal":
        """That of a file with the text `on_disk`: as it was left, or a new one.

        What another program wrote to the file since counts as one more edit, so that nothing of either is lost.
        """
        journal = _replayed(path) or cls(path, on_disk, on_disk)
        if journal.done > KEPT:
            journal._begin_anew()
        if journal.saved != on_disk:
            journal.take_from_disk(on_disk)
        return journal

    def write(self, text: str, label: str) -> bool:
        """Make `text` the text; whether that changed anything."""
        if text == self.text:
            return False
        self._splice(splice := splice_between(self.text, text, label))
        self._append(asdict(splice))
        return True

    def undo(self) -> bool:
        """Take the last edit back; whether there was one."""
        if not self.done:
            return False
        self._step(-1)
        self._append({"step": -1})
        return True

    def redo(self) -> bool:
        """Do the edit again that was taken back last; whether there was one."""
        if self.done == len(self.edits):
            return False
        self._step(1)
        self._append({"step": 1})
        return True

    def mark_saved(self) -> None:
        """The text is on the disk now."""
        self.saved = self.text
        self._append({"saved": self.done})

    def take_from_disk(self, text: str) -> None:
        """Another program has written this text to the file: it becomes the text, by an edit that can be undone."""
        self.write(text, "changed by another program")
        self.mark_saved()

    @property
    def undo_label(self) -> str | None:
        """What undo would take back."""
        return self.edits[self.done - 1].label if self.done else None

    @property
    def redo_label(self) -> str | None:
        """What redo would do again."""
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
            self._begin_anew()

    def _begin_anew(self) -> None:
        """Write the journal whole, with the youngest edits only."""
        first = max(0, self.done - KEPT)
        text = self.text
        for splice in reversed(self.edits[first : self.done]):
            text = splice.undone(text)
        self.edits, self.done = self.edits[first:], self.done - first
        steps = [{"step": -1}] * (len(self.edits) - self.done)
        lines = [{"text": text, "saved_text": self.saved}, *map(asdict, self.edits), *steps]
        write_atomically(self.path, "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines))


def _replayed(path: Path) -> Journal | None:
    """The journal in a file; None where there is none that makes sense. A line that was cut off is the last."""
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
