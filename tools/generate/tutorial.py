"""Run every command of docs/tutorial.md and of the README in an empty folder, and update the output shown.

    python -m tools.generate.tutorial

Output shown in full is replaced. Where `...` replaces lines, each remaining line is found by its words, and its numbers
are updated; a line no longer printed must be corrected by hand.
"""

import os
import re
import socket
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from tools import REPOSITORY, command_line

TUTORIAL = REPOSITORY / "docs" / "tutorial.md"
README = REPOSITORY / "README.md"
PORT = "14550"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?![\w.]*\w)")
MARK = "@@@ command"
LEFT_OUT = "..."


@dataclass(frozen=True)
class Step:
    command: str
    shown: tuple[str, ...]


def steps(text: str) -> list[Step]:
    listed: list[Step] = []
    for block in re.findall(r"^```console\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, rest = part.partition("\n")
            if here := re.search(r"<<'(\w+)'", command):
                body, _, rest = rest.partition(f"\n{here[1]}\n")
                command = f"{command}\n{body}\n{here[1]}"
            listed.append(Step(command, tuple(rest.splitlines())))
    return listed


def run(commands: list[str], folder: Path, programs: Path = Path(sys.executable).parent) -> list[list[str]]:
    """Return the output of each command, run by one shell in `folder` next to `missions`, with a free port."""
    (folder / "missions").symlink_to(REPOSITORY / "missions")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    script = "exec 2>&1\n" + "".join(f"{command}\necho '{MARK}'\n" for command in commands)
    script += "jobs -p | xargs -r kill\n"
    path = os.pathsep.join((str(programs), str(Path(sys.executable).parent), os.environ["PATH"]))
    environment = {"PATH": path, "COLUMNS": "80", "NO_COLOR": "1", "XDG_STATE_HOME": str(folder)}
    command = ["bash", "-c", script.replace(PORT, port)]
    ended = subprocess.run(
        command, cwd=folder, env=os.environ | environment, capture_output=True, text=True, check=False, timeout=900
    )
    parts = ended.stdout.replace(port, PORT).split(f"{MARK}\n")
    return [part.splitlines() for part in parts[:-1]]


def words(line: str) -> str:
    """Return a line without its numbers and column widths."""
    return re.sub(r"[\s─▇]+", " ", NUMBER.sub("#", line)).strip()


def numbers(line: str) -> list[float]:
    return [float(number) for number in NUMBER.findall(line)]


def matched(step: Step, printed: list[str]) -> list[tuple[str, str]]:
    """Return each line below a command with the line printed.

    Raises:
        LookupError: a line is not printed, or not in this order.
    """
    pairs: list[tuple[str, str]] = []
    at = 0
    anywhere = False
    for line in step.shown:
        if line == LEFT_OUT:
            anywhere = True
            continue
        there = next((k for k in range(at, len(printed)) if words(printed[k]) == words(line)), None)
        if there is None or (there != at and not anywhere):
            got = "\n".join(printed)
            raise LookupError(f"$ {step.command}\ndoes not print, where it stands: {line}\nbut:\n{got}")
        pairs.append((line, printed[there]))
        at, anywhere = there + 1, False
    if not anywhere and at != len(printed) and step.shown:
        raise LookupError(f"$ {step.command}\nprints more: {printed[at]}")
    return pairs


def write(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        tutorial = steps(text)
        outputs = run([step.command for step in tutorial], Path(folder))
    position = 0
    for step, printed in zip(tutorial, outputs, strict=True):
        position = text.index(f"$ {step.command}\n", position) + len(step.command) + 3
        whole = [("\n".join(step.shown), "\n".join(printed))] if step.shown else []
        for old, new in matched(step, printed) if LEFT_OUT in step.shown else whole:
            start = text.index(f"{old}\n", position)
            text = text[:start] + new + text[start + len(old) :]
            position = start + len(new) + 1
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    for page in (README, TUTORIAL):
        write(page)
