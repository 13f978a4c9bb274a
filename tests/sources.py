import shutil
from pathlib import Path

from tools import REPOSITORY

PARTS = ("pyproject.toml", "README.md", "LICENSE", ".gitignore", "ipoa_mission", "missions", "tools")


def copy_sources(there: Path) -> Path:
    """Copy a wheel's sources, and an editable install's machine code."""
    leftovers = shutil.ignore_patterns("__pycache__", "node_modules", "dist")
    there.mkdir()
    for part in PARTS:
        source = REPOSITORY / part
        if source.is_dir():
            shutil.copytree(source, there / part, ignore=leftovers)
        else:
            shutil.copy(source, there / part)
    return there
