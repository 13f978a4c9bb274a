"""Runs every verb that reads over a folder of foreign files, and tells of each: accepted, warned, refused and why.

    python -m tools.fuzz.foreign FOLDER [--write TABLE.md] [--autopilot ardupilot] [--only PATTERN]

Missions are shown, checked, estimated and exported; logs compared; maps read as buildings, no-fly zones and flight
area; elevation models as terrain. Each run is a process of its own. It is broken where it ends in a traceback, takes
longer or more memory than it may, or refuses without words. The exit code is 1 if one is.
"""

import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ipoa_mission.cli import app
from ipoa_mission.forecast.timing import estimate  # noqa: F401  # what takes long to import is imported once
from tools import command_line
from tools.fuzz.foreign_world import read_elevation, read_map
from tools.fuzz.limited import Ended, run_limited

REFUSED_IN = 5.0  # of the processor, for what is refused [s]
LARGEST = 400.0  # what a run may take beside the program itself [MB]
MISSIONS, LOGS = {".plan", ".waypoints"}, {".tlog", ".bin", ".ulg"}
MAPS = {".geojson", ".json", ".kml", ".kmz", ".shp", ".fgb", ".gpkg"}
ELEVATIONS = {".tif", ".tiff", ".hgt", ".asc"}
REMARKS = ("note: ", "warning: ")
OUTCOMES = ("accepted", "warned", "refused", "broken")


@dataclass(frozen=True)
class Outcome:
    """What became of a file with a verb."""

    verb: str
    outcome: str
    words: str
    ended: Ended


def kind_of(path: Path) -> str:
    """`mission`, `log`, `map`, `elevation`, or nothing for a file that nobody would give to the program."""
    suffix = path.suffix.lower()
    for kind, suffixes in (("mission", MISSIONS), ("log", LOGS), ("map", MAPS), ("elevation", ELEVATIONS)):
        if suffix in suffixes:
            return kind
    if suffix == ".txt":
        beginning = path.open("rb").read(200)
        words = beginning.split(b"\n")[0].replace(b",", b" ").split()
        numbers = len(words) == 2 and all(word.lstrip(b"-").replace(b".", b"").isdigit() for word in words)
        return "mission" if beginning.startswith(b"QGC WPL") or numbers else ""
    return ""


def runs(path: Path, autopilot: str | None) -> Iterator[tuple[str, Callable[[], None]]]:
    """The verbs for a file, each as something to call."""
    kind = kind_of(path)
    if kind == "mission":
        begins = path.open("rb").read(200).lstrip()
        given = () if autopilot is None or begins.startswith(b"{") else ("--autopilot", autopilot)
        for verb in ("show", "check", "estimate"):
            yield verb, _verb(verb, str(path), *given)
        yield "export", lambda: _export(path, given)
    elif kind == "log":
        yield "compare", _verb("compare", str(path))
    elif kind == "map":
        for of in ("buildings", "no_fly", "flight_area"):
            yield of, _reader(lambda of=of: read_map(path, of))  # type: ignore[misc]
    elif kind == "elevation":
        yield "terrain", _reader(lambda: read_elevation(path))


def _verb(*words: str) -> Callable[[], None]:
    def run() -> None:
        sys.argv = ["ipoa-mission", *words]
        app.main()

    return run


def _export(path: Path, given: Sequence[str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        _verb("export", str(path), str(Path(folder) / "again.kml"), *given)()


def _reader(read: Callable[[], None]) -> Callable[[], None]:
    """A reader as a verb that tells a mistake in words."""

    def run() -> None:
        from ipoa_mission.cli.output import tell_error
        from ipoa_mission.errors import MissionError

        try:
            read()
        except MissionError as error:
            tell_error(error)
            sys.exit(error.exit_code)

    return run


def judge(verb: str, ended: Ended) -> Outcome:
    """What a run comes to."""
    lines = [*ended.err.splitlines(), *ended.out.splitlines()]
    errors = [line.partition(": ")[2] for line in lines if line.startswith("error: ")]
    remarks = [line.partition(": ")[2] for line in lines if line.startswith(REMARKS)]
    if ended.killed:
        return Outcome(verb, "broken", ended.killed, ended)
    if "Traceback" in ended.err or ended.code not in (0, 1, 2) or (ended.code and not errors):
        return Outcome(verb, "broken", (lines or ["nothing said"])[-1], ended)
    if ended.megabytes > LARGEST:
        return Outcome(verb, "broken", f"took {ended.megabytes:.0f} MB", ended)
    if ended.code and ended.seconds > REFUSED_IN:
        return Outcome(verb, "broken", f"refused only after {ended.seconds:.1f} s", ended)
    if ended.code:
        return Outcome(verb, "refused", errors[0], ended)
    return Outcome(verb, "warned" if remarks else "accepted", "; ".join(remarks), ended)


def outcomes(path: Path, autopilot: str | None, seconds: float) -> list[Outcome]:
    """What becomes of a file with each of its verbs, each within so many seconds of the processor."""
    return [judge(verb, run_limited(act, seconds)) for verb, act in runs(path, autopilot)]


def _cells(path: Path, name: str, found: Sequence[Outcome]) -> list[str]:
    """The rows of a file: verbs that came to the same stand together."""
    together: dict[tuple[str, str], list[str]] = {}
    for one in found:
        words = one.words.replace(f"{path}: ", "").replace(str(path.parent), "").replace(str(path.resolve().parent), "")
        together.setdefault((one.outcome, words.replace("|", "\\|")), []).append(one.verb)
    return [f"| {name} | {', '.join(verbs)} | {what} | {words} |" for (what, words), verbs in together.items()]


def main() -> int:
    """Run the verbs and write the table; 1 if something broke."""
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", type=Path, metavar="TABLE.md", help="write the table there, not to the terminal")
    parser.add_argument("--autopilot", choices=("px4", "ardupilot"), help="for missions that do not say")
    parser.add_argument("--only", default="*", metavar="PATTERN", help="of the files, such as '*.plan'")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the processor that a run may take")
    arguments = parser.parse_args()
    counts: dict[str, Counter[str]] = {}
    rows: list[str] = []
    left = 0
    for path in sorted(each for each in arguments.folder.rglob(arguments.only) if each.is_file()):
        found = outcomes(path, arguments.autopilot, arguments.seconds)
        print(path.name, *(f"{one.verb}: {one.outcome} {one.ended.seconds:.1f} s" for one in found), file=sys.stderr)
        left += not found
        rows += _cells(path, str(path.relative_to(arguments.folder)), found)
        for one in found:
            counts.setdefault(one.verb, Counter())[one.outcome] += 1
    table = ["| verb | " + " | ".join(OUTCOMES) + " |", "|---|" + "--:|" * len(OUTCOMES)]
    table += [f"| {verb} | " + " | ".join(str(of[each]) for each in OUTCOMES) + " |" for verb, of in counts.items()]
    table += ["", f"{left} other files", "", "| file | verbs | came to | words |", "|---|---|---|---|", *rows]
    if arguments.write:
        arguments.write.write_text("\n".join(table) + "\n", encoding="utf-8")
    print("\n".join(table[: len(counts) + 4] if arguments.write else table))
    return int(any(of["broken"] for of in counts.values()))


if __name__ == "__main__":
    sys.exit(main())
