"""Parse C++ of a firmware in a git directory: functions, switches, cases, structs."""

import re
import subprocess
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


@dataclass(frozen=True)
class Source:
    git: Path
    ref: str

    def text(self, path: str) -> str:
        """Return a file of that commit without its comments; empty if it does not exist."""
        done = subprocess.run(
            ["git", "-C", str(self.git), "show", f"{self.ref}:{path}"], capture_output=True, text=True, check=False
        )
        return _COMMENT.sub("", done.stdout)

    def about(self) -> dict[str, str]:
        command = ["git", "-C", str(self.git), "log", "-1", "--format=%H %cs", self.ref]
        commit, date = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        return {"commit": commit, "date": date}


def preprocessed(text: str, false: str) -> str:
    """Return the text of a build in which every `#if` holds except those whose condition matches `false`."""
    kept, open_ = [], [True]
    for line in text.splitlines():
        word = line.strip()
        if word.startswith("#if"):
            open_.append(open_[-1] and not re.search(false, word))
        elif word.startswith("#else"):
            was = open_.pop()
            open_.append(open_[-1] and not was)
        elif word.startswith("#endif"):
            open_.pop()
        elif open_[-1]:
            kept.append(line)
    return "\n".join(kept)


def body(text: str, name: str) -> str:
    """Return the text between the braces of the function or struct that begins with `name`.

    Raises:
        SystemExit: there is none.
    """
    at = text.find(name)
    if at < 0:
        raise SystemExit(f"{name}: expected it in the source")
    return block(text, text.index("{", at))


def block(text: str, at: int) -> str:
    """Return the text between the brace at `at` and its counterpart."""
    depth = 0
    for end in range(at, len(text)):
        depth += {"{": 1, "}": -1}.get(text[end], 0)
        if depth == 0:
            return text[at + 1 : end]
    raise SystemExit("expected the counterpart of a brace")


def cases(switch: str) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield labels of a switch that share their code, and the code; `default` is a label."""
    labels: list[str] = []
    parts = re.split(r"\b(?:case\s+([\w. ]+?)|(default))\s*:(?!:)", switch)
    for case, default, code in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        labels.append(case or default)
        if code.strip().strip("{"):
            yield tuple(labels), code
            labels = []


def numbers(text: str) -> Mapping[str, int]:
    return {name: int(number) for name, number in re.findall(r"(\w+)\s*=\s*(\d+)", text)}


def listed(numbers: Iterable[int]) -> str:
    """Format numbers as in the tables.

    >>> listed((1, 4))
    '1 4'
    """
    return " ".join(map(str, numbers))
