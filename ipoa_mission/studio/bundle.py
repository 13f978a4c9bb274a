"""The built page: in a wheel it lies in the package; in a source tree it is built when it is first asked for."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

from ipoa_mission.errors import MissionError

WEB = Path(__file__).parent / "web"
BUILT = WEB / "dist"
SOURCES = ("*.ts", "*.tsx", "*.css", "*.html", "*.mjs", "package*.json")
STEPS = (("ci", "--no-audit", "--no-fund"), ("run", "build"))


def built_page(tell: Callable[[str], None]) -> Path:
    """The folder of the page; `tell` hears it if it must be built first, which takes seconds and the npm registry.

    Raises:
        MissionError: it is not built, and cannot be built here.
    """
    if (BUILT / "index.html").is_file() and not _is_stale():
        return BUILT
    npm = shutil.which("npm")
    if npm is None or not (WEB / "package.json").is_file():
        raise MissionError(
            "the studio's page is not built in this installation",
            hint="install a wheel that has it; or, in a source tree, install Node.js 18 or later with npm",
        )
    tell("building the page, once (npm ci, npm run build)")
    build_page(npm)
    return BUILT


def build_page(npm: str) -> None:
    """Build the page from its sources.

    Raises:
        MissionError: with the last lines of what went wrong.
    """
    for step in STEPS:
        if step[0] == "ci" and _has_modules():
            continue
        done = subprocess.run([npm, *step], cwd=WEB, capture_output=True, text=True, check=False)
        if done.returncode:
            last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-8:])
            raise MissionError(f"the page cannot be built: npm {' '.join(step)} says\n{last}")


def _has_modules() -> bool:
    """Whether what npm installed is as young as the list of it."""
    installed = WEB / "node_modules" / ".package-lock.json"
    return installed.is_file() and installed.stat().st_mtime >= (WEB / "package-lock.json").stat().st_mtime


def _is_stale() -> bool:
    """Whether a source is younger than what was built; an installed package has no sources."""
    sources = [file for pattern in SOURCES for file in WEB.glob(pattern)]
    return max((file.stat().st_mtime for file in sources), default=0.0) > (BUILT / "index.html").stat().st_mtime
