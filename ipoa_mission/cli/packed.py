"""Scenarios that are packed with the program, to be planned by their name."""

from pathlib import Path

NAMES = ("campus",)
_PACKAGE = Path(__file__).parents[1]
#: In a wheel they are inside the package, in the repository where all missions are.
_FOLDERS = (_PACKAGE / "missions", _PACKAGE.parent / "missions")


def or_packed(path: Path) -> Path:
    """The file that was named; where there is none and the name is one of `NAMES`, the scenario of that name."""
    if str(path) not in NAMES or path.exists():
        return path
    files = [folder / f"{path}.toml" for folder in _FOLDERS]
    return next((file for file in files if file.is_file()), path)
