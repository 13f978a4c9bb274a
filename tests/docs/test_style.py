import re
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
WIDTH = 120
TEST_NAME = 70  # characters
#: British forms, and their quotations.
BRITISH = re.compile(
    r"(?<!ekf3 still )(?<!system not )"
    r"(?:mini|maxi|opti|organ|recogn|summar|normal|initial|lineari|seriali)(?:mis|is)(?:e|ed|es|er|ing|ation)\b"
    r"|colour|neighbour|behaviour|favour|honour|\bgrey\b|(?<!sports_)centre|modelled|travelled|labelled(?!by)|\blicence\b"
)
METRE = re.compile(r"(?<![a-z])(?:kilo|centi|milli)?metres?(?![a-z])")
#: They read the units of others' files.
READ_UNITS = {
    *("ipoa_mission/maps/lengths.py", "ipoa_mission/maps/elevation.py", "ipoa_mission/maps/tag_heights.py"),
    *("ipoa_mission/maps/geozones.py", "tests/maps/test_elevation.py", "tests/maps/test_heights.py"),
    "tests/maps/test_wind_files.py",
}
QUOTED = re.compile(r'"(?:\d+ )?metres?(?: per second)?"|"[^"]*metres (?:centi|milli|kilo)?meter[^"]*"')
WRITTEN = {".py", ".md", ".js", ".ts", ".tsx", ".css", ".html", ".toml"}


def written() -> list[Path]:
    if not (REPOSITORY / ".git").exists():  # an archive has nothing else in it
        made = {".venv", "dist", "node_modules"}  # by an installation, of what others wrote too
        listed = [path for path in REPOSITORY.rglob("*") if not made & set(path.parts) and path.is_file()]
    else:
        names = subprocess.run(["git", "ls-files"], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout
        listed = [REPOSITORY / name for name in names.splitlines()]
    return [path for path in listed if path.suffix in WRITTEN and path.exists() and path != Path(__file__)]


FILES = written()


@pytest.mark.parametrize(
    "path", [p for p in FILES if p.suffix == ".md"], ids=lambda p: p.relative_to(REPOSITORY).as_posix()
)
def test_lines_of_markdown_fit_unless_they_cannot_be_broken(path: Path) -> None:
    """Tables, code, and long words cannot be broken."""
    fenced = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced and not line.startswith("|") and " " in line.strip():
            assert len(line) <= WIDTH, f"{path.name}:{number}: {len(line)} columns"


def test_the_spelling_is_american() -> None:
    spellings = {
        f"{path.relative_to(REPOSITORY).as_posix()}: {match[0]}"
        for path in FILES
        for match in BRITISH.finditer(path.read_text(encoding="utf-8").lower())
    }
    assert not spellings


def test_a_length_is_in_meters() -> None:
    """In names, messages and prose; a quoted unit in a file of `READ_UNITS` is an input."""
    lengths = [
        f"{name}:{number}: {match[0]}"
        for path in FILES
        if (name := path.relative_to(REPOSITORY).as_posix()) != "CHANGELOG.md"
        for number, line in enumerate(path.read_text(encoding="utf-8").lower().splitlines(), 1)
        for match in METRE.finditer(QUOTED.sub("", line) if name in READ_UNITS else line)
    ]
    assert not lengths


def test_pages_beside_the_lab_records_have_a_greatest_length() -> None:
    aside = {"lab", "reproduction", "reproduction.md"}
    pages = [page for page in (REPOSITORY / "docs").rglob("*.md") if not aside & set(page.parts)]
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in pages) <= 35_000


def test_a_test_has_a_short_name() -> None:
    long_names = [
        f"{path.relative_to(REPOSITORY).as_posix()}: {len(name)}: {name}"
        for path in FILES
        if path.suffix == ".py" and path.relative_to(REPOSITORY).parts[0] == "tests"
        for name in re.findall(r"\bdef (test_\w+)", path.read_text(encoding="utf-8"))
        if len(name) > TEST_NAME
    ]
    assert not long_names


def test_a_test_file_does_not_repeat_its_folder() -> None:
    """`tests/cli/test_files.py`, not `tests/cli/test_cli_files.py`."""
    tests = REPOSITORY / "tests"
    repeated = {
        path.relative_to(tests).as_posix()
        for path in tests.glob("*/test_*.py")
        if path.name.startswith((f"test_{path.parent.name}_", f"test_{path.parent.name.removesuffix('s')}_"))
    }
    assert not repeated


def test_contributing_names_every_helper_of_the_tests() -> None:
    text = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
    helpers = {path.stem for path in (REPOSITORY / "tests").glob("[!_]*.py") if not path.stem.startswith("test_")}
    assert helpers <= set(re.findall(r"`(\w+)[.`]", text))
